//! Where on the globe does a plan lie? Fitted to points that are known on both, or said by somebody.
//!
//! points on the plan and on the globe ─▶ [`fit`]: turn, place and scale by least squares ─▶ [`Fit`]: how far each is off, who lies
//! world file, size of the picture     ─▶ [`WorldFile::control`]: its corners as such points ─┘
//! anchor and bearing, or the grid of the plan's own metres ─▶ [`Georeference`]
//!
//! Source: Umeyama 1991 (least squares of similarities; in the plane it is one complex division). The ground is a transverse
//! Mercator map around the points: metres, neither stretched nor bent over a site.
//! Pitfalls: latitude first, as people and web maps write it; files have longitude first. Among few points, one that lies bends the
//! fit towards itself and looks like the others: it is told by what the others say without it.

mod crs;
mod world_file;

use planwalk_types::{Building, Georeference, Plan, Pt2};

use super::native::{Placed, PlacedPoint};
use super::projection::{self, LocalMap, NoPlace, Point};
pub use crs::{Crs, CrsError};
pub use world_file::{WorldFile, WorldFileError};

/// Points nearer together than this give no direction, metres.
const NEAREST_M: f64 = 1.0;
/// A point that is off by more is told, metres: a mistaken corner, not an unsteady hand.
const WORST_M: f64 = 1.0;
/// A hand is not steadier than this, metres; below it, nobody lies.
const STEADY_M: f64 = 0.05;
/// An honest point is called a liar this rarely: as 3 sigma of a normal distribution.
const RARE: f64 = 0.0027;
/// Scales of plan and points may differ by this share before it is told.
const SCALES_DIFFER: f64 = 0.03;

/// A point that is known on the plan and on the globe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlPoint {
    /// On the plan, metres.
    pub plan: Pt2<Plan>,
    /// On the globe, WGS 84.
    pub longitude_deg: f64,
    /// Likewise.
    pub latitude_deg: f64,
}

/// Where a plan lies by some points.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Its place; [`Georeference::scale`] is what the points imply of the plan's metres.
    pub place: Georeference,
    /// How far each point is from where the plan puts it, metres on the ground.
    pub off_m: Vec<f64>,
    /// Standard deviation of a coordinate; `None` for two points, which always fit.
    pub sigma_m: Option<f64>,
    /// The point that the others contradict, if one does.
    pub suspect: Option<Suspect>,
}

/// A point that the others contradict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suspect {
    /// Its place in the list, from 0.
    pub index: usize,
    /// How far it is from where the others put it, metres.
    pub off_m: f64,
    /// Standard deviation of the others.
    pub others_sigma_m: f64,
}

/// Why points do not place a plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeoreferenceError {
    /// One point has no direction.
    #[error("{got} points do not place a plan: give at least 2, better 3 or more, far apart")]
    TooFew {
        /// Points given.
        got: usize,
    },
    /// Points at one place.
    #[error("the points lie within {spread_m:.2} m on the plan or on the ground, which gives no direction: choose some far apart")]
    TooNear {
        /// From their middle to the farthest.
        spread_m: f64,
    },
    /// A point that is nowhere.
    #[error("point {number} (counted from 1) is no place: latitude must be within ±85°, longitude within ±180°, metres finite")]
    NoPoint {
        /// Counted from 1.
        number: usize,
    },
    /// Metres that are none.
    #[error(
        "by these points a metre of the plan is {scale:.3} m on the ground: is the plan's own scale right, and is latitude given \
         before longitude?"
    )]
    Scale {
        /// What follows.
        scale: f64,
    },
    /// A picture in a mirror.
    #[error(
        "the points fit the plan's mirror image ({mirrored_m:.2} m off) and not the plan ({off_m:.1} m off): is latitude given before \
         longitude, and is v counted from the top?"
    )]
    Mirrored {
        /// Standard deviation of the plan's fit.
        off_m: f64,
        /// That of its mirror image.
        mirrored_m: f64,
    },
    /// A place that is none.
    #[error(transparent)]
    NoPlace(#[from] NoPlace),
    /// A grid that does not reach there.
    #[error("the plan's middle ({x:.0}, {y:.0}) is not on the grid of {grid}: are its metres that grid's?")]
    OffGrid {
        /// Easting, as taken.
        x: f64,
        /// Northing.
        y: f64,
        /// Name of the coordinate system.
        grid: String,
    },
}

/// Places a plan by points that are known on both.
///
/// # Errors
/// [`GeoreferenceError`].
pub fn fit(points: &[ControlPoint]) -> Result<Fit, GeoreferenceError> {
    if points.len() < 2 {
        return Err(GeoreferenceError::TooFew { got: points.len() });
    }
    if let Some(at) = points.iter().position(|point| !is_point(point)) {
        return Err(GeoreferenceError::NoPoint { number: at + 1 });
    }
    let (map, pairs) = pairs(points);
    let whole = Similarity::of(&pairs, None);
    let spread_m = whole.spread_m;
    if !(spread_m > NEAREST_M) {
        return Err(GeoreferenceError::TooNear { spread_m });
    }
    let off_m: Vec<f64> = pairs.iter().map(|pair| whole.off(pair)).collect();
    let sigma_m = sigma(&off_m, 4);
    check_mirror(&pairs, sigma_m)?;
    let scale = whole.scale();
    let [longitude_deg, latitude_deg] = map.degrees(whole.ground_middle);
    let anchor = Pt2::new(whole.plan_middle[0], whole.plan_middle[1]);
    let place = Georeference { longitude_deg: wrapped(longitude_deg), latitude_deg, bearing_rad: whole.bearing_rad(), anchor, scale };
    if !projection::is_place(&Georeference { scale: 1.0, ..place }) {
        return Err(NoPlace(place).into());
    }
    if !projection::is_place(&place) {
        return Err(GeoreferenceError::Scale { scale });
    }
    Ok(Fit { place, suspect: suspect(&pairs, &off_m), off_m, sigma_m })
}

/// Places a plan whose (0, 0) is there, and whose y axis has this bearing: degrees from north, clockwise.
///
/// # Errors
/// [`NoPlace`].
pub fn anchored(latitude_deg: f64, longitude_deg: f64, bearing_deg: f64) -> Result<Georeference, NoPlace> {
    let place = Georeference::at_origin(longitude_deg, latitude_deg, bearing_deg.to_radians());
    if projection::is_place(&place) { Ok(place) } else { Err(NoPlace(place)) }
}

/// Places a building whose metres are those of a grid.
///
/// # Errors
/// [`GeoreferenceError::OffGrid`].
pub fn on_grid(building: &Building, crs: Crs) -> Result<Georeference, GeoreferenceError> {
    let points = || building.levels.iter().flat_map(|level| &level.elements).flat_map(|element| element.form.points());
    let low = points().fold([f64::INFINITY; 2], |low, p| [low[0].min(p.x), low[1].min(p.y)]);
    let high = points().fold([f64::NEG_INFINITY; 2], |high, p| [high[0].max(p.x), high[1].max(p.y)]);
    let [x, y] = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
    let place = crs.grid().and_then(|grid| projection::on_grid(grid, [x, y]));
    place.ok_or_else(|| GeoreferenceError::OffGrid { x, y, grid: crs.to_string() })
}

/// Longitude and latitude, degrees, of a point of a plan that lies there.
pub fn degrees(place: &Georeference, point: Pt2<Plan>) -> [f64; 2] {
    projection::degrees(place, point)
}

impl Fit {
    /// As a plan file keeps it.
    pub fn kept(&self, from: String, points: &[ControlPoint]) -> Placed {
        let point = |(point, off_m): (&ControlPoint, &f64)| PlacedPoint {
            plan: point.plan,
            longitude_deg: point.longitude_deg,
            latitude_deg: point.latitude_deg,
            off_m: *off_m,
        };
        Placed { from, points: points.iter().zip(&self.off_m).map(point).collect() }
    }

    /// What a person should know: a line on the whole, one for each point, and what is wrong.
    pub fn words(&self, points: &[ControlPoint]) -> Vec<String> {
        let scale = self.place.scale;
        let sigma =
            self.sigma_m.map_or("two points always fit: a third would tell a mistake".to_owned(), |sigma| format!("sigma {sigma:.2} m"));
        let mut words = vec![format!("{} points, {sigma}; by them a metre of the plan is {scale:.4} m on the ground", points.len())];
        for (number, (point, off_m)) in (1..).zip(points.iter().zip(&self.off_m)) {
            let (x, y) = (point.plan.x, point.plan.y);
            words.push(format!("point {number} at ({x:.2}, {y:.2}) m: {off_m:.2} m off"));
        }
        if (scale - 1.0).abs() > SCALES_DIFFER {
            words.push(format!(
                "warning: the points and the plan's own scale disagree by {:.1} %: measure something on the plan, and read it again with \
                 its scale times {scale:.4} if the points are right",
                100.0 * (scale - 1.0).abs()
            ));
        }
        if let Some(suspect) = &self.suspect {
            words.push(format!(
                "warning: point {} is {:.2} m from where the others put it (their sigma is {:.2} m): is it mistaken?",
                suspect.index + 1,
                suspect.off_m,
                suspect.others_sigma_m
            ));
        }
        words
    }
}

/// One line on where a plan lies.
pub fn words(place: &Georeference) -> String {
    let scale = if place.scale == 1.0 { String::new() } else { format!(", a metre of it is {:.5} m on the ground", place.scale) };
    format!(
        "the plan's ({:.2}, {:.2}) is at latitude {:.7}°, longitude {:.7}°; its y axis points {:.2}° clockwise from north{scale}",
        place.anchor.x,
        place.anchor.y,
        place.latitude_deg,
        place.longitude_deg,
        // Rounded first: what is as good as north is 0.
        (100.0 * place.bearing_rad.to_degrees()).round().rem_euclid(36_000.0) / 100.0
    )
}

fn is_point(point: &ControlPoint) -> bool {
    let at = Georeference { anchor: point.plan, ..Georeference::at_origin(point.longitude_deg, point.latitude_deg, 0.0) };
    projection::is_place(&at)
}

/// Across ±180° and back.
fn wrapped(longitude_deg: f64) -> f64 {
    if longitude_deg.abs() <= 180.0 { longitude_deg } else { (longitude_deg + 180.0).rem_euclid(360.0) - 180.0 }
}

/// A point on the plan and on the ground, metres.
type Pair = (Point, Point);

/// The points on a map around them.
fn pairs(points: &[ControlPoint]) -> (LocalMap, Vec<Pair>) {
    let first = points.first().map_or(0.0, |point| point.longitude_deg);
    // Points on either side of ±180° are near each other.
    let unwrapped = |longitude: f64| longitude - 360.0 * ((longitude - first) / 360.0).round();
    let globe: Vec<Point> = points.iter().map(|p| [unwrapped(p.longitude_deg), p.latitude_deg]).collect();
    let map = LocalMap::around(mean(globe.iter().copied()));
    (map, points.iter().zip(globe).map(|(point, globe)| ([point.plan.x, point.plan.y], map.metres(globe))).collect())
}

fn mean(points: impl ExactSizeIterator<Item = Point>) -> Point {
    let count = points.len().max(1) as f64;
    let sum = points.fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
    sum.map(|s| s / count)
}

/// Ground = middle + factor · (plan − middle), all of them complex numbers.
#[derive(Debug, Clone, Copy)]
struct Similarity {
    plan_middle: Point,
    ground_middle: Point,
    factor: Point,
    /// From the middle to the farthest point, on the plan or the ground, whichever is less.
    spread_m: f64,
}

impl Similarity {
    /// By least squares; with a scale that is known, or a free one.
    fn of(pairs: &[Pair], scale: Option<f64>) -> Self {
        let plan_middle = mean(pairs.iter().map(|pair| pair.0));
        let ground_middle = mean(pairs.iter().map(|pair| pair.1));
        let (mut product, mut square, mut spread) = ([0.0; 2], 0.0, [0.0f64; 2]);
        for (plan, ground) in pairs {
            let [x, y] = [plan[0] - plan_middle[0], plan[1] - plan_middle[1]];
            let [east, north] = [ground[0] - ground_middle[0], ground[1] - ground_middle[1]];
            product = [product[0] + x * east + y * north, product[1] + x * north - y * east];
            square += x * x + y * y;
            spread = [spread[0].max(x.hypot(y)), spread[1].max(east.hypot(north))];
        }
        let length = product[0].hypot(product[1]);
        let by = scale.map_or(1.0 / square, |scale| scale / length);
        Self { plan_middle, ground_middle, factor: product.map(|p| p * by), spread_m: spread[0].min(spread[1]) }
    }

    fn scale(&self) -> f64 {
        self.factor[0].hypot(self.factor[1])
    }

    /// Of the plan's y axis.
    fn bearing_rad(&self) -> f64 {
        -self.factor[1].atan2(self.factor[0])
    }

    fn ground(&self, plan: Point) -> Point {
        let [x, y] = [plan[0] - self.plan_middle[0], plan[1] - self.plan_middle[1]];
        let [a, b] = self.factor;
        [self.ground_middle[0] + a * x - b * y, self.ground_middle[1] + a * y + b * x]
    }

    /// Distance on the ground between where a point is and where the plan puts it.
    fn off(&self, (plan, ground): &Pair) -> f64 {
        let [east, north] = self.ground(*plan);
        (east - ground[0]).hypot(north - ground[1])
    }
}

/// Standard deviation of a coordinate after a fit of so many parameters; `None` where nothing is left to tell it.
fn sigma(off_m: &[f64], parameters: usize) -> Option<f64> {
    let freedom = (2 * off_m.len()).checked_sub(parameters).filter(|freedom| *freedom > 0)?;
    Some((off_m.iter().map(|off| off * off).sum::<f64>() / freedom as f64).sqrt())
}

fn check_mirror(pairs: &[Pair], sigma_m: Option<f64>) -> Result<(), GeoreferenceError> {
    let mirrored: Vec<Pair> = pairs.iter().map(|(plan, ground)| ([-plan[0], plan[1]], *ground)).collect();
    let fit = Similarity::of(&mirrored, None);
    let off_m: Vec<f64> = mirrored.iter().map(|pair| fit.off(pair)).collect();
    match (sigma_m, sigma(&off_m, 4)) {
        // Points on a line fit both.
        (Some(off_m), Some(mirrored_m)) if off_m > WORST_M && mirrored_m < off_m / 3.0 => {
            Err(GeoreferenceError::Mirrored { off_m, mirrored_m })
        }
        _ => Ok(()),
    }
}

/// The point without which the others agree best, if it is then too far from where they put it.
///
/// Two points agree on any place and scale: of three, the plan's own scale has to tell who lies.
fn suspect(pairs: &[Pair], off_m: &[f64]) -> Option<Suspect> {
    if pairs.len() < 3 {
        return None;
    }
    let (scale, parameters) = if pairs.len() == 3 { (Some(1.0), 3) } else { (None, 4) };
    let without = |index: usize| {
        let others: Vec<Pair> = pairs.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, pair)| *pair).collect();
        let fit = Similarity::of(&others, scale);
        let sigma_m = sigma(&others.iter().map(|pair| fit.off(pair)).collect::<Vec<_>>(), parameters)?;
        let pair = pairs.get(index)?;
        let suspect = Suspect { index, off_m: fit.off(pair), others_sigma_m: sigma_m };
        let doubt = doubt(&others, pair.0);
        (suspect.off_m.is_finite() && sigma_m.is_finite()).then_some((suspect, doubt))
    };
    let (found, doubt) = (0..pairs.len()).filter_map(without).min_by(|a, b| a.0.others_sigma_m.total_cmp(&b.0.others_sigma_m))?;
    let freedom = (2 * (pairs.len() - 1) - parameters) as f64;
    // Off², in sigmas² of two coordinates, has Fisher's distribution: P(F > f) = (1 + 2 f / ν)^(−ν/2) for two and ν degrees of
    // freedom. The unluckiest of all points is asked, hence the share.
    let share = RARE / pairs.len() as f64;
    let sigmas = (doubt * freedom * (share.powf(-2.0 / freedom) - 1.0)).sqrt();
    let rare = pairs.len() > 3 && found.off_m > (sigmas * found.others_sigma_m).max(STEADY_M);
    let far = off_m.iter().any(|off| *off > WORST_M);
    (rare || far).then_some(found)
}

/// Variance of a point about where others put it, in variances of one point's coordinate: its own, their mean's, and what their turn
/// and scale leave open as far away as it is.
fn doubt(others: &[Pair], plan: Point) -> f64 {
    let middle = mean(others.iter().map(|pair| pair.0));
    let square = |at: Point| (at[0] - middle[0]).powi(2) + (at[1] - middle[1]).powi(2);
    let spread: f64 = others.iter().map(|pair| square(pair.0)).sum();
    1.0 + 1.0 / others.len() as f64 + if spread > 0.0 { square(plan) / spread } else { 0.0 }
}

#[cfg(test)]
mod tests;

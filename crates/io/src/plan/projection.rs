//! How do coordinates become metres, and metres coordinates? As they are, or on a map that is true around the site.
//!
//! The map is a transverse Mercator around the first point's meridian ([`super::mercator`]): a site is neither stretched nor bent on
//! it (1e-8 of its size a kilometre from the meridian). Plans in the metres of a UTM zone keep them, and their place is known.
//! Pitfalls: GeoJSON (RFC 7946) knows degrees only, and much of what is written as GeoJSON is in metres all the same. Web
//! Mercator's metres are none: at 53° north they are 0.6 m long.

use planwalk_types::{Georeference, Plan, Pt2};

use super::mercator::{TransverseMercator, Utm};
use super::notation;

/// East and north: degrees or metres.
pub(super) type Point = [f64; 2];

/// Radius of the sphere of Web Mercator.
const WEB_RADIUS_M: f64 = 6_378_137.0;
/// A site is never this wide, degrees (3 km): numbers within ±180 that spread farther are metres.
const WIDEST_SITE_DEG: f64 = 0.03;
/// Farthest from the equator that a plan is placed, degrees: as web maps. Nearer to a pole, meridians turn on the map.
const HIGHEST_LATITUDE_DEG: f64 = 85.0;
/// Metres on the ground in one of a plan: beyond this it is no plan of that ground.
const SCALES: std::ops::RangeInclusive<f64> = 0.5..=2.0;
/// Length over which a grid's north and scale are measured, metres.
const BASELINE_M: f64 = 100.0;

/// A georeference that cannot be one.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "longitude {}°, latitude {}°, bearing {} rad, scale {} is no place for a plan: they must be within ±180°, ±85°, a whole turn, and 0.5 to 2",
    .0.longitude_deg, .0.latitude_deg, .0.bearing_rad, .0.scale
)]
pub struct NoPlace(pub Georeference);

/// Whether plans are put there.
pub(super) fn is_place(at: &Georeference) -> bool {
    // Written so that what is not a number is refused too.
    let turn = std::f64::consts::TAU;
    at.longitude_deg.abs() <= 180.0
        && at.latitude_deg.abs() <= HIGHEST_LATITUDE_DEG
        && at.bearing_rad.abs() <= turn
        && SCALES.contains(&at.scale)
        && notation::is_near(at.anchor)
}

/// Longitude and latitude, degrees, of a point of a plan that lies there: [`Projection::metres`] backwards.
///
/// Beyond ±180° numbers go on, so that a building on that meridian stays in one piece.
pub(super) fn degrees(plan: &Georeference, point: Pt2<Plan>) -> Point {
    let (s, c) = plan.bearing_rad.sin_cos();
    let (x, y) = (plan.scale * (point.x - plan.anchor.x), plan.scale * (point.y - plan.anchor.y));
    LocalMap::around([plan.longitude_deg, plan.latitude_deg]).degrees([x * c + y * s, y * c - x * s])
}

/// A map whose (0, 0) is at a place, and whose y axis points north there.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalMap {
    map: TransverseMercator,
    /// Of the place, from the equator, metres.
    north_m: f64,
}

impl LocalMap {
    /// The map around a longitude and latitude.
    pub(super) fn around([meridian_deg, latitude_deg]: Point) -> Self {
        let map = TransverseMercator { meridian_deg };
        Self { map, north_m: map.metres([meridian_deg, latitude_deg])[1] }
    }

    /// Metres east and north.
    pub(super) fn metres(&self, point: Point) -> Point {
        let [east, north] = self.map.metres(point);
        [east, north - self.north_m]
    }

    /// Longitude and latitude.
    pub(super) fn degrees(&self, [east, north]: Point) -> Point {
        self.map.degrees([east, north + self.north_m])
    }
}

/// Where a plan lies whose metres are those of a UTM zone, seen from this point of it; `None` where the grid does not reach.
pub(super) fn on_grid(grid: Utm, [x, y]: Point) -> Option<Georeference> {
    let [longitude_deg, latitude_deg] = grid.degrees([x, y])?;
    let map = LocalMap::around([longitude_deg, latitude_deg]);
    let [below, above] = [-0.5, 0.5].map(|half| grid.degrees([x, y + half * BASELINE_M]).map(|at| map.metres(at)));
    let (below, above) = (below?, above?);
    let (east, north) = (above[0] - below[0], above[1] - below[1]);
    let (bearing_rad, scale) = (east.atan2(north), east.hypot(north) / BASELINE_M);
    let place = Georeference { longitude_deg, latitude_deg, bearing_rad, anchor: Pt2::new(x, y), scale };
    is_place(&place).then_some(place)
}

/// What the numbers of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Metres,
    Degrees,
    /// EPSG:3857.
    WebMercator,
    /// Metres, of a grid of which the place is known.
    Grid(Utm),
}

/// Turns a file's coordinates into metres.
pub(super) struct Projection {
    unit: Unit,
    place: Option<Georeference>,
    map: LocalMap,
}

impl Projection {
    /// By the name of the coordinate system, where there is one, and by the numbers; with a note for people.
    pub(super) fn of(crs: Option<&str>, in_metres: bool, points: &[Point], notes: &mut Vec<String>) -> Self {
        let unit = unit(crs, in_metres, points);
        let name = crs.unwrap_or("no coordinate system is named");
        let first = points.first().copied().unwrap_or_default();
        let origin = if unit == Unit::WebMercator { degrees_of_web_mercator(first) } else { first };
        let [longitude, latitude] = origin;
        let place = match unit {
            Unit::Metres => None,
            Unit::Grid(grid) => on_grid(grid, middle(points)),
            Unit::Degrees | Unit::WebMercator => Some(Georeference::at_origin(longitude, latitude, 0.0)),
        };
        notes.push(match (unit, &place) {
            (Unit::Grid(grid), Some(place)) => format!(
                "coordinates are metres of UTM zone {} ({name}); the plan keeps them; its middle is at {:.7}, {:.7}",
                grid.name(),
                place.longitude_deg,
                place.latitude_deg
            ),
            (Unit::Grid(grid), None) => {
                format!("coordinates are taken as metres; UTM zone {} ({name}) does not reach there", grid.name())
            }
            (Unit::Metres, _) if !in_metres && is_degrees(&code(crs)) => {
                format!("coordinates are taken as metres, though {name} counts in degrees: most lie beyond 360 and 90; the plan keeps them")
            }
            (Unit::Metres, _) => format!("coordinates are taken as metres ({name}); the plan keeps them"),
            (Unit::Degrees | Unit::WebMercator, _) => {
                format!(
                    "coordinates are taken from the globe ({name}); the plan's origin is its first point, {longitude:.7}, {latitude:.7}"
                )
            }
        });
        Self { unit, place, map: LocalMap::around(origin) }
    }

    /// Where the plan is; `None` where the file's metres do not say.
    pub(super) fn georeference(&self) -> Option<Georeference> {
        self.place
    }

    /// Metres on the plan.
    pub(super) fn metres(&self, point: Point) -> Point {
        match self.unit {
            Unit::Metres | Unit::Grid(_) => point,
            Unit::Degrees => self.map.metres(point),
            Unit::WebMercator => self.map.metres(degrees_of_web_mercator(point)),
        }
    }
}

/// Middle of what the points span.
fn middle(points: &[Point]) -> Point {
    [0, 1].map(|k| {
        let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        0.5 * (low + high)
    })
}

/// Number of a coordinate system, or its short name.
fn code(crs: Option<&str>) -> String {
    crs.unwrap_or("").rsplit(':').next().unwrap_or("").to_ascii_uppercase()
}

fn unit(crs: Option<&str>, in_metres: bool, points: &[Point]) -> Unit {
    let code = &code(crs);
    if in_metres {
        return Unit::Metres;
    }
    match code.as_str() {
        "3857" | "900913" | "102100" => return Unit::WebMercator,
        _ if is_degrees(code) && could_be_degrees(points) => return Unit::Degrees,
        _ => {}
    }
    if let Some(grid) = Utm::of_epsg(code) {
        return Unit::Grid(grid);
    }
    let range = |k: usize| points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
    let (x, y) = (range(0), range(1));
    let on_globe = x.0 >= -180.0 && x.1 <= 180.0 && y.0 >= -90.0 && y.1 <= 90.0;
    let narrow = x.1 - x.0 <= WIDEST_SITE_DEG && y.1 - y.0 <= WIDEST_SITE_DEG;
    if on_globe && narrow && crs.is_none() { Unit::Degrees } else { Unit::Metres }
}

/// Whether a coordinate system counts in degrees.
fn is_degrees(code: &str) -> bool {
    matches!(code, "4326" | "4258" | "4979" | "CRS84" | "CRS84H")
}

/// Whether most points are on the globe. Programs that know no other coordinate system write the name of this one over metres.
fn could_be_degrees(points: &[Point]) -> bool {
    2 * points.iter().filter(|[x, y]| x.abs() <= 360.0 && y.abs() <= 90.0).count() >= points.len()
}

fn degrees_of_web_mercator([x, y]: Point) -> Point {
    [(x / WEB_RADIUS_M).to_degrees(), (y / WEB_RADIUS_M).sinh().atan().to_degrees()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    fn of(crs: Option<&str>, points: &[Point]) -> Projection {
        Projection::of(crs, false, points, &mut Vec::new())
    }

    #[test]
    fn metres_stay_and_degrees_become_metres() {
        let utm = [[566_600.0, 5_932_800.0], [566_601.0, 5_932_801.0]];
        assert_eq!(of(Some("urn:ogc:def:crs:EPSG::32632"), &utm).metres(utm[1]), utm[1]);
        // A flat of 12 m × 9 m that somebody drew in metres.
        assert_eq!(of(None, &[[0.0, 0.0], [12.0, 9.0]]).metres([12.0, 9.0]), [12.0, 9.0]);
        // A degree at 53.54° north: 111.3 km of meridian, 66.3 km of parallel.
        let degrees = [[10.0, 53.54], [10.01, 53.55]];
        let [x, y] = of(None, &degrees).metres(degrees[1]);
        assert!((x - 663.0).abs() < 1.0 && (y - 1113.0).abs() < 1.0, "{x}, {y}");
        assert_eq!(of(Some("urn:ogc:def:crs:OGC:1.3:CRS84"), &degrees).metres(degrees[0]), [0.0, 0.0]);
    }

    #[test]
    fn metres_that_are_called_degrees_stay_metres() {
        let utm = [[566_600.0, 5_932_800.0], [566_601.0, 5_932_801.0], [12.0, 9.0]];
        let mut notes = Vec::new();
        let projection = Projection::of(Some("urn:ogc:def:crs:OGC:1.3:CRS84"), false, &utm, &mut notes);
        assert_eq!(projection.metres(utm[1]), utm[1]);
        assert!(projection.georeference().is_none() && notes[0].contains("though"), "{notes:?}");
    }

    #[test]
    fn a_grids_metres_stay_and_say_where_they_are() {
        // Hamburg lies 1° east of the middle of zone 32: its grid north is 0.8° east of north, and its metres are 0.35 ‰ too long.
        let utm = [[566_600.0, 5_932_800.0], [566_700.0, 5_932_900.0]];
        let projection = of(Some("urn:ogc:def:crs:EPSG::32632"), &utm);
        assert_eq!(projection.metres(utm[1]), utm[1]);
        let place = projection.georeference().unwrap();
        assert!((place.longitude_deg - 10.0).abs() < 0.02 && (place.latitude_deg - 53.54).abs() < 0.01, "{place:?}");
        // Convergence is Δλ · sin φ, the grid's scale 0.9996 · (1 + x²/2R²).
        let convergence = (place.longitude_deg - 9.0).to_radians() * place.latitude_deg.to_radians().sin();
        let grid = 0.9996 * (1.0 + (66_650.0f64 / 6_384_000.0).powi(2) / 2.0);
        assert!((place.bearing_rad - convergence).abs() < 1e-5 && (place.scale * grid - 1.0).abs() < 1e-6, "{place:?}");
        // Every corner is where the grid has it, to a tenth of a millimetre.
        let grid = Utm::of_epsg("32632").unwrap();
        for corner in utm {
            let [easting, northing] = grid.metres(degrees(&place, Pt2::new(corner[0], corner[1])));
            assert!((easting - corner[0]).hypot(northing - corner[1]) < 1e-4, "{easting}, {northing}");
        }
        assert_eq!(of(Some("EPSG:32632"), &[[1e8, 0.0]]).georeference(), None);
    }

    #[test]
    fn web_mercator_is_shrunk_to_true_metres() {
        let north = WEB_RADIUS_M * (53.54f64.to_radians().tan()).asinh();
        let points = [[1_113_194.0, north], [1_113_294.0, north]];
        let [x, _] = of(Some("EPSG:3857"), &points).metres(points[1]);
        // cos 53.54° = 0.594, and the ellipsoid's radius there is 0.2 % over the sphere's.
        assert!((x - 100.0 * 53.54f64.to_radians().cos() * 1.0022).abs() < 0.05, "{x}");
    }
    proptest! {
        #[test]
        fn metres_that_go_to_the_globe_come_back(
            (longitude_deg, latitude_deg) in (-180.0..180.0, -85.0..85.0),
            bearing_rad in -TAU..TAU,
            (x, y) in (-1500.0..1500.0, -1500.0..1500.0),
        ) {
            let place = Georeference::at_origin(longitude_deg, latitude_deg, bearing_rad);
            prop_assert!(is_place(&place));
            let [east, north] = LocalMap::around([longitude_deg, latitude_deg]).metres(degrees(&place, Pt2::new(x, y)));
            // East and north, turned back: x lies clockwise of y, and y at the bearing.
            let (s, c) = bearing_rad.sin_cos();
            let error = (east * c - north * s - x).hypot(east * s + north * c - y);
            // What the series leave out is 0.1 µm, and a degree's last digit at 180 is 3 nm.
            prop_assert!(error < 1e-6, "{error} m");
        }
    }

    #[test]
    fn the_bearing_is_where_the_plans_top_points() {
        // A plan whose top is east: what lies up is east, what lies right is south.
        let place = Georeference::at_origin(10.0, 53.5, std::f64::consts::FRAC_PI_2);
        // The parallel bends away from a straight line by x²/2R · tan φ: 1 mm over 100 m.
        let [longitude, latitude] = degrees(&place, Pt2::new(0.0, 100.0));
        assert!(longitude > 10.001 && (latitude - 53.5).abs() < 1.1e-8, "{longitude}, {latitude}");
        assert!(degrees(&place, Pt2::new(100.0, 0.0))[1] < 53.4995);
    }

    #[test]
    fn poles_and_what_is_no_number_are_no_places() {
        for (longitude_deg, latitude_deg, bearing_rad) in
            [(0.0, 90.0, 0.0), (181.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (0.0, 0.0, f64::INFINITY)]
        {
            assert!(!is_place(&Georeference::at_origin(longitude_deg, latitude_deg, bearing_rad)));
        }
    }
}

//! How do coordinates become metres, and metres coordinates? As they are, or on a plane that touches the earth at the site.
//!
//! The plane's scale is that of the WGS 84 ellipsoid's radii of curvature (prime vertical, meridian) at the first point; a
//! kilometre from it, between the polar circles, a metre is still one to half a millimetre.
//! Pitfalls: GeoJSON (RFC 7946) knows degrees only, and much of what is written as GeoJSON is in metres all the same. Web
//! Mercator's metres are none: at 53° north they are 0.6 m long.

use planwalk_types::{Georeference, Plan, Pt2};

/// East and north: degrees or metres.
pub(super) type Point = [f64; 2];

const EQUATOR_RADIUS_M: f64 = 6_378_137.0;
const ECCENTRICITY_2: f64 = 0.006_694_379_990_14;
/// A site is never this wide, degrees (3 km): numbers within ±180 that spread farther are metres.
const WIDEST_SITE_DEG: f64 = 0.03;

/// Farthest from the equator that a plan is placed, degrees: as web maps. Nearer to a pole, meridians turn on the plane.
const HIGHEST_LATITUDE_DEG: f64 = 85.0;

/// A georeference that cannot be one.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "longitude {}°, latitude {}°, bearing {} rad is no place for a plan: they must be within ±180°, ±85° and a whole turn",
    .0.longitude_deg, .0.latitude_deg, .0.bearing_rad
)]
pub struct NoPlace(pub Georeference);

/// Whether plans are put there.
pub(super) fn is_place(at: &Georeference) -> bool {
    // Written so that what is not a number is refused too.
    let turn = std::f64::consts::TAU;
    at.longitude_deg.abs() <= 180.0 && at.latitude_deg.abs() <= HIGHEST_LATITUDE_DEG && at.bearing_rad.abs() <= turn
}

/// Longitude and latitude, degrees, of a point of a plan that lies there: [`Projection::metres`] backwards.
///
/// Beyond ±180° numbers go on, so that a building on that meridian stays in one piece.
pub(super) fn degrees(plan: &Georeference, point: Pt2<Plan>) -> Point {
    let (s, c) = plan.bearing_rad.sin_cos();
    let (east, north) = (point.x * c + point.y * s, point.y * c - point.x * s);
    let [across, along] = metres_per_radian(plan.latitude_deg);
    [plan.longitude_deg + (east / across).to_degrees(), plan.latitude_deg + (north / along).to_degrees()]
}

/// Metres of a radian of longitude and of latitude.
fn metres_per_radian(latitude_deg: f64) -> [f64; 2] {
    let (s, c) = latitude_deg.to_radians().sin_cos();
    let w = 1.0 - ECCENTRICITY_2 * s * s;
    [EQUATOR_RADIUS_M / w.sqrt() * c, EQUATOR_RADIUS_M * (1.0 - ECCENTRICITY_2) / (w * w.sqrt())]
}

/// What the numbers of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Metres,
    Degrees,
    /// EPSG:3857.
    WebMercator,
}

/// Turns a file's coordinates into metres.
pub(super) struct Projection {
    unit: Unit,
    /// Longitude and latitude of the plan's origin, degrees; only where the file is not in metres.
    origin_deg: Point,
}

impl Projection {
    /// By the name of the coordinate system, where there is one, and by the numbers; with a note for people.
    pub(super) fn of(crs: Option<&str>, in_metres: bool, points: &[Point], notes: &mut Vec<String>) -> Self {
        let unit = unit(crs, in_metres, points);
        let name = crs.unwrap_or("no coordinate system is named");
        let first = points.first().copied().unwrap_or_default();
        let projection = Self { unit, origin_deg: if unit == Unit::WebMercator { degrees_of_web_mercator(first) } else { first } };
        let [longitude, latitude] = projection.origin_deg;
        notes.push(match unit {
            Unit::Metres => format!("coordinates are taken as metres ({name}); the plan keeps them"),
            Unit::Degrees | Unit::WebMercator => {
                format!(
                    "coordinates are taken from the globe ({name}); the plan's origin is its first point, {longitude:.7}, {latitude:.7}"
                )
            }
        });
        projection
    }

    /// Where the plan's origin is; `None` where the file's metres do not say.
    pub(super) fn georeference(&self) -> Option<Georeference> {
        let [longitude_deg, latitude_deg] = self.origin_deg;
        (self.unit != Unit::Metres).then_some(Georeference { longitude_deg, latitude_deg, bearing_rad: 0.0 })
    }

    /// Metres on the plan.
    pub(super) fn metres(&self, point: Point) -> Point {
        let [longitude, latitude] = match self.unit {
            Unit::Metres => return point,
            Unit::Degrees => point,
            Unit::WebMercator => degrees_of_web_mercator(point),
        };
        let [across, along] = metres_per_radian(self.origin_deg[1]);
        [across * (longitude - self.origin_deg[0]).to_radians(), along * (latitude - self.origin_deg[1]).to_radians()]
    }
}

fn unit(crs: Option<&str>, in_metres: bool, points: &[Point]) -> Unit {
    let name = crs.unwrap_or("").to_ascii_uppercase();
    let code = name.rsplit(':').next().unwrap_or("");
    if in_metres {
        return Unit::Metres;
    }
    match code {
        "3857" | "900913" | "102100" => return Unit::WebMercator,
        "4326" | "4258" | "4979" | "CRS84" | "CRS84H" => return Unit::Degrees,
        _ => {}
    }
    let range = |k: usize| points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
    let (x, y) = (range(0), range(1));
    let on_globe = x.0 >= -180.0 && x.1 <= 180.0 && y.0 >= -90.0 && y.1 <= 90.0;
    let narrow = x.1 - x.0 <= WIDEST_SITE_DEG && y.1 - y.0 <= WIDEST_SITE_DEG;
    if on_globe && narrow && crs.is_none() { Unit::Degrees } else { Unit::Metres }
}

fn degrees_of_web_mercator([x, y]: Point) -> Point {
    [(x / EQUATOR_RADIUS_M).to_degrees(), (y / EQUATOR_RADIUS_M).sinh().atan().to_degrees()]
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
    fn web_mercator_is_shrunk_to_true_metres() {
        let north = EQUATOR_RADIUS_M * (53.54f64.to_radians().tan()).asinh();
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
            let place = Georeference { longitude_deg, latitude_deg, bearing_rad };
            prop_assert!(is_place(&place));
            let globe = Projection { unit: Unit::Degrees, origin_deg: [longitude_deg, latitude_deg] };
            let [east, north] = globe.metres(degrees(&place, Pt2::new(x, y)));
            // East and north, turned back: x lies clockwise of y, and y at the bearing.
            let (s, c) = bearing_rad.sin_cos();
            let error = (east * c - north * s - x).hypot(east * s + north * c - y);
            // A degree's last digit at 180 is 3 nm.
            prop_assert!(error < 1e-7, "{error} m");
        }
    }

    #[test]
    fn the_bearing_is_where_the_plans_top_points() {
        // A plan whose top is east: what lies up is east, what lies right is south.
        let place = Georeference { longitude_deg: 10.0, latitude_deg: 53.5, bearing_rad: std::f64::consts::FRAC_PI_2 };
        let [longitude, latitude] = degrees(&place, Pt2::new(0.0, 100.0));
        assert!(longitude > 10.001 && (latitude - 53.5).abs() < 1e-9, "{longitude}, {latitude}");
        assert!(degrees(&place, Pt2::new(100.0, 0.0))[1] < 53.4995);
    }

    #[test]
    fn poles_and_what_is_no_number_are_no_places() {
        for (longitude_deg, latitude_deg, bearing_rad) in
            [(0.0, 90.0, 0.0), (181.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (0.0, 0.0, f64::INFINITY)]
        {
            assert!(!is_place(&Georeference { longitude_deg, latitude_deg, bearing_rad }));
        }
    }
}

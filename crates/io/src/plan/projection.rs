//! How do coordinates become metres? As they are, or from longitude and latitude on a plane that touches the earth at the site.
//!
//! The plane's scale is that of the WGS 84 ellipsoid's radii of curvature (prime vertical, meridian) at the first point; a
//! kilometre from it, between the polar circles, a metre is still one to half a millimetre.
//! Pitfalls: GeoJSON (RFC 7946) knows degrees only, and much of what is written as GeoJSON is in metres all the same. Web
//! Mercator's metres are none: at 53° north they are 0.6 m long.

use super::vector::Point;

const EQUATOR_RADIUS_M: f64 = 6_378_137.0;
const ECCENTRICITY_2: f64 = 0.006_694_379_990_14;
/// A site is never this wide, degrees (3 km): numbers within ±180 that spread farther are metres.
const WIDEST_SITE_DEG: f64 = 0.03;

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

    /// Metres on the plan.
    pub(super) fn metres(&self, point: Point) -> Point {
        let [longitude, latitude] = match self.unit {
            Unit::Metres => return point,
            Unit::Degrees => point,
            Unit::WebMercator => degrees_of_web_mercator(point),
        };
        let (s, c) = self.origin_deg[1].to_radians().sin_cos();
        let w = 1.0 - ECCENTRICITY_2 * s * s;
        let (across, along) = (EQUATOR_RADIUS_M / w.sqrt(), EQUATOR_RADIUS_M * (1.0 - ECCENTRICITY_2) / (w * w.sqrt()));
        [across * c * (longitude - self.origin_deg[0]).to_radians(), along * (latitude - self.origin_deg[1]).to_radians()]
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
}

//! Where on the globe is a point of a map's grid? Transverse Mercator on the WGS 84 ellipsoid, both ways, and the UTM zones on it.
//!
//! latitude ─▶ conformal latitude ─▶ sphere's transverse Mercator ─▶ Krüger's series ─▶ metres east and north
//!
//! Source: Krüger 1912 as given by Karney 2011 ("Transverse Mercator with an accuracy of a few nanometers"), eqs. 7–36, to the
//! fourth order of the third flattening: 0.1 µm from the middle meridian, under a millimetre 3000 km away from it.
//! Pitfalls: grid metres are none on the ground: a UTM zone is 0.04 % too short in its middle, and its grid north is up to 3° off at
//! its rim. ETRS89 has moved 0.8 m from WGS 84 since 1989 (with the continent): they are taken as the same.

use super::projection::Point;

const EQUATOR_RADIUS_M: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Third flattening.
const N: f64 = FLATTENING / (2.0 - FLATTENING);
/// A quarter of a meridian, as the radius of a circle.
const RECTIFYING_RADIUS_M: f64 = EQUATOR_RADIUS_M / (1.0 + N) * (1.0 + N * N / 4.0 + N * N * N * N / 64.0);
/// From the sphere to the ellipsoid (Karney 2011, eq. 35).
const FORWARD: [f64; 4] = [
    N * (1.0 / 2.0 - N * (2.0 / 3.0 - N * (5.0 / 16.0 + N * 41.0 / 180.0))),
    N * N * (13.0 / 48.0 - N * (3.0 / 5.0 - N * 557.0 / 1440.0)),
    N * N * N * (61.0 / 240.0 - N * 103.0 / 140.0),
    N * N * N * N * 49_561.0 / 161_280.0,
];
/// And back (eq. 36).
const BACKWARD: [f64; 4] = [
    N * (1.0 / 2.0 - N * (2.0 / 3.0 - N * (37.0 / 96.0 - N / 360.0))),
    N * N * (1.0 / 48.0 + N * (1.0 / 15.0 - N * 437.0 / 1440.0)),
    N * N * N * (17.0 / 480.0 - N * 37.0 / 840.0),
    N * N * N * N * 4397.0 / 161_280.0,
];
/// Newton's steps to a latitude; each squares the error of 1e-3 that it begins with.
const STEPS: usize = 4;
/// Scale in the middle of a UTM zone, and the easting of that.
const UTM_SCALE: f64 = 0.9996;
const UTM_EASTING_M: f64 = 500_000.0;
/// What southern zones add to the northing.
const UTM_SOUTH_M: f64 = 10_000_000.0;

fn eccentricity() -> f64 {
    (FLATTENING * (2.0 - FLATTENING)).sqrt()
}

/// The map around a meridian: metres, true on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TransverseMercator {
    /// The middle meridian, degrees.
    pub meridian_deg: f64,
}

impl TransverseMercator {
    /// Metres east of the meridian and north of the equator of a longitude and latitude in degrees. On the meridian's far side of
    /// the globe, and at the poles, numbers are meaningless, but finite or not a number.
    pub fn metres(&self, [longitude, latitude]: Point) -> Point {
        let (sin_l, cos_l) = (longitude - self.meridian_deg).to_radians().sin_cos();
        let t = conformal(latitude.to_radians().tan());
        let (x, y) = ((sin_l / t.hypot(cos_l)).asinh(), t.atan2(cos_l));
        let [dx, dy] = series(&FORWARD, [x, y]);
        [RECTIFYING_RADIUS_M * (x + dx), RECTIFYING_RADIUS_M * (y + dy)]
    }

    /// Longitude and latitude, degrees, of metres east of the meridian and north of the equator.
    pub fn degrees(&self, [east, north]: Point) -> Point {
        let (x, y) = (east / RECTIFYING_RADIUS_M, north / RECTIFYING_RADIUS_M);
        let [dx, dy] = series(&BACKWARD, [x, y]);
        let (x, (sin_y, cos_y)) = (x - dx, (y - dy).sin_cos());
        let latitude = geographic(sin_y / x.sinh().hypot(cos_y)).atan();
        [self.meridian_deg + x.sinh().atan2(cos_y).to_degrees(), latitude.to_degrees()]
    }
}

/// Tangent of the conformal latitude from that of the geographic one (eqs. 7, 9).
fn conformal(tan: f64) -> f64 {
    let e = eccentricity();
    let s = (e * (e * tan / tan.hypot(1.0)).atanh()).sinh();
    tan * s.hypot(1.0) - s * tan.hypot(1.0)
}

/// And back, by Newton's method (eqs. 19–21).
fn geographic(conformal_tan: f64) -> f64 {
    let e2 = FLATTENING * (2.0 - FLATTENING);
    let mut tan = conformal_tan / (1.0 - e2);
    for _ in 0..STEPS {
        let off = conformal(tan);
        let slope = (1.0 + (1.0 - e2) * tan * tan) / ((1.0 - e2) * tan.hypot(1.0));
        let step = (conformal_tan - off) / off.hypot(1.0) * slope;
        // Near a pole the tangent is as good as infinite.
        if !step.is_finite() {
            break;
        }
        tan += step;
    }
    tan
}

/// What the series adds at a point of the sphere's map.
fn series(coefficients: &[f64; 4], [x, y]: Point) -> Point {
    let term = |(k, a): (f64, &f64)| [a * (k * y).cos() * (k * x).sinh(), a * (k * y).sin() * (k * x).cosh()];
    let terms = [2.0, 4.0, 6.0, 8.0].into_iter().zip(coefficients).map(term);
    terms.fold([0.0; 2], |sum, [dx, dy]| [sum[0] + dx, sum[1] + dy])
}

/// A zone of the Universal Transverse Mercator grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Utm {
    /// From 1 at 180° west, 6° each.
    pub zone: u8,
    /// Whether its northings are of the southern half.
    pub south: bool,
}

impl Utm {
    /// The zone of an EPSG code: WGS 84 326zz and 327zz, ETRS89 258zz.
    pub fn of_epsg(code: &str) -> Option<Self> {
        let number: u32 = code.parse().ok()?;
        let (zone, south) = match number {
            32_601..=32_660 => (number - 32_600, false),
            32_701..=32_760 => (number - 32_700, true),
            25_828..=25_838 => (number - 25_800, false),
            _ => return None,
        };
        Some(Self { zone: u8::try_from(zone).ok()?, south })
    }

    /// What people call it: 32N.
    pub fn name(self) -> String {
        format!("{}{}", self.zone, if self.south { 'S' } else { 'N' })
    }

    fn map(self) -> TransverseMercator {
        TransverseMercator { meridian_deg: 6.0 * f64::from(self.zone) - 183.0 }
    }

    /// Longitude and latitude, degrees, of an easting and a northing; `None` where the grid does not reach: eastings from 100 to
    /// 900 km, which is beyond the rims of all zones. Metres of a plan's own that were taken for a grid's are less.
    pub fn degrees(self, [easting, northing]: Point) -> Option<Point> {
        let north = if self.south { northing - UTM_SOUTH_M } else { northing };
        let on_grid = (100_000.0..=900_000.0).contains(&easting) && north.abs() <= UTM_SOUTH_M;
        on_grid.then(|| self.map().degrees([(easting - UTM_EASTING_M) / UTM_SCALE, north / UTM_SCALE]))
    }

    /// Easting and northing of a longitude and latitude in degrees.
    #[cfg(test)]
    pub fn metres(self, point: Point) -> Point {
        let [east, north] = self.map().metres(point);
        [UTM_EASTING_M + UTM_SCALE * east, UTM_SCALE * north + if self.south { UTM_SOUTH_M } else { 0.0 }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn meridians_are_as_long_as_the_ellipsoids() {
        // Simpson's rule over the meridian's radius of curvature, in steps of 0.01°.
        let e2 = FLATTENING * (2.0 - FLATTENING);
        let radius = |latitude: f64| EQUATOR_RADIUS_M * (1.0 - e2) / (1.0 - e2 * latitude.to_radians().sin().powi(2)).powf(1.5);
        let step = 0.01f64.to_radians();
        let mut length_m = 0.0;
        for i in 0..8900 {
            let from = 0.01 * f64::from(i);
            length_m += step / 6.0 * (radius(from) + 4.0 * radius(from + 0.005) + radius(from + 0.01));
            let [x, y] = TransverseMercator { meridian_deg: 9.0 }.metres([9.0, from + 0.01]);
            // The first order that is left out is 5e-14 of the radius; summing up loses some nanometres.
            assert!(x.abs() < 1e-6 && (y - length_m).abs() < 1e-6, "{x}, {y} m, not {length_m} at {from}°");
        }
    }

    #[test]
    fn a_known_tower_stands_where_gazetteers_have_it() {
        // The CN Tower, 43° 38′ 33.24″ N, 79° 23′ 13.7″ W, is at 630 084 m E, 4 833 438 m N of zone 17; 0.01″ are 0.3 m.
        let tower = [-(79.0 + 23.0 / 60.0 + 13.7 / 3600.0), 43.0 + 38.0 / 60.0 + 33.24 / 3600.0];
        let [easting, northing] = Utm::of_epsg("32617").unwrap().metres(tower);
        assert!((easting - 630_084.0).abs() < 1.0 && (northing - 4_833_438.0).abs() < 1.0, "{easting}, {northing}");
    }

    #[test]
    fn zones_are_known_by_their_codes() {
        for (code, name) in [("32632", "32N"), ("25832", "32N"), ("32701", "1S"), ("32660", "60N")] {
            assert_eq!(Utm::of_epsg(code).unwrap().name(), name);
        }
        for code in ["", "4326", "3857", "32600", "32661", "32761", "31467", "99999999999", "-32632"] {
            assert_eq!(Utm::of_epsg(code), None, "{code}");
        }
        let zone = Utm { zone: 32, south: false };
        for off in [[1e9, 5e6], [5e5, 2e7], [f64::NAN, 0.0], [5e5, f64::INFINITY]] {
            assert_eq!(zone.degrees(off), None, "{off:?}");
        }
    }

    proptest! {
        #[test]
        fn metres_come_back_as_the_same_degrees(longitude in -7.0f64..7.0, latitude in -84.0f64..84.0, meridian_deg in -180.0f64..180.0) {
            let map = TransverseMercator { meridian_deg };
            let [lon, lat] = map.degrees(map.metres([meridian_deg + longitude, latitude]));
            // 1e-12° are 0.1 µm; the order left out is of that size.
            prop_assert!((lon - meridian_deg - longitude).abs() < 2e-11 && (lat - latitude).abs() < 2e-12, "{lon}, {lat}");
        }

        #[test]
        fn angles_are_kept(longitude in -6.0f64..6.0, latitude in -84.0f64..84.0) {
            // Steps of the same length on the ground, to the east and to the north, are of one length and at right angles.
            let e2 = FLATTENING * (2.0 - FLATTENING);
            let w2 = 1.0 - e2 * latitude.to_radians().sin().powi(2);
            let parallel = latitude.to_radians().cos();
            let map = TransverseMercator { meridian_deg: 0.0 };
            let (east, north) = (1e-4 / parallel, 1e-4 * w2 / (1.0 - e2));
            let step = |dx: f64, dy: f64| {
                let (a, b) = (map.metres([longitude - dx, latitude - dy]), map.metres([longitude + dx, latitude + dy]));
                [b[0] - a[0], b[1] - a[1]]
            };
            let (east, north) = (step(east, 0.0), step(0.0, north));
            let length = east[0].hypot(east[1]);
            // Central differences over 22 m err by 1e-10, round-off at 1e7 m by 1e-9.
            prop_assert!((east[0] - north[1]).abs() < 1e-8 * length && (east[1] + north[0]).abs() < 1e-8 * length, "{east:?}, {north:?}");
        }

        #[test]
        fn zones_come_back(zone in 1u8..=60, south: bool, easting in 1e5f64..9e5, northing in 1e5f64..9e6) {
            let zone = Utm { zone, south };
            let [x, y] = zone.metres(zone.degrees([easting, northing]).unwrap());
            prop_assert!((x - easting).abs() < 1e-6 && (y - northing).abs() < 1e-6, "{x}, {y}");
        }
    }
}

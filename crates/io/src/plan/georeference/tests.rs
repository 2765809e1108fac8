//! Places are found again, and lies are named.

use proptest::prelude::*;

use super::*;

/// Points of a plan, put on the globe by a place.
fn known(place: &Georeference, points: &[(f64, f64)]) -> Vec<ControlPoint> {
    let point = |(x, y): &(f64, f64)| {
        let plan = Pt2::new(*x, *y);
        let [longitude_deg, latitude_deg] = degrees(place, plan);
        ControlPoint { plan, longitude_deg: wrapped(longitude_deg), latitude_deg }
    };
    points.iter().map(point).collect()
}

/// Distance on the ground between where two places put a point, metres.
fn apart(a: &Georeference, b: &Georeference, point: Pt2<Plan>) -> f64 {
    let ([longitude, latitude], other) = (degrees(a, point), degrees(b, point));
    let [east, north] = LocalMap::around([longitude, latitude]).metres(other);
    // Numbers beyond ±180° are the same place.
    let turn = (other[0] - longitude).abs() > 180.0;
    if turn {
        apart(a, &Georeference { longitude_deg: b.longitude_deg - 360.0 * b.longitude_deg.signum(), ..*b }, point)
    } else {
        east.hypot(north)
    }
}

fn place(longitude_deg: f64, latitude_deg: f64, bearing_deg: f64, scale: f64) -> Georeference {
    Georeference { scale, ..Georeference::at_origin(longitude_deg, latitude_deg, bearing_deg.to_radians()) }
}

fn places() -> impl Strategy<Value = Georeference> {
    (-180.0f64..180.0, -70.0f64..70.0, -180.0f64..180.0, 0.9f64..1.1).prop_map(|(lon, lat, bearing, scale)| place(lon, lat, bearing, scale))
}

/// Corners of a site 120 m wide, and two points inside.
const SITE: [(f64, f64); 6] = [(0.0, 0.0), (120.0, 5.0), (110.0, 70.0), (-5.0, 80.0), (40.0, 30.0), (70.0, 55.0)];

proptest! {
    #[test]
    fn a_place_is_found_again_by_its_points(truth in places(), points in prop::collection::vec((-200.0f64..200.0, -200.0f64..200.0), 2..12)) {
        let known = known(&truth, &points);
        let (_, pairs) = pairs(&known);
        prop_assume!(Similarity::of(&pairs, None).spread_m > 2.0);
        let found = fit(&known).unwrap();
        // The maps around the origin and around the points are alike to 1e-9, and so are degrees: 1 cm is the task's.
        for (x, y) in points {
            let error = apart(&found.place, &truth, Pt2::new(x, y));
            prop_assert!(error < 0.01, "{error} m");
        }
        prop_assert!(found.off_m.iter().all(|off| *off < 0.01) && found.suspect.is_none(), "{found:?}");
    }

    #[test]
    fn of_six_points_the_one_that_lies_is_named(truth in places(), liar in 0usize..6, way in 0.0f64..std::f64::consts::TAU, far in 2.0f64..40.0, hands in prop::collection::vec((-0.1f64..0.1, -0.1f64..0.1), 6)) {
        // Hands are off by up to 10 cm, the liar by metres.
        let mut points = known(&truth, &SITE);
        for (at, (dx, dy)) in hands.iter().enumerate() {
            let plan = &mut points[at].plan;
            *plan = Pt2::new(plan.x + dx, plan.y + dy);
        }
        let lie = &mut points[liar].plan;
        *lie = Pt2::new(lie.x + far * way.cos(), lie.y + far * way.sin());
        let found = fit(&points).unwrap();
        let suspect = found.suspect.unwrap();
        prop_assert_eq!(suspect.index, liar);
        // How far it is from where the others put it: what it lied, and what they err there.
        prop_assert!((suspect.off_m / (far * truth.scale) - 1.0).abs() < 0.25, "{} m, lied {far} m", suspect.off_m);
        let told = format!("warning: point {} is", liar + 1);
        let words = found.words(&points);
        prop_assert!(words.iter().any(|word| word.contains(&told)), "{words:?}");
    }
}

#[test]
fn honest_hands_are_hardly_ever_called_liars() {
    // Sums of twelve uniform numbers are normal enough; 20 cm, 1000 fits of six points.
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut normal = || 0.2 * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0);
    let truth = place(10.0, 53.5, 30.0, 1.0);
    let (mut accused, mut variance) = (0, 0.0);
    for _ in 0..1000 {
        let mut points = known(&truth, &SITE);
        for point in &mut points {
            point.plan = Pt2::new(point.plan.x + normal(), point.plan.y + normal());
        }
        let found = fit(&points).unwrap();
        accused += usize::from(found.suspect.is_some());
        variance += found.sigma_m.unwrap().powi(2) / 1000.0;
    }
    // 0.27 % of 1000 are 3, and at most 3 + 4 · √3; points are not quite normal, and the best of six is not any of them.
    assert!(accused <= 10, "{accused} of 1000");
    // Eight degrees of freedom in each fit: the mean of 1000 variances is within 4 · √(2 / 8000) of the truth.
    assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.04, "sigma {}", variance.sqrt());
}

#[test]
fn of_three_points_the_plans_own_scale_tells_who_lies() {
    let mut points = known(&place(-79.4, 43.6, 200.0, 1.0), &SITE[..3]);
    points[1].plan = Pt2::new(points[1].plan.x - 6.0, points[1].plan.y + 2.0);
    let suspect = fit(&points).unwrap().suspect.unwrap();
    assert_eq!(suspect.index, 1);
}

#[test]
fn a_wrong_scale_is_told_and_two_points_are_said_to_prove_nothing() {
    let points = known(&place(10.0, 53.5, 30.0, 1.05), &SITE[..2]);
    let found = fit(&points).unwrap();
    assert!((found.place.scale - 1.05).abs() < 1e-6 && found.sigma_m.is_none());
    let words = found.words(&points).join("\n");
    assert!(words.contains("disagree by 5.0 %") && words.contains("two points always fit"), "{words}");
}

#[test]
fn what_gives_no_place_is_refused_with_the_reason() {
    let truth = place(10.0, 53.5, 30.0, 1.0);
    let error = |points: &[ControlPoint]| fit(points).unwrap_err().to_string();
    let points = known(&truth, &SITE);
    assert!(error(&points[..1]).contains("at least 2") && error(&[]).contains("0 points"));
    assert!(error(&[points[0], points[0]]).contains("no direction"));
    assert!(error(&known(&place(10.0, 53.5, 0.0, 3.0), &SITE)).contains("3.000 m on the ground"));
    // Latitude and longitude changed over: stretched, and in a mirror.
    let swapped: Vec<ControlPoint> =
        points.iter().map(|p| ControlPoint { plan: p.plan, longitude_deg: p.latitude_deg, latitude_deg: p.longitude_deg }).collect();
    assert!(error(&swapped).contains("before longitude"), "{}", error(&swapped));
    let down: Vec<ControlPoint> = points.iter().map(|p| ControlPoint { plan: Pt2::new(p.plan.x, -p.plan.y), ..*p }).collect();
    assert!(error(&down).contains("mirror image"), "{}", error(&down));
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let nowhere = ControlPoint { latitude_deg: bad, ..points[1] };
        assert!(error(&[points[0], nowhere]).contains("point 2"), "{bad}");
        let nowhere = ControlPoint { plan: Pt2::new(bad, 0.0), ..points[1] };
        assert!(error(&[points[0], nowhere]).contains("point 2"), "{bad}");
    }
    assert!(anchored(91.0, 0.0, 0.0).is_err() && anchored(0.0, 0.0, f64::NAN).is_err());
}

#[test]
fn an_anchor_and_a_bearing_are_taken_as_said() {
    let place = anchored(53.5, 10.0, 90.0).unwrap();
    // The plan's top is east.
    let [longitude, latitude] = degrees(&place, Pt2::new(0.0, 100.0));
    assert!(longitude > 10.001 && (latitude - 53.5).abs() < 1e-6, "{longitude}, {latitude}");
    assert!(words(&place).contains("90.00° clockwise from north"), "{}", words(&place));
}

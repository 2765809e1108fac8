//! Do the pictures of a scored walk say what the scores say?

use nalgebra::Matrix3;
use planwalk::evaluate::odometry::pairs;
use planwalk::evaluate::{Alignment, AssociateOptions, Curves, PlaceOptions, curves};
use planwalk::figure::{CalibrationPicture, ErrorPicture, OverlayPicture, png_of};
use planwalk::tables::upright;
use planwalk::types::{Estimate, PlanPose, Stamp, Status};

fn estimates(off_m: f64) -> Vec<Estimate> {
    let estimate = |i: i64| Estimate {
        stamp: Stamp(i * 500_000_000),
        pose: PlanPose::new(0.5 * i as f64, off_m + if i < 10 { 8.0 } else { 0.0 }, 0.0),
        covariance: Matrix3::identity() * 0.2,
        radius95_m: 1.1,
        probability: 1.0,
        status: if i < 12 { Status::Ambiguous } else { Status::Tracking },
        scale: None,
    };
    (0..60).map(estimate).collect()
}

fn truth() -> Vec<(Stamp, PlanPose)> {
    (0..60).map(|i| (Stamp(i * 500_000_000), PlanPose::new(0.5 * i as f64, 0.0, 0.0))).collect()
}

/// All words of a drawing, as those hear them who do not see it.
fn words(svg: &str) -> Vec<&str> {
    svg.split("aria-label=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

#[test]
fn error_and_calibration_are_drawn_for_both_answers() {
    let curves = curves(&estimates(0.1), &estimates(0.3), &truth(), &PlaceOptions::default()).unwrap();
    let error = ErrorPicture { title: "a walk", curves: &curves, right_m: 1.0 }.svg();
    let said = words(&error);
    for word in [
        "a walk",
        "walked / m",
        "error / m",
        "as it went",
        "claimed 95 % radius",
        "median error of the whole walk 0.10 m, as it went 0.30 m",
    ] {
        assert!(said.contains(&word), "{word:?} is not among {said:?}");
    }
    let calibration = CalibrationPicture { title: "a walk", curves: &curves }.svg();
    assert!(words(&calibration).contains(&"as it went") && png_of(&calibration).is_ok() && png_of(&error).is_ok());
    let only = Curves { filter: Vec::new(), ..curves };
    assert!(!words(&ErrorPicture { title: "a", curves: &only, right_m: 1.0 }.svg()).contains(&"as it went"));
}

#[test]
fn pictures_of_nothing_are_still_pictures() {
    let none = Curves::default();
    let error = ErrorPicture { title: "nothing", curves: &none, right_m: 1.0 }.svg();
    let calibration = CalibrationPicture { title: "nothing", curves: &none }.svg();
    assert!(words(&calibration).contains(&"no region was claimed"));
    let overlay = OverlayPicture { title: "nothing", subtitle: "", pairs: &[] }.svg();
    for svg in [error, calibration, overlay] {
        assert!(!svg.contains("NaN") && !svg.contains("inf") && png_of(&svg).is_ok());
    }
}

#[test]
fn an_odometry_is_drawn_over_the_truth() {
    let of = |poses: Vec<(Stamp, PlanPose)>| poses.into_iter().map(|(s, p)| (s, upright(&p))).collect::<Vec<_>>();
    let estimate = of(truth().into_iter().map(|(s, p)| (s, PlanPose::new(0.5 * p.x, 0.01 * p.x * p.x, 0.0))).collect());
    let aligned = pairs(&estimate, &of(truth()), Alignment::Sim2, &AssociateOptions::default()).unwrap();
    let svg = OverlayPicture { title: "a walk", subtitle: "ATE", pairs: &aligned.pairs }.svg();
    assert!(words(&svg).contains(&"odometry, aligned") && png_of(&svg).is_ok());
}

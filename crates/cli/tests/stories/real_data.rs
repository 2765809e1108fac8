//! Real video, real robots, real plans: the claims of the README on data that nobody simulated.

use std::fs;
use std::path::Path;

use planwalk::result::ResultFile;
use planwalk::types::{IntrinsicsSource, PlanPose, Status, wrap_angle};

use crate::support::{data, errors, folder, planwalk, read_track, truth_of_camera};

const CORRIDOR: &str = "icsl_square3_corridor_walk";

/// `planwalk COMMAND` on the corridor clip.
fn corridor(command: &str, clip: &Path, out: &Path) -> assert_cmd::Command {
    let mut run = planwalk();
    run.arg(command).arg(clip.join("rgb")).args(["--fps", "12", "--camera"]).arg(clip.join("camera.yaml"));
    run.arg("--quiet").arg("-o").arg(out);
    run
}

fn result(out: &Path) -> ResultFile {
    serde_json::from_str(&fs::read_to_string(out.join("result.json")).unwrap()).unwrap()
}

#[test]
fn the_corridor_walk_is_followed_on_its_plan_from_its_start() {
    let Some(clip) = data(CORRIDOR) else { return };
    let dir = folder();
    let out = dir.path().join("out");
    corridor("locate", &clip, &out).arg("--plan").arg(clip.join("derived/map_walls.yaml")).args(["--start", "0,0,0"]).assert().success();
    let track = read_track(&out.join("track.csv"));
    let errors = errors(&track, &truth_of_camera(&clip.join("derived/truth_12fps.tum")));
    assert_eq!((track.len(), errors.compared), (220, 220), "one unbroken path");
    assert!(errors.median_m <= 0.6 && errors.end_m <= 1.0, "{errors:?}");
    assert!(result(&out).gaps.is_empty());
}

#[test]
fn the_corridor_walk_is_found_on_its_plan_without_a_start() {
    let Some(clip) = data(CORRIDOR) else { return };
    let dir = folder();
    let out = dir.path().join("out");
    corridor("locate", &clip, &out).arg("--plan").arg(clip.join("derived/map_walls.yaml")).assert().success();
    let truth = truth_of_camera(&clip.join("derived/truth_12fps.tum"));
    let (end, result) = (truth[truth.len() - 1].1, result(&out));
    let near = |h: &planwalk::result::HypothesisEntry| (h.pose.x_m - end.x).hypot(h.pose.y_m - end.y) < 1.0;
    match result.status {
        Some(Status::Tracking) => assert!(near(&result.hypotheses[0]), "confident, and wrong: {:?}", result.hypotheses),
        // Saying that one does not know is right, if the truth is among what it could be.
        _ => assert!(result.hypotheses.iter().any(near), "{:?}", result.hypotheses),
    }
}

#[test]
fn both_solvers_turn_the_corner_at_the_blank_wall_without_breaking_the_path() {
    let Some(clip) = data(CORRIDOR) else { return };
    for name in ["five-point", "eight-point"] {
        let dir = folder();
        let out = dir.path().join("out");
        corridor("track", &clip, &out).args(["--solver", name]).assert().success();
        let headings: Vec<f64> = truth_of_camera(&out.join("odometry.tum")).iter().map(|(_, p): &(_, PlanPose)| p.heading_rad).collect();
        let truth: Vec<f64> = truth_of_camera(&clip.join("derived/truth_12fps.tum")).iter().map(|(_, p)| p.heading_rad).collect();
        assert_eq!(headings.len(), 220, "{name}");
        // The turn lies between frames 75 and 145; the reference itself is good to 1.5°.
        let turn = |h: &[f64]| h[75..=145].windows(2).map(|w| wrap_angle(w[1] - w[0])).sum::<f64>().to_degrees();
        assert!((turn(&headings) - turn(&truth)).abs() < 5.0, "{name}: {} for {}", turn(&headings), turn(&truth));
        assert!(fs::read(out.join("trajectory.png")).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
fn without_a_camera_file_the_lens_is_measured_and_the_walk_is_followed() {
    let Some(clip) = data(CORRIDOR) else { return };
    let dir = folder();
    let out = dir.path().join("out");
    let mut run = planwalk();
    let output = run.arg("track").arg(clip.join("rgb")).args(["--fps", "12", "-o"]).arg(&out).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("no camera file: the focal length was measured from straight edges and turns"), "{said}");
    assert!(said.contains("a phone's usual: 499"), "{said}");
    let (lens, stated) = (result(&out).camera.unwrap(), planwalk_io::camera::read(&clip.join("camera.yaml")).unwrap());
    let IntrinsicsSource::Measured { relative_sigma } = lens.source else { panic!("{lens:?}") };
    // What is asked of it: 5 %, and two of its own standard deviations.
    let off = (lens.focal_px() / stated.focal_px()).ln();
    assert!(off.abs() < 0.05 && off.abs() < 2.0 * relative_sigma, "{} px for {} px: {lens:?}", lens.focal_px(), stated.focal_px());
    assert!(fs::read_to_string(out.join("camera.yaml")).unwrap().contains("measured from the video itself"));
    assert_eq!(truth_of_camera(&out.join("odometry.tum")).len(), 220, "one unbroken path");
}

#[test]
fn a_robots_raw_wheels_on_its_map_run_through() {
    let (Some(log), Some(map)) = (data("robots_radish_carmen/raw/intel.clf.bz2"), data("robots_radish_carmen/derived_maps/intel.yaml"))
    else {
        return;
    };
    let dir = folder();
    let out = dir.path().join("out");
    let mut run = planwalk();
    run.arg("locate").arg("--poses").arg(log).args(["--odometry-scale", "metric", "--plan"]).arg(map).arg("--quiet").arg("-o").arg(&out);
    run.assert().success();
    let result = result(&out);
    assert!(result.status.is_some() && !result.hypotheses.is_empty());
    assert!(read_track(&out.join("track.csv")).len() > 10_000);
}

//! One story a claim.

mod georeference;
mod hostile;
mod import;
mod plan;
mod rooms;
mod scans;
mod sheets;
mod sightings;
mod trajectory;
mod video;

use planwalk_io::camera;

use crate::support::data;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn real_camera_files_of_both_layouts_are_read() {
    let Some(ros) = data("icsl_square3_corridor_walk/camera.yaml") else { return };
    let camera = camera::read(&ros).unwrap();
    assert_eq!((camera.width, camera.height, camera.fx, camera.cy), (640, 480, 537.59991, 244.51867));
    let Some(kalibr) = data("hilti_trimble_2026/config/kalibr_imucam_chain.yaml") else { return };
    assert_eq!((camera::read(&kalibr).unwrap().width, camera::read(&kalibr).unwrap().height), (1472, 1440));
}

#[test]
fn real_sightings_are_read() {
    let Some(path) = data("simulated_hilti/floor_1_2025-05-05_run_1_seed1.csv") else { return };
    let seen = planwalk_io::sightings::read(&path).unwrap();
    assert!(seen.len() > 1000 && seen.iter().all(|s| s.bearing_rad.abs() < 0.7 && s.range < 20.0));
}

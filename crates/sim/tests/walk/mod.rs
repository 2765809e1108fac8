//! Do simulated people walk as real ones do, and can a real walk be filmed again?

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use planwalk_sim::{Building, CLEARANCE_M, CameraOptions, PlanWorldOptions, Scene, SceneOptions, Walk, WalkOptions, walk_statistics};
use planwalk_types::{Cam, Plan, Rigid3, Seed, Stamp};

use crate::film::landmark_errors;
use crate::site::{data, read_plan};
use crate::small;

#[test]
fn lively_walkers_stop_glance_and_tilt_but_walk_through_nothing() {
    for seed in 0..4 {
        let options = SceneOptions { walk: WalkOptions::lively(), ..small(seed) };
        let scene = Scene::with_options(&options).unwrap();
        for (stamp, pose) in scene.truth_on_floor() {
            let clear = scene.clearance_m(pose.origin());
            assert!(clear > CLEARANCE_M - 0.025, "seed {seed}: {clear} m at {:.2} s", stamp.as_secs());
        }
        let (lively, plain) =
            (walk_statistics(&scene.truth()).unwrap(), walk_statistics(&Scene::with_options(&small(seed)).unwrap().truth()).unwrap());
        assert!(lively.pitch_deg > plain.pitch_deg && lively.turn_rate_deg_s[1] > plain.turn_rate_deg_s[1], "{lively:?} {plain:?}");
        assert!(lively.gait_hz > 1.3 && lively.gait_hz < 2.3, "{lively:?}");
    }
}

/// The text of a file of the real data.
fn real_data(name: &str) -> Option<String> {
    data(name).map(|file| std::fs::read_to_string(file).unwrap())
}

/// Poses of a TUM file.
fn poses_of(text: &str) -> Vec<(Stamp, Rigid3<Plan, Cam>)> {
    let numbers = |line: &str| line.split_whitespace().map(|v| v.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let pose = |v: Vec<f64>| {
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(v[7], v[4], v[5], v[6]));
        (Stamp::from_secs(v[0]).unwrap(), Rigid3::from_parts(Vector3::new(v[1], v[2], v[3]), rotation))
    };
    text.lines().filter(|line| !line.starts_with('#')).map(|line| pose(numbers(line))).collect()
}

#[test]
fn a_real_walk_can_be_filmed_again_as_it_was() {
    let Some(text) = real_data("hilti_trimble_2026/groundtruth/floor_2_2025-10-28_run_1.txt") else { return };
    let poses = poses_of(&text);
    let walk = Walk::along(&poses, UnitQuaternion::identity()).unwrap();
    // At the poses themselves nothing is interpolated; stamps of 1e4 s hold 2e-12 s.
    for (stamp, pose) in poses.iter().step_by(50) {
        let there = walk.at(stamp.secs_since(poses[0].0)).plan_from_camera;
        assert!((there.origin().coords - pose.origin().coords).norm() < 1e-6);
        assert!(there.iso.rotation.angle_to(&pose.iso.rotation) < 1e-5);
    }
    // Every second pose left out comes back: a hand is smooth on that scale, but for its jerks.
    let thin: Vec<_> = poses.iter().copied().step_by(2).collect();
    let thin_walk = Walk::along(&thin, UnitQuaternion::identity()).unwrap();
    let mut off: Vec<f64> = poses
        .iter()
        .skip(1)
        .step_by(2)
        .map(|(stamp, pose)| (thin_walk.at(stamp.secs_since(poses[0].0)).plan_from_camera.origin().coords - pose.origin().coords).norm())
        .collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 0.002, "median {} m", off[off.len() / 2]);
    // Filmed on its own plan; the camera that recorded it hung upside down.
    let Some(file) = data("hilti_trimble_2026/floorplans/masks_with_windows/floor_2.png") else { return };
    let building = Building::from_plan(&read_plan(&file, 0.01), &PlanWorldOptions::default(), Seed(1)).unwrap();
    let walk = Walk::along(&poses, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI)).unwrap();
    let camera = CameraOptions { fps: 12.5, readout_ms: 20.0, ..CameraOptions::noiseless() };
    let scene = Scene::along(building, walk, &SceneOptions { camera, ..Default::default() }).unwrap();
    let length = scene.walk().length_m();
    // Documented as 152 m, with its sway; smoothed over a second it is a little shorter.
    assert!(length > 138.0 && length < 155.0, "{length} m");
    assert_eq!(scene.frame_count(), (12.5 * scene.walk().duration_s()) as usize);
    // Each edge that is seen is within a pixel of where truth and camera say.
    let errors = landmark_errors(&scene, (0..scene.frame_count()).step_by(12));
    assert!(errors.len() > 20, "{} edges", errors.len());
    let found = walk_statistics(&poses).unwrap();
    assert!(found.speed_mps[1] > 1.3 && found.speed_mps[1] < 1.7 && (found.gait_hz - 1.8).abs() < 0.2, "{found:?}");
}

#[test]
fn lively_walkers_are_neither_kinder_nor_wilder_than_real_ones() {
    let real: Vec<_> = [
        "hilti_trimble_2026/groundtruth/floor_1_2025-05-05_run_1.txt",
        "hilti_trimble_2026/groundtruth/floor_2_2025-10-28_run_1.txt",
        "icsl_square3_corridor_walk/derived/truth_12fps.tum",
    ]
    .iter()
    .filter_map(|name| real_data(name))
    .map(|text| walk_statistics(&poses_of(&text)).unwrap())
    .collect();
    if real.is_empty() {
        return;
    }
    let walk = WalkOptions::lively();
    let lively: Vec<_> = (1..7)
        .filter_map(|seed| Scene::with_options(&SceneOptions { walk, ..small(seed) }).ok())
        .map(|scene| walk_statistics(&scene.truth()).unwrap())
        .collect();
    assert!(lively.len() >= 4);
    type Measure = fn(&planwalk_sim::WalkStatistics) -> f64;
    let measures: [(&str, Measure); 7] = [
        ("median speed, m/s", |s| s.speed_mps[1]),
        ("bobbing, m", |s| s.bobbing_m),
        ("steps a second", |s| s.gait_hz),
        ("median turning, deg/s", |s| s.turn_rate_deg_s[0]),
        ("fast turning, deg/s", |s| s.turn_rate_deg_s[1]),
        ("pitch, deg", |s| s.pitch_deg),
        ("roll, deg", |s| s.roll_deg),
    ];
    for (name, measure) in measures {
        let range = |all: &[planwalk_sim::WalkStatistics]| {
            all.iter().map(measure).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        let median = {
            let mut values: Vec<f64> = lively.iter().map(measure).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let (low, high) = range(&real);
        // Three real walks are few: half as much again on either side.
        assert!(median > low / 1.5 && median < 1.5 * high, "{name}: {median}, but {low} to {high} in real walks");
    }
}

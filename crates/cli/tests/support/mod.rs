//! What the stories share: the command, a folder, a small plan, simulated odometry, and real data where there is some.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use planwalk::evaluate::place::AnswerScores;
use planwalk::evaluate::{AssociateOptions, PlaceOptions, place};
use planwalk::types::{Estimate, PlanPose, Seed, Stamp};
use planwalk_sim::{OdometryNoise, Scene, simulate_odometry};

/// The command under test.
pub fn planwalk() -> Command {
    let mut command = Command::cargo_bin("planwalk").unwrap();
    command.env_remove("RUST_BACKTRACE");
    command
}

/// A folder that goes with the test.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// What the command said when it failed, checked for its exit code and for panics.
pub fn failure(command: &mut Command, code: i32) -> String {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(said.contains("error: ") && !said.contains("panicked"), "{said}");
    said
}

/// A plan of one room as PGM + map.yaml, 10 m × 6 m at 10 cm; returns the yaml's path.
pub fn room(folder: &Path) -> PathBuf {
    let (width, height) = (120usize, 80usize);
    let wall = |u: usize, v: usize| {
        let (inside_u, inside_v) = ((10..=110).contains(&u), (10..=70).contains(&v));
        inside_u && inside_v && (u == 10 || u == 110 || v == 10 || v == 70)
    };
    let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
    bytes.extend((0..width * height).map(|i| if wall(i % width, i / width) { 0u8 } else { 254 }));
    std::fs::write(folder.join("room.pgm"), bytes).unwrap();
    let yaml = "image: room.pgm\nresolution: 0.1\norigin: [-1.0, -1.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
    std::fs::write(folder.join("room.yaml"), yaml).unwrap();
    folder.join("room.yaml")
}

/// A straight walk of 4 m as a TUM file.
pub fn straight_walk(folder: &Path) -> PathBuf {
    let lines: String = (0..40).map(|i| format!("{:.2} {:.2} 0 0 0 0 0 1\n", 0.1 * f64::from(i), 0.1 * f64::from(i))).collect();
    std::fs::write(folder.join("walk.tum"), lines).unwrap();
    folder.join("walk.tum")
}

/// The demo building's plan, with odometry and sightings simulated along its walk, as files.
pub struct Simulated {
    pub plan: PathBuf,
    pub poses: PathBuf,
    pub sightings: PathBuf,
    pub truth: Vec<(Stamp, PlanPose)>,
}

/// Simulated odometry of unknown scale, with drift and furniture.
pub fn simulated(folder: &Path, seed: u64) -> Simulated {
    let scene = Scene::demo(Seed(seed));
    let truth = scene.truth_on_floor();
    let (path, seen) = simulate_odometry(&truth, scene.walls(), &OdometryNoise::default(), Seed(seed));
    let (plan, poses, sightings) = (folder.join("plan.yaml"), folder.join("odometry.tum"), folder.join("sightings.csv"));
    std::fs::write(folder.join("plan.pgm"), planwalk_io::plan::ros_map_image(&scene.plan())).unwrap();
    std::fs::write(&plan, planwalk_io::plan::ros_map_yaml(&scene.plan(), "plan.pgm")).unwrap();
    let steps = path.poses().iter().zip(path.stamps()).map(|(pose, stamp)| (stamp, planwalk::tables::upright(pose))).collect::<Vec<_>>();
    planwalk_io::trajectory::write_tum(&poses, steps).unwrap();
    planwalk_io::sightings::write(&sightings, &seen).unwrap();
    Simulated { plan, poses, sightings, truth }
}

/// A file or folder of the real data; `None`, said aloud, where there is none and none is required.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
pub fn data(name: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let path = std::env::var_os("PLANWALK_DATA").map_or_else(|| PathBuf::from(beside), PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    assert!(
        std::env::var_os("PLANWALK_REQUIRE_DATA").is_none_or(|v| v != "1"),
        "PLANWALK_REQUIRE_DATA=1, but {} is missing",
        path.display()
    );
    eprintln!("skipped: no {name} (set PLANWALK_DATA to the folder of real data)");
    None
}

/// `track.csv` or `filter.csv`.
pub fn read_track(path: &Path) -> Vec<Estimate> {
    planwalk::tables::estimates_of_csv(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Errors of a track, with moments of the truth at most 0.05 s away.
pub fn errors(track: &[Estimate], truth: &[(Stamp, PlanPose)]) -> AnswerScores {
    let associate = AssociateOptions { max_diff_s: 0.05, ..AssociateOptions::default() };
    place::score(track, &[], truth, &PlaceOptions { associate, ..PlaceOptions::default() }).unwrap().track
}

/// Poses on the floor from a TUM file of camera poses (x right, y down, z forward): the heading is where the camera looks.
pub fn truth_of_camera(path: &Path) -> Vec<(Stamp, PlanPose)> {
    let text = std::fs::read_to_string(path).unwrap();
    let pose = |line: &str| {
        let n: Vec<f64> = line.split_whitespace().map(|c| c.parse().unwrap()).collect();
        let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(n[7], n[4], n[5], n[6]));
        let ahead = turn * nalgebra::Vector3::z();
        (Stamp::from_secs(n[0]).unwrap(), PlanPose::new(n[1], n[2], ahead.y.atan2(ahead.x)))
    };
    text.lines().filter(|l| !l.starts_with('#') && !l.trim().is_empty()).map(pose).collect()
}

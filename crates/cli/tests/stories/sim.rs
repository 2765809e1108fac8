//! Simulated walks as files: complete, repeatable, readable by the other commands, and as they were asked for.

use std::fs;
use std::path::Path;

use crate::support::{data, failure, folder, planwalk, truth_of_camera};

/// A short, small video.
fn film(out: &Path, more: &[&str]) {
    let mut command = planwalk();
    command.args(["sim", "--duration", "3", "--fps", "5", "--resolution", "160x120", "--quiet", "-o"]).arg(out).args(more);
    command.assert().success();
}

#[test]
fn a_video_comes_with_everything_that_is_true_of_it_and_is_followed_again() {
    let dir = folder();
    let out = dir.path().join("out");
    film(&out, &["--seed", "3"]);
    for name in ["camera.yaml", "truth.tum", "plan.yaml", "plan.pgm", "world.yaml", "world.pgm", "odometry.tum", "sightings.csv"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 0, "{name}");
    }
    assert!(fs::read(out.join("contact.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(fs::read_to_string(out.join("frames/times.txt")).unwrap().lines().count(), 15);
    assert_eq!(fs::read_dir(out.join("frames")).unwrap().count(), 16, "the frames and their times");
    let truth = truth_of_camera(&out.join("truth.tum"));
    assert_eq!(truth.len(), 15);
    // The plan is free where the walk was.
    let plan = planwalk_io::plan::read(&out.join("plan.yaml"), &Default::default()).unwrap().plan;
    assert!(truth.iter().all(|(_, pose)| plan.at(pose.origin()) == planwalk::types::Cell::Free));
    let mut track = planwalk();
    track.arg("track").arg(out.join("frames")).arg("--camera").arg(out.join("camera.yaml")).arg("--quiet");
    track.arg("-o").arg(dir.path().join("track")).assert().success();
    let odometry = fs::read_to_string(dir.path().join("track/odometry.tum")).unwrap();
    let stamps = |text: &str| text.lines().map(|l| l.split(' ').next().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(stamps(&odometry), stamps(&fs::read_to_string(out.join("truth.tum")).unwrap()), "the same clock");
}

#[test]
fn the_scene_that_is_written_gives_the_same_bytes_again_on_any_number_of_threads() {
    let dir = folder();
    let (one, other) = (dir.path().join("one"), dir.path().join("other"));
    film(&one, &["--seed", "5", "--lively", "--people", "0.2", "--noise", "monocular", "-j", "1"]);
    let mut again = planwalk();
    again.args(["sim", "--quiet", "-j", "2", "--scene"]).arg(one.join("scene.toml")).arg("-o").arg(&other).assert().success();
    for name in ["truth.tum", "plan.pgm", "world.pgm", "odometry.tum", "sightings.csv", "frames/000000.png", "frames/000014.png"] {
        assert_eq!(fs::read(one.join(name)).unwrap(), fs::read(other.join(name)).unwrap(), "{name}");
    }
    film(&dir.path().join("third"), &["--seed", "6", "--lively", "--people", "0.2"]);
    assert_ne!(fs::read(one.join("truth.tum")).unwrap(), fs::read(dir.path().join("third/truth.tum")).unwrap());
}

#[test]
fn many_walks_of_odometry_need_no_pictures() {
    let dir = folder();
    let out = dir.path().join("out");
    let mut command = planwalk();
    command.args(["sim", "odometry", "--building", "flat", "--walks", "3", "--duration", "20", "--quiet", "--seed", "2", "-o"]).arg(&out);
    command.assert().success();
    let read = |walk: &str, name: &str| fs::read_to_string(out.join(walk).join(name)).unwrap();
    for walk in ["00000", "00001", "00002"] {
        // 5 Hz over 20 s, the first pose included.
        assert_eq!(read(walk, "truth.tum").lines().count(), 101, "{walk}");
        assert_eq!(read(walk, "odometry.tum").lines().count(), 101, "{walk}");
        assert!(read(walk, "sightings.csv").lines().count() > 100, "{walk}");
    }
    assert_ne!(read("00000", "truth.tum"), read("00001", "truth.tum"));
    assert!(out.join("plan.yaml").is_file() && !out.join("frames").exists());
}

#[test]
fn every_walk_sees_the_building_whose_plan_is_written() {
    let dir = folder();
    let (one, many) = (dir.path().join("one"), dir.path().join("many"));
    let sim = |out: &Path, more: &[&str]| {
        let mut command = planwalk();
        command.args(["sim", "odometry", "--building", "flat", "--seed", "2", "--noise", "none", "--quiet", "-o"]).arg(out).args(more);
        command.assert().success();
    };
    sim(&one, &["--duration", "10"]);
    // The same way again and again: the building must not be another one each time.
    let path = one.join("truth.tum");
    sim(&many, &["--path", path.to_str().unwrap(), "--path-frame", "body", "--walks", "3"]);
    assert_eq!(fs::read(one.join("plan.pgm")).unwrap(), fs::read(many.join("plan.pgm")).unwrap());
    let plan = planwalk_io::plan::read(&many.join("plan.yaml"), &Default::default()).unwrap().plan;
    for walk in ["00000", "00001", "00002"] {
        let truth = planwalk_io::trajectory::read(&many.join(walk).join("truth.tum"), &Default::default()).unwrap().trajectory;
        let sightings = planwalk_io::sightings::read(&many.join(walk).join("sightings.csv")).unwrap();
        let on_wall = |s: &planwalk::types::Sighting| {
            let pose = truth.poses().iter().find(|(stamp, _)| *stamp == s.stamp).unwrap().1.on_floor();
            let angle = pose.heading_rad + s.bearing_rad;
            let near = |by: f64| planwalk::types::Pt2::new(pose.x + (s.range + by) * angle.cos(), pose.y + (s.range + by) * angle.sin());
            // A wall is 12 cm thick, a cell 5 cm.
            (0..8).any(|i| plan.at(near(0.02 * f64::from(i) - 0.06)) == planwalk::types::Cell::Wall)
        };
        let share = sightings.iter().filter(|s| on_wall(s)).count() as f64 / sightings.len() as f64;
        // Shut doors are seen, and are openings of the plan.
        assert!(sightings.len() > 100 && share > 0.8, "walk {walk}: {share} of {} on walls", sightings.len());
    }
}

#[test]
fn walls_that_were_never_built_are_on_the_plan_and_not_in_the_world() {
    let dir = folder();
    let walls = |name: &str, file: &str| fs::read(dir.path().join(name).join(file)).unwrap().iter().filter(|b| **b == 0).count();
    film(&dir.path().join("honest"), &["--seed", "4", "--furniture", "0"]);
    film(&dir.path().join("liar"), &["--seed", "4", "--furniture", "0", "--missing-walls", "0.6"]);
    assert!(walls("liar", "world.pgm") < walls("honest", "world.pgm"));
    assert_eq!(walls("liar", "plan.pgm"), walls("honest", "plan.pgm"));
}

#[test]
fn a_real_path_is_walked_again_on_its_own_plan() {
    let Some(plan) = data("hilti_trimble_2026/floorplans/masks_with_windows/floor_2.png") else { return };
    let Some(path) = data("hilti_trimble_2026/groundtruth/floor_2_2025-10-28_run_1.txt") else { return };
    let dir = folder();
    let out = dir.path().join("out");
    let mut command = planwalk();
    command.arg("sim").arg("--plan").arg(&plan).args(["--metres-per-pixel", "0.01", "--path"]).arg(&path);
    command.args(["--mount", "0,0,180", "--fps", "0.5", "--resolution", "160x120", "--quiet", "--json", "-o"]).arg(&out);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["frames"], 51);
    let length = said["length_m"].as_f64().unwrap();
    // 152 m with its sway, as it is documented.
    assert!((138.0..155.0).contains(&length), "{length} m");
    // Upright: the ceiling is brighter than the floor in most frames.
    let bright = |i: usize| {
        let image = image_of(&out.join(format!("frames/{i:06}.png")));
        let mean = |rows: std::ops::Range<usize>| image[rows.start * 160..rows.end * 160].iter().map(|b| u32::from(*b)).sum::<u32>();
        mean(0..30) > mean(90..120)
    };
    assert!((0..51).filter(|i| bright(*i)).count() > 40);
}

/// The pixels of a grey PNG, by the program's own reader.
fn image_of(path: &Path) -> Vec<u8> {
    let folder = folder();
    fs::copy(path, folder.path().join("0.png")).unwrap();
    let mut video = planwalk_io::video::open(folder.path(), &Default::default()).unwrap();
    video.next().unwrap().unwrap().image.data().to_vec()
}

#[test]
fn scenes_that_cannot_be_are_refused_with_what_to_say_instead() {
    let dir = folder();
    let out = dir.path().join("out");
    let sim = |arguments: &[&str], code: i32| failure(planwalk().arg("sim").args(arguments).arg("-o").arg(&out).arg("--force"), code);
    assert!(sim(&["--people", "0.9"], 2).contains("0.9"));
    assert!(sim(&["--building", "castle"], 2).contains("open_plan"));
    assert!(sim(&["--size", "5,5"], 2).contains("width"));
    assert!(sim(&["--odometry-hz", "0"], 2).contains("rate"));
    assert!(sim(&["--walks", "3"], 2).contains("sim odometry"), "walks are not dropped in silence");
    assert!(sim(&["--plan", "no-plan.png", "--metres-per-pixel", "0.01"], 4).contains("no-plan.png"));
    fs::write(dir.path().join("scene.toml"), "wakl = 3\n").unwrap();
    let scene = dir.path().join("scene.toml");
    assert!(sim(&["--scene", scene.to_str().unwrap()], 4).contains("wakl"));
    fs::write(dir.path().join("path.tum"), "0 0 0 1 0 0 0 1\n").unwrap();
    let path = dir.path().join("path.tum");
    assert!(sim(&["--path", path.to_str().unwrap()], 4).contains("at least 2"));
}

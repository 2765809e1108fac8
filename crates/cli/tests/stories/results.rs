//! What comes out: every file, the same bytes for the same seed, and the truth within what is claimed.

use std::fs;
use std::path::Path;

use planwalk::result::ResultFile;
use planwalk::types::Status;

use crate::support::{Simulated, errors, folder, planwalk, read_track, simulated};

fn locate(walk: &Simulated, out: &Path, more: &[&str]) {
    let mut command = planwalk();
    command.arg("locate").arg("--poses").arg(&walk.poses).arg("--sightings").arg(&walk.sightings).arg("--plan").arg(&walk.plan);
    command.arg("-o").arg(out).args(more).assert().success();
}

#[test]
fn a_simulated_walk_is_found_without_start_heading_or_scale() {
    let dir = folder();
    let walk = simulated(dir.path(), 11);
    let out = dir.path().join("out");
    locate(&walk, &out, &["--quiet"]);
    let track = read_track(&out.join("track.csv"));
    let errors = errors(&track, &walk.truth);
    assert_eq!(errors.compared, walk.truth.len());
    // A quarter of a door's width in the median, and never through another door.
    assert!(errors.median_m < 0.3 && errors.end_m < 0.6, "{errors:?}");
    let result: ResultFile = serde_json::from_str(&fs::read_to_string(out.join("result.json")).unwrap()).unwrap();
    assert_eq!(result.status, Some(Status::Tracking));
    assert_eq!(result.inputs.iter().map(|i| i.role.as_str()).collect::<Vec<_>>(), ["poses", "sightings", "plan"]);
    assert!(result.inputs.iter().all(|i| i.sha256.len() == 64));
    assert!((result.hypotheses.iter().map(|h| h.probability).sum::<f64>() - 1.0).abs() < 0.1);
}

#[test]
fn every_promised_file_is_there_and_whole() {
    let dir = folder();
    let walk = simulated(dir.path(), 9);
    let out = dir.path().join("out");
    locate(&walk, &out, &["--quiet"]);
    for name in ["result.json", "track.csv", "filter.csv", "track.tum", "odometry.tum", "sightings.csv", "track.svg", "report.html"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 0, "{name}");
    }
    assert!(fs::read(out.join("track.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read_dir(&out).unwrap().all(|e| !e.unwrap().file_name().to_string_lossy().ends_with(".part")));
    let tum = fs::read_to_string(out.join("track.tum")).unwrap();
    let evo_reads_it = |line: &str| line.split(' ').count() == 8 && line.split(' ').all(|c| c.parse::<f64>().is_ok());
    assert!(tum.lines().filter(|l| !l.starts_with('#')).all(evo_reads_it), "{}", &tum[..200]);
    assert_eq!(read_track(&out.join("track.csv")).len(), read_track(&out.join("filter.csv")).len());
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_one_thread_and_on_two() {
    let dir = folder();
    let walk = simulated(dir.path(), 5);
    let bytes = |name: &str, more: &[&str]| {
        let out = dir.path().join(name);
        locate(&walk, &out, more);
        ["track.csv", "filter.csv"].map(|file| fs::read(out.join(file)).unwrap())
    };
    let one = bytes("one", &["--quiet", "-j", "1"]);
    assert_eq!(one, bytes("two", &["--quiet", "-j", "2"]));
    assert_eq!(one, bytes("again", &["--quiet", "-j", "2"]));
    assert_ne!(one, bytes("other", &["--quiet", "--seed", "1"]), "another seed draws other particles");
}

#[test]
fn json_goes_to_standard_output_and_everything_else_does_not() {
    let dir = folder();
    let walk = simulated(dir.path(), 9);
    let output = planwalk()
        .arg("locate")
        .arg("--poses")
        .arg(&walk.poses)
        .arg("--plan")
        .arg(&walk.plan)
        .arg("--json")
        .arg("-o")
        .arg(dir.path().join("out"))
        .output()
        .unwrap();
    let said: ResultFile = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said.schema, "planwalk-result/1");
    assert!(String::from_utf8_lossy(&output.stderr).contains("picture: "));
}

#[test]
fn place_finds_the_start_of_a_perfect_trajectory() {
    let dir = folder();
    let walk = simulated(dir.path(), 11);
    // The truth itself as the trajectory, in metres, in a frame of its own.
    let first = walk.truth[0].1;
    let poses = walk.truth.iter().map(|(stamp, pose)| (*stamp, planwalk::tables::upright(&(first.inverse() * *pose))));
    let file = dir.path().join("perfect.tum");
    planwalk_io::trajectory::write_tum(&file, poses.collect::<Vec<_>>()).unwrap();
    let heading = format!("{}", first.heading_rad.to_degrees());
    for (name, more) in [("given", vec!["--heading", &heading, "--scale-range", "1,1"]), ("all", vec!["--scale-range", "1,1"])] {
        let out = dir.path().join(name);
        let mut command = planwalk();
        command.arg("place").arg("--poses").arg(&file).arg("--plan").arg(&walk.plan).args(more).arg("--quiet").arg("-o").arg(&out);
        command.assert().success();
        let result: ResultFile = serde_json::from_str(&fs::read_to_string(out.join("result.json")).unwrap()).unwrap();
        let placement = result.placement.unwrap();
        let near = placement.modes.iter().map(|m| (m.start.x_m - first.x).hypot(m.start.y_m - first.y)).fold(f64::INFINITY, f64::min);
        // A mode is a region; its representative lies within a room's clearance of the truth.
        assert!(placement.area_m2 > 0.0 && near < 1.0, "{name}: {placement:?}");
        assert!(fs::read(out.join("place.png")).unwrap().starts_with(b"\x89PNG"));
    }
}

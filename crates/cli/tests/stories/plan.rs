//! What `plan info` says of a plan, and what `place` says of a trajectory that drifts.

use std::fs;

use planwalk::plan_info::PlanInfo;
use planwalk::result::ResultFile;
use planwalk::types::{FloorPlan, Seed};
use planwalk_sim::{Building, BuildingKind, BuildingOptions};

use crate::support::{failure, folder, planwalk, room, straight_walk};

#[test]
fn plan_info_tells_size_floor_and_walls_and_writes_nothing_unasked() {
    let dir = folder();
    let plan = room(dir.path());
    let output = planwalk().args(["plan", "info", "--json"]).arg(&plan).current_dir(dir.path()).output().unwrap();
    assert!(output.status.success());
    let info: PlanInfo = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((info.schema.as_str(), info.size_cells, info.doors), ("planwalk-plan-info/1", [120, 80], 0));
    // 10 m × 6 m within walls of one cell.
    assert!((info.inside_m2 - 58.4).abs() < 2.0, "{}", info.inside_m2);
    assert!(info.ambiguity.is_none());
    assert!(String::from_utf8_lossy(&output.stderr).contains("12.0 m × 8.0 m"));
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "the plan's own files");
}

#[test]
fn options_of_the_ambiguity_are_refused_without_it() {
    let dir = folder();
    let plan = room(dir.path());
    let said = failure(planwalk().args(["plan", "info", "--seed", "3"]).arg(&plan), 2);
    assert!(said.contains("--ambiguity"), "{said}");
    failure(planwalk().args(["plan", "info", "no-such.png", "--metres-per-pixel", "0.1"]), 4);
}

/// A ring of corridors that looks nearly the same from both ends, as files.
fn ring(folder: &std::path::Path) -> (std::path::PathBuf, FloorPlan) {
    let options = BuildingOptions { kind: BuildingKind::Loop, ..BuildingOptions::default() };
    let plan = Building::generate(&options, Seed(4)).unwrap().plan(0.1, 1.0).unwrap();
    fs::write(folder.join("plan.pgm"), planwalk_io::plan::ros_map_image(&plan)).unwrap();
    fs::write(folder.join("plan.yaml"), planwalk_io::plan::ros_map_yaml(&plan, "plan.pgm")).unwrap();
    (folder.join("plan.yaml"), plan)
}

#[test]
fn the_mirrored_places_of_a_ring_are_found_and_drawn() {
    let dir = folder();
    let (file, plan) = ring(dir.path());
    let out = dir.path().join("out");
    planwalk().args(["plan", "info", "--ambiguity", "--quiet"]).arg(&file).arg("-o").arg(&out).assert().success();
    let info: PlanInfo = serde_json::from_str(&fs::read_to_string(out.join("plan_info.json")).unwrap()).unwrap();
    let found = info.ambiguity.unwrap();
    assert!(found.walks >= 100 && found.kept_themselves >= 0.9, "{found:?}");
    assert!(fs::read(out.join("ambiguity.png")).unwrap().starts_with(b"\x89PNG"));
    // The place turned by 180° about the building's middle, within a room's width.
    let (width, height) = plan.size_m();
    let middle = (plan.origin().x + 0.5 * width, plan.origin().y + 0.5 * height);
    let mirrored = |pair: &&planwalk::plan_info::PairEntry| {
        let (x, y) = (2.0 * middle.0 - pair.a.x_m, 2.0 * middle.1 - pair.a.y_m);
        (pair.b.x_m - x).hypot(pair.b.y_m - y) < 3.0
    };
    assert!(found.pairs.iter().any(|pair| mirrored(&pair)), "{:?}", found.pairs);
}

#[test]
fn place_forgives_the_drift_that_is_stated() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()));
    // 4 m said for what fits in the 10 m × 6 m room at ×2.6 only if it is shorter than said.
    let place = |out: &str, more: &[&str]| {
        let mut command = planwalk();
        command.arg("place").arg("--poses").arg(&walk).arg("--plan").arg(&plan).args(["--scale-range", "2.6,2.6", "--heading", "0"]);
        command.args(more).arg("--quiet").arg("-o").arg(dir.path().join(out));
        command
    };
    failure(&mut place("perfect", &[]), 5);
    place("drifting", &["--length-error", "10", "--drift", "1"]).assert().success();
    let text = fs::read_to_string(dir.path().join("drifting/result.json")).unwrap();
    let placement = serde_json::from_str::<ResultFile>(&text).unwrap().placement.unwrap();
    assert!(placement.area_m2 > 0.0 && placement.end_area_m2 > 0.0 && !placement.end_modes.is_empty());
    assert!(failure(&mut place("absurd", &["--drift", "90"]), 2).contains("--drift"));
}

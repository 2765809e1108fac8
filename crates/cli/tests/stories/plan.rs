//! What `plan info` says of a plan, and what `place` says of a trajectory that drifts.

use std::fs;

use planwalk::locate::{AmbiguityOptions, ConfusablePair, ambiguity};
use planwalk::plan_info::PlanInfo;
use planwalk::result::ResultFile;
use planwalk::types::Seed;
use planwalk_sim::{Building, BuildingKind, BuildingOptions};

use crate::support::{failure, folder, planwalk, room, straight_walk};

#[test]
fn plan_info_tells_size_floor_and_walls_and_writes_nothing_unasked() {
    let dir = folder();
    let plan = room(dir.path());
    let output = planwalk().args(["plan", "info", "--json"]).arg(&plan).current_dir(dir.path()).output().unwrap();
    assert!(output.status.success());
    let info: PlanInfo = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((info.schema.as_str(), info.size_cells, info.doors), ("planwalk-plan-info/2", [120, 80], 0));
    // 10 m × 6 m within walls of one cell.
    // The walls' outer faces count as inside within a coarse cell of 25 cm.
    assert!((info.inside_m2 - 58.4).abs() < 4.0, "{}", info.inside_m2);
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

#[test]
fn a_room_of_four_equal_corners_stays_ambiguous_and_is_drawn() {
    let dir = folder();
    let (plan, out) = (room(dir.path()), dir.path().join("out"));
    planwalk().args(["plan", "info", "--ambiguity", "--quiet"]).arg(&plan).arg("-o").arg(&out).assert().success();
    let info: PlanInfo = serde_json::from_str(&fs::read_to_string(out.join("plan_info.json")).unwrap()).unwrap();
    let found = info.ambiguity.unwrap();
    assert!(found.never > 0.9 && found.median_m.is_none() && !found.pairs.is_empty(), "{found:?}");
    assert!(fs::read(out.join("ambiguity.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn the_mirrored_places_of_a_ring_are_found() {
    // Turned by 180° the ring looks nearly the same.
    let options = BuildingOptions { kind: BuildingKind::Loop, ..BuildingOptions::default() };
    let plan = Building::generate(&options, Seed(4)).unwrap().plan(0.1, 1.0).unwrap();
    let found = ambiguity(&plan, &AmbiguityOptions { places: 24, length_m: 16.0, ..Default::default() }, Seed(0), &mut |_| {});
    let kept = found.walks.iter().filter(|walk| walk.kept_itself).count() as f64 / found.walks.len() as f64;
    assert!(found.walks.len() >= 24 && kept >= 0.8, "{kept} of {}", found.walks.len());
    let (width, height) = plan.size_m();
    let middle = (plan.origin().x + 0.5 * width, plan.origin().y + 0.5 * height);
    let mirrored = |pair: &&ConfusablePair| {
        let (x, y) = (2.0 * middle.0 - pair.a.x, 2.0 * middle.1 - pair.a.y);
        // Within a room's width.
        (pair.b.x - x).hypot(pair.b.y - y) < 3.0
    };
    assert!(found.pairs.iter().any(|pair| mirrored(&pair)), "{:?}", found.pairs);
}

#[test]
fn place_forgives_the_drift_that_is_stated() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()));
    // 3.9 m said, 12.5 m at this scale: longer than the plan, unless it was a quarter shorter than said.
    let place = |out: &str, more: &[&str]| {
        let mut command = planwalk();
        command.arg("place").arg("--poses").arg(&walk).arg("--plan").arg(&plan).args(["--scale-range", "3.2,3.2", "--heading", "0"]);
        command.args(more).arg("--quiet").arg("-o").arg(dir.path().join(out));
        command
    };
    failure(&mut place("perfect", &[]), 5);
    place("drifting", &["--length-error", "25", "--drift", "1"]).assert().success();
    let text = fs::read_to_string(dir.path().join("drifting/result.json")).unwrap();
    let placement = serde_json::from_str::<ResultFile>(&text).unwrap().placement.unwrap();
    assert!(placement.area_m2 > 0.0 && placement.end_area_m2 > 0.0 && !placement.end_modes.is_empty());
    assert!(failure(&mut place("absurd", &["--drift", "90"]), 2).contains("--drift"));
}

/// Two rooms with a door between them and a window, in feet.
const FLAT_FT: &str = "x0_ft,y0_ft,x1_ft,y1_ft,kind\n0,0,30,0,wall\n30,0,30,15,wall\n30,15,0,15,wall\n0,15,0,0,wall\n15,0,15,15,wall\n15,5,15,8,door\n20,15,24,15,window\n";

#[test]
fn a_plan_is_kept_handed_on_and_read_again_from_each_of_its_formats() {
    let dir = folder();
    let list = dir.path().join("flat.csv");
    fs::write(&list, FLAT_FT).unwrap();
    let kept = dir.path().join("flat.plan.json");
    let said = planwalk().args(["plan", "import"]).arg(&list).arg("-o").arg(&kept).assert().success();
    let said = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
    assert!(said.contains("5 walls, 1 window, 1 door"), "{said}");
    // Written once; then only where one means it.
    assert!(failure(planwalk().args(["plan", "import"]).arg(&list).arg("-o").arg(&kept), 2).contains("--force"));
    let info = |plan: &std::path::Path| -> PlanInfo {
        let output = planwalk().args(["plan", "info", "--json"]).arg(plan).output().unwrap();
        assert!(output.status.success(), "{}: {}", plan.display(), String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let straight = info(&list);
    assert_eq!(straight.doors, 1);
    assert_eq!(info(&kept).cells, straight.cells);
    // Two rooms are found, and a door joins them.
    let storey = &straight.building.storeys[0];
    assert_eq!((storey.rooms.len(), storey.passages.len(), storey.findings.len()), (2, 1, 0), "{storey:?}");
    assert!(storey.rooms.iter().all(|room| room.found && (room.area_m2 - 20.6).abs() < 1.0), "{:?}", storey.rooms);
    assert_eq!((&storey.rooms[0].leads_to[..], &storey.rooms[1].leads_to[..]), (&[1][..], &[0][..]));
    assert!(storey.passages[0].door && (storey.passages[0].width_m - 0.91).abs() < 0.11, "{:?}", storey.passages);
    assert!(straight.building.scale_from.is_some() && fs::read_to_string(&kept).unwrap().matches("found between the walls").count() >= 2);
    for name in ["a.geojson", "a.csv", "a.yaml", "a.svg"] {
        let written = dir.path().join(name);
        planwalk().args(["plan", "export", "--quiet"]).arg(&kept).arg("-o").arg(&written).assert().success();
        let again = info(&written);
        let off = again.inside_m2 - straight.inside_m2;
        // A robot's map has no doors; what is 0.1 mm off may fall into the next cell.
        assert!(off.abs() < 0.01 * straight.inside_m2, "{name}: {} m² of {}", again.inside_m2, straight.inside_m2);
        assert_eq!(again.doors, usize::from(name != "a.yaml"), "{name}");
    }
    let picture = dir.path().join("a.png");
    planwalk().args(["plan", "render", "--quiet"]).arg(&kept).arg("-o").arg(&picture).assert().success();
    assert!(fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    assert!(failure(planwalk().args(["plan", "export"]).arg(&kept).args(["-o", "x.dwg"]), 2).contains(".geojson"));
}

#[test]
fn what_looks_wrong_is_told_at_once_with_place_size_and_remedy() {
    let dir = folder();
    let list = dir.path().join("flat.csv");
    // A wall twice, a door of 0.3 m, and nothing that leads into the right room.
    let broken = "x0,y0,x1,y1,kind\n0,0,9,0,wall\n9,0,9,5,wall\n9,5,0,5,wall\n0,5,0,0,wall\n5,0,5,5,wall\n5,5,5,3,wall\n1,0,1.3,0,door\n";
    fs::write(&list, broken).unwrap();
    let output = planwalk().args(["plan", "info", "--json"]).arg(&list).output().unwrap();
    assert!(output.status.success());
    let info: PlanInfo = serde_json::from_slice(&output.stdout).unwrap();
    let findings = &info.building.storeys[0].findings;
    let kinds: Vec<&str> = findings.iter().map(|f| f.kind.as_str()).collect();
    assert_eq!(kinds, ["unreachable", "door-width", "doubled-wall"], "{findings:?}");
    assert!(findings.iter().all(|f| f.at_m.is_some() && !f.figures.is_empty() && !f.remedy.is_empty()));
    assert!((findings[1].figures["width_m"] - 0.3).abs() < 1e-9 && (findings[2].figures["length_m"] - 2.0).abs() < 1e-9);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("finding 3 (doubled-wall) at (5.00, 4.00) m a wall is drawn twice over 2.00 m: remove one"), "{said}");
    let picture = dir.path().join("flat.svg");
    planwalk().args(["plan", "render", "--quiet"]).arg(&list).arg("-o").arg(&picture).assert().success();
    let picture = fs::read_to_string(&picture).unwrap();
    assert!(picture.contains(">3 findings</text>") && picture.contains(">2 rooms (pale colours)</text>"), "{picture}");
}

#[test]
fn drawings_are_to_scale_or_say_what_is_missing() {
    let dir = folder();
    let drawing = dir.path().join("flat.svg");
    let walls = "M100 100H500V300H300V220M300 180V100M300 300H100Z";
    let svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 600 400'><path d='{walls}' fill='none' stroke='black' stroke-width='4'/></svg>"
    );
    fs::write(&drawing, svg).unwrap();
    let out = dir.path().join("flat.plan.json");
    let import = |more: &[&str]| {
        let mut command = planwalk();
        command.args(["plan", "import"]).arg(&drawing).arg("-o").arg(&out).args(more);
        command
    };
    let said = failure(&mut import(&[]), 4);
    assert!(["--drawing-scale", "--metres-per-pixel", "--measure"].iter().all(|way| said.contains(way)), "{said}");
    // 400 px are 105.8 mm on paper, 10.58 m at 1:100.
    import(&["--drawing-scale", "100"]).assert().success();
    let text = fs::read_to_string(&out).unwrap();
    assert!(text.contains("\"scale_from\"") && text.contains("\"svg\""), "{text}");
    let width = planwalk().args(["plan", "info", "--json"]).arg(&out).output().unwrap();
    let info: PlanInfo = serde_json::from_slice(&width.stdout).unwrap();
    assert!((info.size_m[0] - 2.0 - 10.58).abs() < 0.2, "{:?}", info.size_m);
    assert!(failure(&mut import(&["--drawing-scale", "0.5", "--force"]), 4).contains("1:0.5"));
    let other = failure(&mut import(&["--metres-per-pixel", "0.02", "--level", "7", "--force"]), 4);
    assert!(other.contains("no storey \"7\""), "{other}");
}

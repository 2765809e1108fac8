//! Benches: every walk is scored by every method, an interrupted bench goes on, and changes are told from noise.

use std::fs;
use std::path::{Path, PathBuf};

use planwalk::bench::Record;
use planwalk::bench::record::parse;

use crate::support::{failure, folder, planwalk, simulated, straight_walk};

/// Two short walks through one small building, and no pictures.
const SUITE: &str = r#"
name = "mine"
about = "a flat"
[[case]]
name = "flat"
[case.simulate]
walks = 2
[case.simulate.scene.building]
kind = "flat"
[case.simulate.scene.walk]
duration_s = 8
"#;

fn suite(dir: &Path, text: &str) -> PathBuf {
    let path = dir.join("mine.toml");
    fs::write(&path, text).unwrap();
    path
}

fn bench(suite: &Path, out: &Path, more: &[&str]) {
    let mut command = planwalk();
    command.arg("bench").arg(suite).arg("-o").arg(out).arg("--data").arg(suite.parent().unwrap()).arg("--quiet").args(more);
    command.assert().success();
}

fn records(out: &Path) -> Vec<Record> {
    parse(&fs::read_to_string(out.join("results.jsonl")).unwrap()).unwrap()
}

/// What of a record does not depend on the machine.
fn scored(record: &Record) -> String {
    let same = Record { locate_s: None, odometry_s: None, ..record.clone() };
    same.to_line()
}

#[test]
fn every_walk_is_scored_by_every_method_and_the_table_says_so() {
    let dir = folder();
    let (suite, out) = (suite(dir.path(), SUITE), dir.path().join("out"));
    bench(&suite, &out, &[]);
    let records = records(&out);
    let mut keys: Vec<_> = records.iter().map(|r| (r.case.as_str(), r.method.as_str())).collect();
    keys.sort_unstable();
    assert_eq!(keys, [("flat/0/0", "planwalk"), ("flat/0/0", "report"), ("flat/0/1", "planwalk"), ("flat/0/1", "report")]);
    assert!(records.iter().all(|r| r.error.is_none() && r.place.is_some() && r.locate_s.is_some()), "{records:?}");
    let table = fs::read_to_string(out.join("table.md")).unwrap();
    assert!(table.contains("| flat ") && table.contains("| report ") && table.contains("end right %"), "{table}");
    assert!(fs::read(out.join("bench.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn shards_together_are_the_whole_and_an_interrupted_bench_goes_on() {
    let dir = folder();
    let (suite, out) = (suite(dir.path(), SUITE), dir.path().join("out"));
    bench(&suite, &out, &["--method", "report", "-j", "1"]);
    let whole: Vec<String> = records(&out).iter().map(scored).collect();
    let mut parts = Vec::new();
    for shard in ["1/2", "2/2"] {
        let out = dir.path().join(shard.replace('/', "-"));
        bench(&suite, &out, &["--method", "report", "--shard", shard, "-j", "2"]);
        parts.extend(records(&out).iter().map(scored));
    }
    parts.sort();
    let mut sorted = whole.clone();
    sorted.sort();
    assert_eq!(parts, sorted);
    // Half a line is what a stopped run leaves.
    let path = out.join("results.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    let first = text.lines().next().unwrap();
    fs::write(&path, format!("{first}\n{}", &text[first.len() + 1..first.len() + 40])).unwrap();
    bench(&suite, &out, &["--method", "report", "--resume"]);
    let resumed = records(&out);
    assert_eq!(resumed.len(), 2);
    assert_eq!(resumed[0].to_line(), first, "what was done is kept as it was, times and all");
    assert_eq!(resumed.iter().map(scored).collect::<Vec<_>>(), whole);
}

#[test]
fn one_walk_with_one_seed_is_run_again_as_it_was() {
    let dir = folder();
    let (suite, all, one) = (suite(dir.path(), SUITE), dir.path().join("all"), dir.path().join("one"));
    bench(&suite, &all, &["--method", "report", "--seeds", "3"]);
    bench(&suite, &one, &["--method", "report", "--only", "flat/0/1", "--seed", "2"]);
    let (all, one) = (records(&all), records(&one));
    assert_eq!((all.len(), one.len()), (6, 1));
    let same = all.iter().find(|r| r.key() == one[0].key()).unwrap();
    assert_eq!((one[0].seed, scored(&one[0])), (2, scored(same)));
}

#[test]
fn a_changed_suite_is_run_again_and_compared_with_before() {
    let dir = folder();
    let (old, new) = (dir.path().join("old"), dir.path().join("new"));
    let mine = suite(dir.path(), SUITE);
    bench(&mine, &old, &["--method", "report"]);
    // The same walks without any noise: the recipe's scale is then right.
    let exact = SUITE.replace("[case.simulate]", "noise = { scale_sigma = 0, step_relative = 0, turn_relative = 0 }\n[case.simulate]");
    let mine = suite(dir.path(), &exact);
    let before = old.join("results.jsonl");
    bench(&mine, &new, &["--method", "report", "--compare", before.to_str().unwrap()]);
    let table = fs::read_to_string(new.join("table.md")).unwrap();
    assert!(table.contains("## Changes") && table.contains("| before"), "{table}");
    assert_ne!(records(&old)[0].given, records(&new)[0].given);
    bench(&mine, &old, &["--method", "report", "--resume"]);
    assert_eq!(records(&old).len(), 4, "what another suite made is not taken for this one's");
}

#[test]
fn targets_are_said_to_be_met_or_missed() {
    let dir = folder();
    let targets = r#"methods = ["report"]
columns = ["end right %", "scale off %", "found again after m"]
[[target]]
group = "flat"
metric = "end right %"
at_least = 0
[[target]]
group = "all"
metric = "found again after m"
at_most = 1
[[case]]
name = "flat"
kidnap = true
blind = true
odometry_scale = "0.2"
noise = { scale_range = [1.25, 1.25] }"#;
    let text = SUITE.replace("[[case]]\nname = \"flat\"", targets);
    let (suite, out) = (suite(dir.path(), &text), dir.path().join("out"));
    bench(&suite, &out, &[]);
    let records = records(&out);
    assert!(records.len() == 2 && records.iter().all(|r| r.method == "report"), "the suite says who walks: {records:?}");
    for record in &records {
        let place = record.place.as_ref().unwrap();
        // The recipe takes a unit for a metre, and is not told otherwise.
        let off = place.scale.unwrap();
        assert!((off.end_log_error - 1.25f64.ln()).abs() < 0.1 && place.kidnap.is_some(), "{place:?}");
        assert!(place.filter.as_ref().unwrap().stays.len() == 5);
    }
    let table = fs::read_to_string(out.join("table.md")).unwrap();
    assert!(table.contains("## Targets") && table.contains("found again after m") && !table.contains("track median m"), "{table}");
    let verdicts: Vec<&str> = table.lines().filter(|line| line.contains("≥ 0") || line.contains("≤ 1")).collect();
    assert!(verdicts.len() == 2 && verdicts[0].contains("| met ") && verdicts[1].contains("| missed "), "{verdicts:?}");
}

#[test]
fn tracks_from_elsewhere_are_scored_as_they_are() {
    let dir = folder();
    let walk = simulated(dir.path(), 11);
    let truth = walk.truth.iter().map(|(stamp, pose)| (*stamp, planwalk::tables::upright(pose)));
    planwalk_io::trajectory::write_tum(&dir.path().join("truth.tum"), truth).unwrap();
    let off = walk.truth.iter().map(|(stamp, pose)| {
        (*stamp, planwalk::tables::upright(&planwalk::types::PlanPose::new(pose.x + 0.3, pose.y - 0.4, pose.heading_rad)))
    });
    planwalk_io::trajectory::write_tum(&dir.path().join("theirs.tum"), off).unwrap();
    let text = "name = \"t\"\nabout = \"theirs\"\n[[case]]\nname = \"theirs\"\ntrack = \"theirs.tum\"\nplan = \"plan.yaml\"\ntruth = \"truth.tum\"\n";
    let (suite, out) = (suite(dir.path(), text), dir.path().join("out"));
    bench(&suite, &out, &[]);
    let records = records(&out);
    assert_eq!((records.len(), records[0].method.as_str()), (1, "foreign"));
    let place = records[0].place.as_ref().unwrap();
    // 3, 4, 5; files have nine decimals.
    assert!((place.track.median_m - 0.5).abs() < 1e-6 && place.track.end_right, "{place:?}");
    assert!(place.track.calibration.is_none() || place.filter.is_none(), "nothing was claimed");
}

#[test]
fn a_walk_that_cannot_be_read_costs_only_its_own_scores() {
    let dir = folder();
    straight_walk(dir.path());
    let broken = format!("{SUITE}\n[[case]]\nname = \"gone\"\nposes = \"gone.tum\"\nplan = \"gone.png\"\ntruth = \"walk.tum\"\n");
    let (path, out) = (suite(dir.path(), &broken), dir.path().join("out"));
    bench(&path, &out, &["--method", "report"]);
    let records = records(&out);
    let gone = records.iter().find(|r| r.case == "gone").unwrap();
    assert!(gone.error.as_ref().unwrap().contains("gone.png") && gone.place.is_none());
    assert_eq!(records.iter().filter(|r| r.place.is_some()).count(), 2);
    assert!(fs::read_to_string(out.join("table.md")).unwrap().contains("failed"));
}

#[test]
fn suites_that_make_no_sense_are_refused() {
    let dir = folder();
    let out = dir.path().join("out");
    let refused =
        |text: &str, code: i32| failure(planwalk().arg("bench").arg(suite(dir.path(), text)).arg("-o").arg(&out).arg("--force"), code);
    assert!(refused("name = 3", 4).contains("mine.toml"));
    assert!(refused("name = \"x\"\nabout = \"y\"\ncase = []\n", 4).contains("no cases"));
    assert!(refused("name = \"x\"\nabout = \"y\"\n[[case]]\nname = \"a\"\n", 4).contains("exactly one of"));
    let unknown = failure(planwalk().args(["bench", "smoek"]).arg("-o").arg(&out).arg("--force"), 4);
    assert!(unknown.contains("smoke") && unknown.contains("odometry"), "{unknown}");
    let nothing = failure(planwalk().args(["bench", "smoke", "--only", "castle"]).arg("-o").arg(&out).arg("--force"), 2);
    assert!(nothing.contains("--list"), "{nothing}");
}

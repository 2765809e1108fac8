//! Scores against the truth: of results, of trajectories from elsewhere, and what is said of truths that do not fit.

use std::fs;
use std::path::{Path, PathBuf};

use planwalk::evaluate::{Alignment, Evaluation};
use planwalk::tables::upright;
use planwalk::types::{PlanPose, Stamp};

use crate::support::{data, failure, folder, planwalk, simulated};

/// Poses on the plan as a TUM file.
fn write(path: &Path, poses: impl Iterator<Item = (Stamp, PlanPose)>) {
    planwalk_io::trajectory::write_tum(path, poses.map(|(s, p)| (s, upright(&p))).collect::<Vec<_>>()).unwrap();
}

/// A walk round a corner at 10 Hz, 0.1 m a step.
fn corner() -> Vec<(Stamp, PlanPose)> {
    let pose = |i: i64| {
        let along = 0.1 * i as f64;
        let pose = if i < 60 { PlanPose::new(along, 1.0, 0.0) } else { PlanPose::new(6.0, along - 5.0, std::f64::consts::FRAC_PI_2) };
        (Stamp(i * 100_000_000), pose)
    };
    (0..120).map(pose).collect()
}

fn file(dir: &Path, name: &str, text: &str) -> PathBuf {
    let path = dir.join(name);
    fs::write(&path, text).unwrap();
    path
}

/// The truth as a TUM file, and the same 10 cm to the left as the answer.
fn truth_and_answer(dir: &Path) -> (PathBuf, PathBuf) {
    let (truth, answer) = (dir.join("truth.tum"), dir.join("answer.tum"));
    write(&truth, corner().into_iter());
    write(&answer, corner().into_iter().map(|(s, p)| (s, PlanPose::new(p.x, p.y + 0.1, p.heading_rad))));
    (truth, answer)
}

fn eval(answer: &Path, truth: &Path) -> assert_cmd::Command {
    let mut command = planwalk();
    command.arg("eval").arg(answer).arg("--truth").arg(truth);
    command
}

fn scores(folder: &Path) -> Evaluation {
    serde_json::from_str(&fs::read_to_string(folder.join("eval.json")).unwrap()).unwrap()
}

#[test]
fn a_located_walk_is_scored_where_it_lies() {
    let dir = folder();
    let walk = simulated(dir.path(), 11);
    let (out, truth) = (dir.path().join("out"), dir.path().join("plan-truth.tum"));
    write(&truth, walk.truth.iter().copied());
    let mut locate = planwalk();
    locate.arg("locate").arg("--poses").arg(&walk.poses).arg("--sightings").arg(&walk.sightings).arg("--plan").arg(&walk.plan);
    locate.arg("--quiet").arg("-o").arg(&out).assert().success();
    let output = eval(&out, &truth).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && output.stdout.is_empty(), "{said}");
    for words in [
        "error, median (CE50)",
        "truth in 95 % region",
        "stays right from",
        "sure and wrong",
        "odometry, sim2 alignment",
        "work in a second",
    ] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    let scores = scores(&out);
    assert!(scores.pace.is_some_and(|pace| pace.locate.is_some_and(|p| p > 0.0) && pace.odometry.is_none() && pace.threads > 0));
    let place = scores.place.unwrap();
    // The odometry is simulated at the truth's own moments.
    assert_eq!(place.track.compared, walk.truth.len());
    assert!(place.track.median_m < 0.3 && place.track.end_right, "{:?}", place.track);
    let filter = place.filter.unwrap();
    assert!(filter.errors.calibration.is_some() && filter.tracking + filter.ambiguous + filter.lost > 0.999);
    assert!(place.hypotheses.is_some_and(|h| h.any_right && h.probability_right > 0.5));
    assert!(scores.odometry.is_some_and(|o| o.alignment == Alignment::Sim2 && o.posed_share > 0.99));
    for picture in ["eval-error", "eval-calibration", "eval-odometry"] {
        assert!(fs::read(out.join(format!("{picture}.png"))).unwrap().starts_with(b"\x89PNG"), "{picture}");
        assert!(out.join(format!("{picture}.svg")).exists());
    }
    let rows = fs::read_to_string(out.join("eval-curves.csv")).unwrap().lines().count();
    assert_eq!(rows, 1 + place.track.compared + filter.errors.compared);
}

#[test]
fn a_trajectory_from_elsewhere_is_aligned_unless_it_is_to_be_a_place() {
    let dir = folder();
    let (truth, answer) = truth_and_answer(dir.path());
    let out = dir.path().join("scores");
    eval(&answer, &truth).args(["--align", "se2", "--quiet", "-o"]).arg(&out).assert().success();
    let aligned = scores(&out);
    // Nine decimals in the files.
    assert!(aligned.place.is_none() && aligned.odometry.unwrap().ate_m.max < 1e-6);
    let output = eval(&answer, &truth).args(["--align", "none", "--json", "-o"]).arg(&out).output().unwrap();
    let placed: Evaluation = serde_json::from_slice(&output.stdout).unwrap();
    let place = placed.place.unwrap();
    assert!((place.track.median_m - 0.1).abs() < 1e-6 && place.track.calibration.is_none() && place.filter.is_none());
    assert!((placed.odometry.unwrap().ate_m.rmse - 0.1).abs() < 1e-6);
    let quiet = eval(&answer, &truth).args(["--align", "se2", "--quiet", "-o"]).arg(&out).output().unwrap();
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
}

#[test]
fn a_truth_clicked_once_a_second_is_interpolated_and_has_no_heading() {
    let dir = folder();
    let (_, answer) = truth_and_answer(dir.path());
    let clicks = corner().into_iter().step_by(10).map(|(s, p)| format!("{},{},{}\n", s.as_secs() + 0.05, p.x + 0.05, p.y));
    let clicked = file(dir.path(), "clicked.csv", &format!("clicked by hand\ntime,x,y\n{}", clicks.collect::<String>()));
    let said = failure(eval(&answer, &clicked).args(["--align", "none"]), 4);
    assert!(said.contains("0.050 s apart") && said.contains("--interpolate-truth"), "{said}");
    eval(&answer, &clicked).args(["--align", "none", "--interpolate-truth", "1.5", "--quiet"]).assert().success();
    let place = scores(dir.path()).place.unwrap();
    assert!(place.track.compared > 100 && place.track.median_m < 0.15, "{:?}", place.track);
    assert_eq!(place.track.heading_median_rad, None);
}

#[test]
fn kitti_files_take_the_truths_times_and_agree_with_evo() {
    let (Some(estimate), Some(truth)) = (data("kitti_odometry/KITTI_00_ORB.txt"), data("kitti_odometry/KITTI_00_gt.txt")) else { return };
    let dir = folder();
    eval(&estimate, &truth).args(["--align", "sim3", "--quiet", "-o"]).arg(dir.path()).assert().success();
    let odometry = scores(dir.path()).odometry.unwrap();
    // evo 1.38.1: evo_ape kitti KITTI_00_gt.txt KITTI_00_ORB.txt -as gives 0.937709; files and frames are read on the way.
    assert!((odometry.ate_m.rmse - 0.937_709_073_6).abs() < 1e-6, "{}", odometry.ate_m.rmse);
    assert_eq!(odometry.compared, 4541);
}

#[test]
fn a_robots_corrected_log_takes_the_times_of_its_raw_one() {
    let dir = folder();
    let scan = |i: usize, x: f64, t: f64| format!("FLASER 2 {i}.25 2.5 {x} 0 0 {x} 0 0 {t} h 0\n");
    let log = |name: &str, shift: f64, rate: f64| {
        file(dir.path(), name, &(0..30).map(|i| scan(i, shift + 0.1 * i as f64, 100.0 + rate * i as f64)).collect::<String>())
    };
    let (raw, corrected) = (log("raw.clf", 0.0, 0.5), log("corrected.log", 3.0, 0.0));
    let answer = (0..30).map(|i| format!("{} {} 0 0 0 0 0 1\n", 0.5 * f64::from(i), 0.1 * f64::from(i))).collect::<String>();
    let answer = file(dir.path(), "mine.tum", &answer);
    eval(&answer, &corrected).args(["--align", "se2", "--quiet", "--truth-times"]).arg(&raw).assert().success();
    let odometry = scores(dir.path()).odometry.unwrap();
    assert!(odometry.compared == 30 && odometry.ate_m.rmse < 1e-9, "{odometry:?}");
    let other = file(dir.path(), "other.clf", &(40..70).map(|i| scan(i, 0.0, i as f64)).collect::<String>());
    assert!(failure(eval(&answer, &corrected).arg("--truth-times").arg(&other), 4).contains("0 of 30 corrected scans"));
}

#[test]
fn times_given_for_kitti_poses_must_be_theirs() {
    let dir = folder();
    let lines = |scale: f64| (0..30).map(|i| format!("1 0 0 {} 0 1 0 0 0 0 1 {i}\n", scale * f64::from(i * i))).collect::<String>();
    let (truth, answer) = (file(dir.path(), "00.txt", &lines(0.01)), file(dir.path(), "mine.txt", &lines(0.0101)));
    let times = |count: usize| (0..count).map(|i| format!("{:.3}\n", 5.0 + 0.2 * i as f64)).collect::<String>();
    let (right, wrong) = (file(dir.path(), "thirty.txt", &times(30)), file(dir.path(), "seven.txt", &times(7)));
    eval(&answer, &truth).args(["--align", "se2", "--quiet", "--truth-times"]).arg(&right).assert().success();
    let odometry = scores(dir.path()).odometry.unwrap();
    assert!((odometry.duration_s - 5.8).abs() < 1e-9 && odometry.compared == 30, "{odometry:?}");
    assert!(failure(eval(&answer, &truth).arg("--truth-times").arg(&wrong), 4).contains("7 times were given for 30 poses"));
    let said = failure(eval(&answer, &truth).arg("--truth-times").arg(dir.path().join("no-times.txt")), 4);
    assert!(said.contains("no-times.txt"), "{said}");
    let (tum, _) = truth_and_answer(dir.path());
    assert!(failure(eval(&answer, &tum).arg("--truth-times").arg(&right), 2).contains("KITTI"));
}

#[test]
fn truths_that_do_not_fit_say_why() {
    let dir = folder();
    let (truth, answer) = truth_and_answer(dir.path());
    let shifted = dir.path().join("shifted.tum");
    write(&shifted, corner().into_iter().map(|(s, p)| (Stamp(s.0 + 1_761_000_000_000_000), p)));
    let said = failure(&mut eval(&answer, &shifted), 4);
    assert!(said.contains("share no time") && said.contains("--time-offset 1761000.000"), "{said}");
    assert!(said.trim_end().ends_with("shifted.tum"), "the path comes last: {said}");
    eval(&answer, &shifted).args(["--time-offset", "1761000", "--align", "se2", "--quiet"]).assert().success();
    for (name, text, words) in [
        ("one.tum", "0 0 0 0 0 0 0 1\n", "at least 2"),
        ("nan.tum", "0 0 0 0 0 0 0 1\n0.1 NaN 0 0 0 0 0 1\n", "line 2"),
        ("prose.tum", "it was a dark and stormy night\n", "--truth-format"),
        ("empty.tum", "", "no poses"),
    ] {
        let said = failure(&mut eval(&answer, &file(dir.path(), name, text)), 4);
        assert!(said.contains(words) && said.contains(name), "{said}");
    }
    assert!(failure(&mut eval(&dir.path().join("nothing"), &truth), 4).contains("nothing"));
    assert!(failure(&mut eval(&answer, &dir.path().join("no-truth.tum")), 4).contains("no-truth.tum"));
    failure(eval(&answer, &truth).args(["--max-diff", "nan"]), 2);
    failure(eval(&answer, &truth).args(["--interpolate-truth", "0"]), 2);
}

#[test]
fn a_truth_in_the_cameras_frame_is_recognised() {
    let dir = folder();
    let (_, answer) = truth_and_answer(dir.path());
    // x right, y down, z forward, facing along x.
    let lines: String = corner().iter().map(|(s, p)| format!("{} {} {} 1.5 -0.5 0.5 -0.5 0.5\n", s.as_secs(), p.x, p.y)).collect();
    let camera = file(dir.path(), "camera.tum", &lines);
    let said = failure(eval(&answer, &camera).args(["--align", "none"]), 4);
    assert!(said.contains("--truth-frame camera"), "{said}");
    eval(&answer, &camera).args(["--align", "none", "--truth-frame", "camera", "--quiet"]).assert().success();
    // The answer turns at the corner, this camera does not: half of the walk faces the same way.
    assert!((scores(dir.path()).place.unwrap().track.median_m - 0.1).abs() < 1e-6);
    // The world of a first camera has y down: no plan does.
    let lines: String = corner().iter().map(|(s, p)| format!("{} {} 0 {} 0 0 0 1\n", s.as_secs(), p.x, p.y)).collect();
    let world = file(dir.path(), "world.tum", &lines);
    let said = failure(eval(&answer, &world).args(["--align", "none", "--truth-frame", "camera"]), 4);
    assert!(said.contains("z up"), "{said}");
}

#[test]
fn folders_without_results_and_broken_ones_are_refused() {
    let dir = folder();
    let (truth, _) = truth_and_answer(dir.path());
    let out = dir.path().join("out");
    fs::create_dir(&out).unwrap();
    assert!(failure(&mut eval(&out, &truth), 4).contains("track.csv"));
    file(&out, "track.csv", "a,b,c\n1,2,3\n");
    assert!(failure(&mut eval(&out, &truth), 4).contains("track.csv"));
    fs::remove_file(out.join("track.csv")).unwrap();
    file(&out, "odometry.tum", "0 0 0 0 0 0 0 1\n");
    assert!(failure(&mut eval(&out, &truth), 4).contains("odometry.tum"));
    file(&out, "result.json", "{}");
    assert!(failure(&mut eval(&out, &truth), 4).contains("result.json"));
    failure(eval(&out, &truth).args(["--poses-frame", "camera"]), 2);
    assert!(!out.join("eval.json").exists());
}

//! How the command behaves towards whoever calls it: pipes, folders, options, and what stays when there is no answer.

use std::fs;
use std::process::{Command, Stdio};

use planwalk::result::ResultFile;

use crate::support::{failure, folder, planwalk, room, straight_walk};

/// `place` of a straight walk in a room, which takes no time.
fn place(dir: &std::path::Path, out: &str) -> assert_cmd::Command {
    let (walk, plan) = (straight_walk(dir), room(dir));
    let mut command = planwalk();
    command.arg("place").arg("--poses").arg(walk).arg("--plan").arg(plan).args(["--odometry-scale", "metric", "-o"]).arg(dir.join(out));
    command
}

fn result(out: &std::path::Path) -> ResultFile {
    serde_json::from_str(&fs::read_to_string(out.join("result.json")).unwrap()).unwrap()
}

#[test]
fn a_reader_that_goes_away_is_no_reason_to_panic() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()));
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("planwalk"));
    command.arg("place").arg("--poses").arg(walk).arg("--plan").arg(plan).arg("--json").arg("-o").arg(dir.path().join("out"));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Both pipes are closed before anything is said.
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn quiet_is_quiet() {
    let dir = folder();
    let output = place(dir.path(), "out").arg("--quiet").output().unwrap();
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn force_replaces_an_earlier_run_but_only_once_there_is_something_new() {
    let dir = folder();
    let out = dir.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("track.csv"), "of an earlier run").unwrap();
    let mut mistyped = planwalk();
    mistyped.args(["place", "--poses", "no-such.tum", "--force", "--plan"]).arg(room(dir.path())).arg("-o").arg(&out);
    failure(&mut mistyped, 4);
    assert!(out.join("track.csv").exists(), "a mistyped input costs no result");
    place(dir.path(), "out").arg("--force").assert().success();
    assert!(!out.join("track.csv").exists() && out.join("place.png").exists(), "two runs do not mix");
}

#[test]
fn a_trajectory_that_fits_nowhere_has_no_answer_but_its_files() {
    let dir = folder();
    let said = failure(place(dir.path(), "out").args(["--scale-range", "5,6"]), 5);
    assert!(said.contains("wider --scale-range"), "{said}");
    let result = result(&dir.path().join("out"));
    assert!(result.error.is_some() && result.placement.is_some_and(|p| p.modes.is_empty()));
    assert!(dir.path().join("out/place.png").exists());
}

#[test]
fn a_start_off_the_plan_is_said_before_any_work() {
    let dir = folder();
    let video = dir.path().join("frames");
    fs::create_dir(&video).unwrap();
    let mut command = planwalk();
    command.arg("locate").arg(&video).arg("--plan").arg(room(dir.path())).args(["--start", "900,900", "-o"]).arg(dir.path().join("out"));
    // The folder of frames is empty, which would be an error of its own, had it been looked at.
    assert!(failure(&mut command, 2).contains("off the plan"));
    assert_eq!(fs::read_dir(dir.path().join("out")).unwrap().count(), 0);
}

#[test]
fn options_that_nothing_would_read_are_refused() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()));
    for extra in [["--camera", "camera.yaml"], ["--fps", "10"], ["--solver", "eight-point"]] {
        let mut command = planwalk();
        command.arg("locate").arg("--poses").arg(&walk).arg("--plan").arg(&plan).args(extra).arg("-o").arg(dir.path().join("out"));
        let said = failure(&mut command, 2);
        assert!(said.contains("cannot be used with"), "{said}");
    }
}

#[test]
fn the_result_tells_which_options_were_in_force() {
    let dir = folder();
    place(dir.path(), "out").args(["--heading", "0"]).assert().success();
    let options: Vec<(String, String)> = result(&dir.path().join("out")).options.into_iter().map(|o| (o.name, o.value)).collect();
    assert!(options.contains(&("heading".to_owned(), "0".to_owned())), "{options:?}");
    assert!(options.contains(&("odometry-scale".to_owned(), "metric".to_owned())), "{options:?}");
}

#[test]
fn the_demo_needs_no_argument_and_every_command_shows_examples() {
    let help = |command: &str| {
        let output = planwalk().args([command, "--help"]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    for command in ["demo", "track", "locate", "place", "plan", "eval"] {
        assert!(help(command).contains("Examples:"), "{command}");
    }
    assert!(help("demo").contains("[default: planwalk-demo]"), "{}", help("demo"));
}

//! Whatever is wrong with the input: a clear error, a remedy, the right exit code, never a panic.

use std::fs;

use crate::support::{data, failure, folder, planwalk, room, straight_walk};

/// `locate VIDEO --plan room -o out`.
fn locate(video: &std::path::Path, dir: &std::path::Path) -> assert_cmd::Command {
    let mut command = planwalk();
    command.arg("locate").arg(video).arg("--plan").arg(room(dir)).arg("-o").arg(dir.join("out"));
    command
}

/// Grey frames as PGM.
fn frames(dir: &std::path::Path, count: usize, grey: u8) -> std::path::PathBuf {
    let folder = dir.join("frames");
    fs::create_dir(&folder).unwrap();
    for i in 0..count {
        let mut bytes = b"P5\n160 120\n255\n".to_vec();
        bytes.extend(std::iter::repeat_n(grey, 160 * 120));
        fs::write(folder.join(format!("{i:03}.pgm")), bytes).unwrap();
    }
    folder
}

#[test]
fn a_file_that_is_not_there() {
    let dir = folder();
    let said = failure(&mut locate(&dir.path().join("nothing.mp4"), dir.path()), 4);
    assert!(said.contains("nothing.mp4"), "{said}");
    let mut no_plan = planwalk();
    no_plan.args(["locate", "x.mp4", "--plan", "no-plan.yaml", "-o"]).arg(dir.path().join("out2"));
    assert!(failure(&mut no_plan, 4).contains("no-plan.yaml"));
}

#[test]
fn an_empty_folder() {
    let dir = folder();
    fs::create_dir(dir.path().join("empty")).unwrap();
    let said = failure(&mut locate(&dir.path().join("empty"), dir.path()), 4);
    assert!(said.contains("PNG"), "it says what would do: {said}");
}

#[test]
fn a_text_file_named_mp4() {
    let dir = folder();
    let video = dir.path().join("fake.mp4");
    fs::write(&video, "this is no video, but somebody named it so\n").unwrap();
    failure(&mut locate(&video, dir.path()), 4);
}

#[test]
fn an_mp4_cut_off_before_its_index() {
    let Some(clip) = data("rendered_hilti/steady.mp4") else { return };
    let dir = folder();
    let video = dir.path().join("cut.mp4");
    let bytes = fs::read(clip).unwrap();
    // Just the first kilobytes: no index at the end, or no frames after it.
    fs::write(&video, &bytes[..2000]).unwrap();
    failure(&mut locate(&video, dir.path()), 4);
}

#[test]
fn one_frame_only() {
    let dir = folder();
    let said = failure(&mut locate(&frames(dir.path(), 1, 90), dir.path()), 4);
    assert!(said.contains("at least 2"), "{said}");
}

#[test]
fn a_black_video_has_no_answer() {
    let dir = folder();
    let said = failure(&mut locate(&frames(dir.path(), 12, 0), dir.path()), 5);
    assert!(said.contains("black"), "{said}");
    assert!(said.contains("too few straight edges and turns to measure the lens: a phone's usual focal length is assumed"), "{said}");
    assert!(dir.path().join("out/camera.yaml").exists(), "what was known so far stays");
}

#[test]
fn a_plan_without_walls_and_one_that_is_all_wall() {
    let dir = folder();
    let walk = straight_walk(dir.path());
    for (name, grey) in [("blank", 255u8), ("solid", 0)] {
        let image = dir.path().join(format!("{name}.pgm"));
        let mut bytes = b"P5\n60 40\n255\n".to_vec();
        bytes.extend(std::iter::repeat_n(grey, 60 * 40));
        fs::write(&image, bytes).unwrap();
        let mut command = planwalk();
        command.arg("locate").arg("--poses").arg(&walk).arg("--plan").arg(&image).args(["--metres-per-pixel", "0.1", "-o"]);
        let said = failure(command.arg(dir.path().join(name)), 4);
        assert!(said.contains("wall"), "{said}");
    }
}

#[test]
fn a_plan_without_scale_names_the_ways_out() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()).with_extension("pgm"));
    let mut command = planwalk();
    let said = failure(command.arg("locate").arg("--poses").arg(&walk).arg("--plan").arg(&plan).arg("-o").arg(dir.path().join("out")), 4);
    assert!(said.contains("--metres-per-pixel"), "{said}");
}

#[test]
fn poses_that_are_not_numbers_or_go_back_in_time() {
    let dir = folder();
    let plan = room(dir.path());
    for (name, text) in [
        ("nan", "0 0 0 0 0 0 0 1\n1 NaN 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"),
        ("back", "0 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n"),
        ("one", "0 0 0 0 0 0 0 1\n"),
        ("none", ""),
        ("prose", "it was a dark and stormy night\n"),
    ] {
        let poses = dir.path().join(format!("{name}.tum"));
        fs::write(&poses, text).unwrap();
        for command in ["locate", "place"] {
            let out = dir.path().join(format!("{name}-{command}"));
            let said = failure(planwalk().arg(command).arg("--poses").arg(&poses).arg("--plan").arg(&plan).arg("-o").arg(out), 4);
            assert!(said.contains(&format!("{name}.tum")), "{said}");
        }
    }
}

#[test]
fn images_of_no_size_and_of_far_too_large_a_size() {
    let dir = folder();
    let walk = straight_walk(dir.path());
    for (name, header) in [("zero", "P5\n0 0\n255\n"), ("huge", "P5\n60000 60000\n255\n")] {
        let image = dir.path().join(format!("{name}.pgm"));
        fs::write(&image, header).unwrap();
        let mut command = planwalk();
        command.arg("locate").arg("--poses").arg(&walk).arg("--plan").arg(&image).args(["--metres-per-pixel", "0.1", "-o"]);
        failure(command.arg(dir.path().join(format!("{name}-plan"))), 4);
        let video = dir.path().join(format!("{name}-video"));
        fs::create_dir(&video).unwrap();
        fs::write(video.join("0.pgm"), header).unwrap();
        let mut command = planwalk();
        failure(command.arg("track").arg(&video).arg("-o").arg(dir.path().join(format!("{name}-track"))), 4);
    }
}

#[test]
fn a_camera_for_another_video_names_both_sizes() {
    let dir = folder();
    let camera = dir.path().join("camera.yaml");
    let yaml = "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n\
                distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n";
    fs::write(&camera, yaml).unwrap();
    let video = frames(dir.path(), 3, 90);
    let said = failure(locate(&video, dir.path()).arg("--camera").arg(&camera), 4);
    assert!(said.contains("640×480") && said.contains("160×120"), "{said}");
}

#[test]
fn an_output_folder_that_is_not_empty_is_left_alone() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()));
    let out = dir.path().join("full");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("thesis.txt"), "irreplaceable").unwrap();
    let locate = |force: bool| {
        let mut command = planwalk();
        command.arg("locate").arg("--poses").arg(&walk).arg("--plan").arg(&plan).arg("--quiet").arg("-o").arg(&out);
        if force {
            command.arg("--force");
        }
        command
    };
    let said = failure(&mut locate(false), 2);
    assert!(said.contains("--force") && said.trim_end().ends_with("full"), "the path comes last: {said}");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
    locate(true).assert().success();
    assert_eq!(fs::read_to_string(out.join("thesis.txt")).unwrap(), "irreplaceable");
}

#[test]
fn arguments_that_make_no_sense_are_usage() {
    let dir = folder();
    let (walk, plan) = (straight_walk(dir.path()), room(dir.path()));
    for wrong in [
        vec!["--start", "here"],
        vec!["--start", "900,900"],
        vec!["--odometry-scale", "feet"],
        vec!["-j", "0"],
        vec!["--sightings"],
        vec!["--measure", "1,2,3=4m"],
    ] {
        let mut command = planwalk();
        command
            .arg("locate")
            .arg("--poses")
            .arg(&walk)
            .arg("--plan")
            .arg(&plan)
            .args(&wrong)
            .arg("--force")
            .arg("-o")
            .arg(dir.path().join("o"));
        failure(&mut command, 2);
    }
    failure(planwalk().args(["locate", "--plan"]).arg(&plan).arg("-o").arg(dir.path().join("o2")), 2);
}

//! Poses of every format become a body's path, z up; and what is wrong is named with its line.

use std::path::Path;

use planwalk_io::trajectory::{self, PosesError, PosesFormat, PosesFrame, PosesOptions};
use planwalk_types::{Body, Odom, Rigid3, Stamp, TrajectoryError};
use proptest::prelude::*;

use super::folder;
use crate::support::data;

fn read_poses(text: &str) -> Result<trajectory::PosesFile, PosesError> {
    let dir = folder();
    std::fs::write(dir.path().join("poses.txt"), text).unwrap();
    trajectory::read(&dir.path().join("poses.txt"), &PosesOptions::default())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn poses_survive_the_trip_through_a_tum_file(start in 0..2_000_000_000_000_000_000i64, x in -1e3..1e3f64, yaw in -3.0..3.0f64) {
        let dir = folder();
        let path = dir.path().join("poses.tum");
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.1, -0.2, yaw);
        let pose = |i: i64| (Stamp(start + 33 * i), Rigid3::from_parts(nalgebra::Vector3::new(x, 0.1 * i as f64, -x), turn));
        let poses: Vec<(Stamp, Rigid3<Odom, Body>)> = (0..3).map(pose).collect();
        trajectory::write_tum(&path, poses.iter().copied()).unwrap();
        let back = trajectory::read(&path, &PosesOptions::default()).unwrap();
        prop_assert_eq!(back.format, PosesFormat::Tum);
        for ((stamp, pose), (back_stamp, back_pose)) in poses.iter().zip(back.trajectory.poses()) {
            prop_assert_eq!(stamp, back_stamp);
            let off = pose.iso.inverse() * back_pose.iso;
            // Nine decimals are written.
            prop_assert!(off.translation.vector.norm() < 2e-9 && off.rotation.angle() < 1e-7);
        }
    }
}

#[test]
fn tum_files_are_written_as_strict_readers_want_them() {
    let dir = folder();
    let path = dir.path().join("poses.tum");
    let pose = Rigid3::<Odom, Body>::identity();
    trajectory::write_tum(&path, [(Stamp(1_500_000_000), pose)]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, "1.500000000 0.000000000 0.000000000 0.000000000 0.000000000 0.000000000 0.000000000 1.000000000\n");
}

#[test]
fn broken_poses_are_named_with_their_line() {
    let good = "# t x y z qx qy qz qw\n0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n";
    let error = |row: &str| read_poses(&format!("{good}{row}\n")).unwrap_err();
    assert!(matches!(error("2 NaN 0 0 0 0 0 1"), PosesError::NotANumber { line: 4, .. }));
    assert!(matches!(error("2 x 0 0 0 0 0 1"), PosesError::NotANumber { line: 4, .. }));
    assert!(matches!(error("nan 0 0 0 0 0 0 1"), PosesError::BadStamp { line: 4, .. }));
    assert!(matches!(error("0.5 0 0 0 0 0 0 1"), PosesError::StampsGoBack { line: 4, .. }));
    assert!(matches!(error("1 0 0 0 0 0 0 1"), PosesError::StampsGoBack { line: 4, .. }));
    assert!(matches!(error("2 0 0 0 0 0 0 0"), PosesError::NotARotation { line: 4, .. }));
    assert!(matches!(error("2 0 0"), PosesError::Columns { line: 4, got: 3, .. }));
    assert!(matches!(read_poses(""), Err(PosesError::Empty)));
    assert!(matches!(read_poses("0 0 0 0 0 0 0 1\n"), Err(PosesError::Trajectory(TrajectoryError::TooFewPoses { got: 1 }))));
    assert!(matches!(trajectory::read(Path::new("no such file"), &PosesOptions::default()), Err(PosesError::Io(_))));
}

#[test]
fn euroc_has_w_first_and_nanoseconds() {
    let file = read_poses("#timestamp, p_RS_R_x [m]\n1403636580838555648,1,2,3,0.0,0,0,1\n1403636580888555648,1,2,3,1,0,0,0\n").unwrap();
    assert_eq!(file.format, PosesFormat::Euroc);
    let (stamp, pose) = file.trajectory.poses()[0];
    assert_eq!(stamp, Stamp(1_403_636_580_838_555_648));
    assert!((pose.iso.rotation.angle() - std::f64::consts::PI).abs() < 1e-12, "half a turn about z");
}

#[test]
fn tables_are_read_by_their_names() {
    let file = read_poses("time[s], y_m , x_m, yaw_deg\n0,2,1,90\n1,3,1,-90\n").unwrap();
    assert_eq!((file.format, file.frame), (PosesFormat::Csv, PosesFrame::Body));
    let at = file.trajectory.poses()[0].1.iso;
    assert_eq!((at.translation.x, at.translation.y), (1.0, 2.0));
    assert!((at.rotation.euler_angles().2 - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    // Without a heading, a walk faces where it goes.
    let file = read_poses("a title\nt,x,y\n0,0,0\n1,0,0\n2,0,1\n3,1,1\n4,1,1\n").unwrap();
    let yaws: Vec<f64> = file.trajectory.poses().iter().map(|(_, p)| p.iso.rotation.euler_angles().2).collect();
    let quarter = std::f64::consts::FRAC_PI_2;
    for (yaw, expected) in yaws.iter().zip([quarter, quarter, 0.0, 0.0, 0.0]) {
        assert!((yaw - expected).abs() < 1e-12, "{yaws:?}");
    }
    let error = trajectory_as(PosesFormat::Csv, "t,x,heading\n0,0,0\n").unwrap_err().to_string();
    assert!(error.contains("no column for y"), "{error}");
}

fn trajectory_as(format: PosesFormat, text: &str) -> Result<trajectory::PosesFile, PosesError> {
    let dir = folder();
    std::fs::write(dir.path().join("poses.txt"), text).unwrap();
    trajectory::read(&dir.path().join("poses.txt"), &PosesOptions { format: Some(format), frame: None, fps: None })
}

#[test]
fn a_robots_log_keeps_its_order_and_loses_the_fewest_lines_with_bad_stamps() {
    // The third line's stamp is ahead of its time, the sixth repeats one.
    let log = "PARAM a b nohost 0\n\
               ODOM 0 0 0 0 0 0 100.0 host 0\n\
               ODOM 1 0 0 0 0 0 100.9 host 0.2\n\
               FLASER 2 1.0 1.0 9 9 9 9 9 9 100.2 host 0.2\n\
               ODOM 2 0 0 0 0 0 100.1 host 0.3\n\
               ODOM 3 0 0 0 0 0 100.2 host 0.4\n\
               ODOM 7 0 0 0 0 0 100.2 host 0.4\n\
               ODOM 4 0 0.5 0 0 0 100.3 host 0.5\n";
    let file = read_poses(log).unwrap();
    assert_eq!(file.format, PosesFormat::Carmen);
    let seen: Vec<(i64, f64)> = file.trajectory.poses().iter().map(|(t, p)| (t.0 / 1_000_000, p.iso.translation.x)).collect();
    assert_eq!(seen, [(0, 0.0), (100, 2.0), (200, 3.0), (300, 4.0)]);
    assert!(file.notes[0].starts_with("2 of 6 lines are dropped"), "{:?}", file.notes);
    let back = "ODOM 0 0 0 0 0 0 100.0 h 0\nODOM 0 0 0 0 0 0 50.0 h 0\n";
    assert!(matches!(read_poses(back), Err(PosesError::StampsGoBack { line: 2, .. })));
    assert!(matches!(read_poses("ODOM 0 0 0\nODOM 0 0 0\n"), Err(PosesError::Columns { line: 1, .. })));
    let still = "ODOM 0 0 0 0 0 0 50.0 h 0\nODOM 1 0 0 0 0 0 50.0 h 0\nODOM 2 0 0 0 0 0 50.0 h 0\n";
    assert!(matches!(read_poses(still), Err(PosesError::BadClock { dropped: 2, total: 3 })));
    // A log of laser lines only carries its odometry in them.
    let laser = "FLASER 2 1 1 9 9 9 4 5 0.5 10.0 h 0\nFLASER 2 1 1 9 9 9 5 5 0.5 10.5 h 0.5\n";
    let file = read_poses(laser).unwrap();
    assert_eq!(file.trajectory.poses()[1].1.iso.translation.x, 5.0);
}

#[test]
fn kitti_takes_its_times_from_the_file_beside() {
    let dir = folder();
    let path = dir.path().join("00.txt");
    // Two metres along the camera's z, which is forward.
    std::fs::write(&path, "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n").unwrap();
    let read = || trajectory::read(&path, &PosesOptions::default()).unwrap();
    let file = read();
    assert_eq!((file.format, file.frame), (PosesFormat::Kitti, PosesFrame::Camera));
    let (stamp, pose) = file.trajectory.poses()[1];
    assert_eq!(stamp, Stamp(100_000_000));
    assert!((pose.iso.translation.vector - nalgebra::Vector3::new(2.0, 0.0, 0.0)).norm() < 1e-12, "{pose:?}");
    assert!(pose.iso.rotation.angle() < 1e-12, "{pose:?}");
    std::fs::write(dir.path().join("times.txt"), "5.0\n5.25\n").unwrap();
    assert_eq!(read().trajectory.poses()[1].0, Stamp(5_250_000_000));
    std::fs::write(dir.path().join("times.txt"), "5.0\n").unwrap();
    assert!(read().notes.iter().any(|n| n.contains("1 times for 2 poses")));
    assert!(matches!(read_poses("1 0 0 0 0 1 0 0 0 0 7 0\n"), Err(PosesError::NotARotation { line: 1, .. })));
}

#[test]
fn real_trajectories_of_every_kind_are_read() {
    use PosesFormat::{Carmen, Csv, Kitti, Tum};
    for (name, format, count) in [
        ("robots_radish_carmen/raw/intel.clf.bz2", Carmen, 20_000),
        ("robots_radish_carmen/raw/mit-csail.clf.bz2", Carmen, 1988),
        ("kitti_odometry/KITTI_00_ORB.txt", Kitti, 4541),
        ("kitti_odometry/KITTI_00_gt.txt", Kitti, 4541),
        ("kitti_odometry/kittiodomeval_example0_09.txt", Kitti, 1000),
        ("simulated_hilti/floor_1_2025-05-05_run_1_seed1.tum", Tum, 500),
        ("vio_walks_no_plan/tum_corridor1_512_16_okvis.txt", Tum, 5000),
        ("vio_walks_no_plan/udel_gore.txt", Tum, 3000),
        ("vio_walks_no_plan/ARKit_camera_pose.txt", Kitti, 2000),
        ("piethein_walks_gt_on_plan/lopen1.1_gt_from_video.csv", Csv, 130),
    ] {
        let Some(path) = data(name) else { return };
        let file = trajectory::read(&path, &PosesOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(file.format, format, "{name}");
        assert!(file.trajectory.poses().len() >= count, "{name}: {} poses", file.trajectory.poses().len());
    }
}

#[test]
fn a_real_robots_way_is_as_long_as_it_was() {
    let Some(path) = data("robots_radish_carmen/raw/intel.clf.bz2") else { return };
    let file = trajectory::read(&path, &PosesOptions::default()).unwrap();
    let at = |i: usize| file.trajectory.poses()[i].1.iso.translation.vector;
    let length: f64 = (1..file.trajectory.poses().len()).map(|i| (at(i) - at(i - 1)).norm()).sum();
    // 509.1 m over all lines; sorted by its stamps it would be 675 m.
    assert!((length - 509.1).abs() < 2.0, "{length} m; {:?}", file.notes);
}

#[test]
fn a_real_camera_walk_stays_on_its_floor_when_it_becomes_a_bodys() {
    let options = PosesOptions { format: None, frame: Some(PosesFrame::Camera), fps: None };
    // A camera on a plan (z up), and one in its own world (y down).
    for name in ["rendered_hilti/truth.tum", "kitti_odometry/KITTI_00_ORB.txt"] {
        let Some(path) = data(name) else { return };
        let file = trajectory::read(&path, &options).unwrap();
        let up: f64 = file.trajectory.poses().iter().map(|(_, p)| (p.iso.rotation * nalgebra::Vector3::z()).z).sum();
        let up = up / file.trajectory.poses().len() as f64;
        assert!(up > 0.8, "{name}: the body's z axis is up to {up} on average; {:?}", file.notes);
    }
}

#[test]
fn a_folder_of_matrices_is_a_trajectory_of_the_camera() {
    let Some(path) = data("7scenes_redkitchen") else { return };
    let file = trajectory::read(&path, &PosesOptions { fps: Some(30.0), ..Default::default() }).unwrap();
    let poses = file.trajectory.poses();
    assert_eq!((poses.len(), file.frame), (180, PosesFrame::Camera));
    assert!((poses[179].0.as_secs() - 179.0 / 30.0).abs() < 1e-9);
    // Hand-held: no two frames are farther apart than its README says, 3.6 cm.
    let far = poses.windows(2).map(|w| (w[1].1.iso.translation.vector - w[0].1.iso.translation.vector).norm()).fold(0.0, f64::max);
    assert!(far < 0.037, "{far} m");
    let empty = folder();
    assert!(matches!(trajectory::read(empty.path(), &PosesOptions::default()), Err(PosesError::Empty)));
    std::fs::write(empty.path().join("a.pose.txt"), "1 2 3").unwrap();
    assert!(matches!(trajectory::read(empty.path(), &PosesOptions::default()), Err(PosesError::Columns { got: 3, .. })));
}

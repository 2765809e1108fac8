//! Formats whose lines are numbers in a fixed order: TUM, KITTI, EuRoC.

use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use planwalk_types::{Rigid3, Stamp};

use super::{PosesError, RawPose};
use crate::text;

/// What KITTI's cameras ran at, used where no times are given.
const KITTI_HZ: f64 = 10.0;

/// `t x y z qx qy qz qw`; further columns are passed over.
pub(super) fn tum(text: &str, notes: &mut Vec<String>) -> Result<Vec<RawPose>, PosesError> {
    let mut poses = Vec::new();
    let mut widest = 8;
    for (line, row) in text::data_lines(text) {
        let cells: Vec<&str> = row.split_whitespace().collect();
        if cells.len() < 8 {
            return Err(PosesError::Columns { line, got: cells.len(), expected: "TUM has 8: t x y z qx qy qz qw" });
        }
        widest = widest.max(cells.len());
        let stamp = stamp_s(line, cells[0])?;
        let n = numbers(line, &cells[1..8])?;
        let rotation = quaternion(line, n[6], n[3], n[4], n[5])?;
        poses.push(RawPose { line, stamp, world_from_thing: Rigid3::from_parts(Vector3::new(n[0], n[1], n[2]), rotation) });
    }
    if widest > 8 {
        notes.push(format!("lines have up to {widest} values; those after the eighth are not used"));
    }
    Ok(poses)
}

/// `ns,x,y,z,qw,qx,qy,qz,…`: w first.
pub(super) fn euroc(text: &str) -> Result<Vec<RawPose>, PosesError> {
    let mut poses = Vec::new();
    for (line, row) in text::data_lines(text) {
        let cells: Vec<&str> = row.split(',').map(str::trim).collect();
        if cells.len() < 8 {
            return Err(PosesError::Columns { line, got: cells.len(), expected: "EuRoC has at least 8: ns,x,y,z,qw,qx,qy,qz" });
        }
        let stamp = cells[0].parse().map(Stamp);
        let stamp = stamp.map_err(|_| PosesError::BadStamp { line, value: cells[0].to_owned(), unit: "whole nanoseconds" })?;
        let n = numbers(line, &cells[1..8])?;
        let rotation = quaternion(line, n[3], n[4], n[5], n[6])?;
        poses.push(RawPose { line, stamp, world_from_thing: Rigid3::from_parts(Vector3::new(n[0], n[1], n[2]), rotation) });
    }
    Ok(poses)
}

/// Twelve numbers a line; a thirteenth in front is the frame's number, or its nanoseconds.
pub(super) fn kitti(text: &str, times: &Times, notes: &mut Vec<String>) -> Result<Vec<RawPose>, PosesError> {
    let mut poses = Vec::new();
    let mut numbered = true;
    for (line, row) in text::data_lines(text) {
        let cells: Vec<&str> = row.split_whitespace().collect();
        let (head, matrix) = match cells.len() {
            12 => (None, &cells[..]),
            13 => (Some(cells[0]), &cells[1..]),
            got => return Err(PosesError::Columns { line, got, expected: "KITTI has 12: three rows of world ← camera" }),
        };
        let n = numbers(line, matrix)?;
        let stamp = match head {
            None => {
                numbered = false;
                frame_stamp(poses.len() as f64)
            }
            Some(head) => frame_or_ns(line, head)?,
        };
        let rotation = rotation(line, &Matrix3::new(n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10]))?;
        poses.push(RawPose { line, stamp, world_from_thing: Rigid3::from_parts(Vector3::new(n[3], n[7], n[11]), rotation) });
    }
    if !numbered {
        take_times(&mut poses, times, notes)?;
    }
    Ok(poses)
}

fn frame_stamp(frame: f64) -> Stamp {
    Stamp::from_secs(frame / KITTI_HZ).unwrap_or(Stamp(0))
}

fn frame_or_ns(line: usize, head: &str) -> Result<Stamp, PosesError> {
    let value = numbers(line, &[head])?[0];
    // No clip has 10^12 frames, and no clock shows 10^12 ns for long (17 minutes after boot).
    if value < 1e12 {
        return Ok(frame_stamp(value));
    }
    head.parse().map(Stamp).map_err(|_| PosesError::BadStamp { line, value: head.to_owned(), unit: "whole nanoseconds" })
}

/// Where KITTI's times are.
pub(super) enum Times {
    /// In this file, for sure.
    Given(PathBuf),
    /// In this file, if it fits.
    Beside(PathBuf),
    /// Nowhere.
    None,
}

impl Times {
    /// Those found beside the poses.
    pub(super) fn beside(poses: &Path) -> Self {
        times_beside(poses).map_or(Self::None, Self::Beside)
    }
}

/// Takes times from a file, where there is one that fits.
fn take_times(poses: &mut [RawPose], from: &Times, notes: &mut Vec<String>) -> Result<(), PosesError> {
    let assumed = format!("KITTI poses carry no time: {KITTI_HZ} Hz is assumed");
    let (Times::Given(file) | Times::Beside(file)) = from else {
        notes.push(format!("{assumed} (a file times.txt beside it would be used)"));
        return Ok(());
    };
    let name = file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let text = text::read(file)?;
    let times: Vec<(usize, &str)> = text::data_lines(&text).collect();
    let given = matches!(from, Times::Given(_));
    if times.len() != poses.len() && given {
        return Err(PosesError::TimesMismatch { times: times.len(), poses: poses.len() });
    }
    if times.len() != poses.len() {
        notes.push(format!("{name} has {} times for {} poses and is not used; {assumed}", times.len(), poses.len()));
        return Ok(());
    }
    for (pose, (line, time)) in poses.iter_mut().zip(times) {
        pose.stamp = stamp_s(line, time)?;
    }
    notes.push(format!("times are from {name}"));
    Ok(())
}

/// The times that go with KITTI poses: `NAME_times.txt` or `times.txt` in the same folder, where there is one.
pub fn times_beside(path: &Path) -> Option<PathBuf> {
    let stem = path.file_stem()?.to_string_lossy();
    [format!("{stem}_times.txt"), "times.txt".to_owned()].into_iter().map(|name| path.with_file_name(name)).find(|file| file.is_file())
}

pub(super) fn stamp_s(line: usize, value: &str) -> Result<Stamp, PosesError> {
    text::seconds(value).ok_or_else(|| PosesError::BadStamp { line, value: value.to_owned(), unit: "seconds" })
}

fn numbers(line: usize, cells: &[&str]) -> Result<Vec<f64>, PosesError> {
    cells.iter().map(|cell| number(line, "a pose's value", cell)).collect()
}

pub(super) fn number(line: usize, what: &'static str, cell: &str) -> Result<f64, PosesError> {
    let value = cell.parse().ok().filter(|v: &f64| v.is_finite());
    value.ok_or_else(|| PosesError::NotANumber { line, what, value: cell.to_owned() })
}

pub(super) fn quaternion(line: usize, w: f64, x: f64, y: f64, z: f64) -> Result<UnitQuaternion<f64>, PosesError> {
    let q = Quaternion::new(w, x, y, z);
    let norm = q.norm();
    // Files round to a few digits; further off than a tenth, these are other numbers.
    if (norm - 1.0).abs() > 0.1 {
        return Err(PosesError::NotARotation { line, reason: format!("a quaternion of length {norm:.3}") });
    }
    Ok(UnitQuaternion::from_quaternion(q))
}

pub(super) fn rotation(line: usize, matrix: &Matrix3<f64>) -> Result<UnitQuaternion<f64>, PosesError> {
    let off = (matrix * matrix.transpose() - Matrix3::identity()).abs().max();
    if off > 0.05 || matrix.determinant() < 0.0 {
        let reason = format!("its rows are {off:.3} off being perpendicular and of length 1, determinant {:.3}", matrix.determinant());
        return Err(PosesError::NotARotation { line, reason });
    }
    Ok(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix)))
}

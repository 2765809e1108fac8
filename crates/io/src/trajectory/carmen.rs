//! What did a robot's wheels say? Logs of the Carnegie Mellon Robot Navigation Toolkit.
//!
//! `ODOM x y theta tv rv accel ipc_time host logger_time`, and
//! `FLASER n r1 … rn x y theta odom_x odom_y odom_theta ipc_time host logger_time` where a log has no `ODOM` lines.
//! Stamps are `ipc_time` from the first one on.
//! Pitfall: some stamps are wrong by a few tenths of a second, or repeated. The order of the lines is the robot's (sorted by
//! stamp, the Intel lab's 509 m become 675 m of to and fro), so the lines whose stamps do not fit are left out, as few as
//! possible.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Rigid3, Stamp};

use super::{PosesError, RawPose, rows};
use crate::text;

/// Longest way back of a stamp that is taken for a slip, seconds; a longer one means that another log begins.
const SLIP_S: f64 = 2.0;

/// The poses of a log, stamps from the first one on.
pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<Vec<RawPose>, PosesError> {
    let mut poses = on_own_clock(text, notes)?;
    let start = first_stamp(&poses);
    for pose in &mut poses {
        pose.stamp = since(pose.stamp, start);
    }
    Ok(poses)
}

/// What the log's own clock shows when its poses begin: the zero of all stamps that are read from it.
pub(super) fn start(text: &str) -> Result<Stamp, PosesError> {
    on_own_clock(text, &mut Vec::new()).map(|poses| first_stamp(&poses))
}

/// A stamp of the log's clock as one from `start` on.
pub(super) fn since(stamp: Stamp, start: Stamp) -> Stamp {
    Stamp(stamp.0.saturating_sub(start.0))
}

fn first_stamp(poses: &[RawPose]) -> Stamp {
    poses.first().map_or(Stamp(0), |pose| pose.stamp)
}

/// The poses with the log's own stamps, strictly increasing.
fn on_own_clock(text: &str, notes: &mut Vec<String>) -> Result<Vec<RawPose>, PosesError> {
    let wheels = lines(text, "ODOM", |cells| Some((cells.get(1..4)?.try_into().ok()?, *cells.get(7)?)))?;
    let in_order = check_slips(&wheels);
    let mut poses = if wheels.len() >= 2 && in_order.is_ok() {
        wheels
    } else {
        let laser = lines(text, "FLASER", odometry_of_scan)?;
        if laser.len() < 2 {
            // What is wrong with the wheels' lines is the better message.
            in_order?;
        }
        notes.push("the odometry is taken from the laser's lines: there are no ODOM lines with increasing stamps".to_owned());
        check_slips(&laser)?;
        laser
    };
    let before = poses.len();
    keep_increasing(&mut poses, |pose| pose.stamp);
    let dropped = before - poses.len();
    if 2 * dropped > before {
        return Err(PosesError::BadClock { dropped, total: before });
    }
    if dropped > 0 {
        notes.push(format!("{dropped} of {before} lines are dropped: their stamps are repeated or go back"));
    }
    Ok(poses)
}

/// x, y, theta of the odometry and the stamp among the cells of a `FLASER` line.
fn odometry_of_scan<'a>(cells: &[&'a str]) -> Option<([&'a str; 3], &'a str)> {
    let beams: usize = cells.get(1)?.parse().ok()?;
    let pose = beams.checked_add(5)?;
    Some((cells.get(pose..pose.checked_add(3)?)?.try_into().ok()?, *cells.get(pose + 3)?))
}

/// Poses of all lines that begin with `word`; `pick` finds x, y, theta and the stamp among the cells.
fn lines<'a>(text: &'a str, word: &str, pick: impl Fn(&[&'a str]) -> Option<([&'a str; 3], &'a str)>) -> Result<Vec<RawPose>, PosesError> {
    let mut poses = Vec::new();
    for (line, row) in text::data_lines(text) {
        if row.split_whitespace().next() != Some(word) {
            continue;
        }
        let cells: Vec<&str> = row.split_whitespace().collect();
        let expected = "its kind has more: is it cut off?";
        let ([x, y, theta], time) = pick(&cells).ok_or(PosesError::Columns { line, got: cells.len(), expected })?;
        let (x, y) = (rows::number(line, "x", x)?, rows::number(line, "y", y)?);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rows::number(line, "theta", theta)?);
        let world_from_thing = Rigid3::from_parts(Vector3::new(x, y, 0.0), turn);
        poses.push(RawPose { line, stamp: rows::stamp_s(line, time)?, world_from_thing });
    }
    Ok(poses)
}

/// Refuses stamps that go back by more than a slip.
fn check_slips(poses: &[RawPose]) -> Result<(), PosesError> {
    let mut latest = Stamp(i64::MIN);
    for pose in poses {
        if pose.stamp < latest && latest.secs_since(pose.stamp) > SLIP_S {
            let (at_s, before_s) = (pose.stamp.as_secs(), latest.as_secs());
            return Err(PosesError::StampsGoBack { line: pose.line, at_s, before_s });
        }
        latest = latest.max(pose.stamp);
    }
    Ok(())
}

/// Leaves out as few items as possible so that stamps increase (longest increasing subsequence, by patience sorting).
/// Of items with one stamp the first stays.
pub(super) fn keep_increasing<T>(items: &mut Vec<T>, stamp: impl Fn(&T) -> Stamp) {
    // piles[k]: the item with the earliest stamp that can end a sequence of k + 1 items.
    let mut piles: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let pile = piles.partition_point(|&k| stamp(&items[k]) < stamp(item));
        before.push(pile.checked_sub(1).map(|below| piles[below]));
        match piles.get_mut(pile) {
            None => piles.push(i),
            Some(top) if stamp(&items[*top]) > stamp(item) => *top = i,
            Some(_) => {}
        }
    }
    let mut keep = vec![false; items.len()];
    let mut at = piles.last().copied();
    while let Some(i) = at {
        keep[i] = true;
        at = before[i];
    }
    let mut keep = keep.into_iter();
    items.retain(|_| keep.next().unwrap_or(false));
}

//! What did a robot's laser see, and when? The `FLASER` lines of a CARMEN log.
//!
//! `FLASER n r1 … rn x y theta odom_x odom_y odom_theta ipc_time host logger_time`: n readings over 180°, from the right (−90°)
//! to the left, in metres; then the pose of the laser, and the odometry at that moment.
//! Pitfalls: 180 readings are 1° apart and end at +89°, 181 or 361 reach +90° (with the other reading of 180 the walls of the
//! Intel lab, drawn by its corrected log in cells of 5 cm, are 8 % fatter). Corrected logs round their stamps to six digits, so
//! that ten thousand seconds share one: [`at_raw_stamps`] gives them back.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Rigid3, Stamp};

use super::{PosesError, RawPose, carmen, rows};
use crate::text;

/// One turn of the laser's mirror.
pub(crate) struct Scan {
    /// On the clock of the poses that are read from the same log.
    pub stamp: Stamp,
    /// Distances from the right to the left, metres.
    pub readings_m: Vec<f32>,
    /// Its line in the log, from 1.
    line: usize,
    /// x, y, theta of the laser.
    pub laser: [f64; 3],
    /// x, y, theta of the robot by its odometry.
    pub odometry: [f64; 3],
}

impl Scan {
    /// Directions of the first reading and from each to the next, radians anticlockwise from the laser's forward.
    pub(crate) fn fan(count: usize) -> (f64, f64) {
        // An odd number has a middle one, and both ends; an even number leaves the last out.
        let gaps = if count % 2 == 1 { count.max(2) - 1 } else { count.max(1) };
        (-FRAC_PI_2, PI / gaps as f64)
    }

    /// What two lines of the same scan have in common however they are written: its readings in whole centimetres.
    fn fingerprint(&self) -> Vec<u16> {
        self.readings_m.iter().map(|r| (100.0 * r).round().clamp(0.0, f32::from(u16::MAX)) as u16).collect()
    }
}

/// Whether a text is a robot's log with scans in it.
pub(crate) fn has_scans(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("FLASER "))
}

/// The scans of a log, with strictly increasing stamps on the clock of its poses; those whose stamps do not fit are left out.
pub(crate) fn read(text: &str, notes: &mut Vec<String>) -> Result<Vec<Scan>, PosesError> {
    let start = carmen::start(text)?;
    let mut scans = all(text, start)?;
    let total = scans.len();
    carmen::keep_increasing(&mut scans, |scan| scan.stamp);
    let dropped = total - scans.len();
    if 2 * dropped > total {
        return Err(PosesError::BadClock { dropped, total });
    }
    if dropped > 0 {
        notes.push(format!("{dropped} of {total} scans are dropped: their stamps are repeated or go back"));
    }
    Ok(scans)
}

/// Every scan in the order of the lines.
fn all(text: &str, start: Stamp) -> Result<Vec<Scan>, PosesError> {
    let lines = text::data_lines(text).filter(|(_, row)| row.split_whitespace().next() == Some("FLASER"));
    lines.map(|(line, row)| parse(line, row, start)).collect()
}

fn parse(line: usize, row: &str, start: Stamp) -> Result<Scan, PosesError> {
    let cells: Vec<&str> = row.split_whitespace().collect();
    let short =
        || PosesError::Columns { line, got: cells.len(), expected: "FLASER n has n readings, two poses and a time: is it cut off?" };
    let count: usize = cells.get(1).and_then(|n| n.parse().ok()).ok_or_else(short)?;
    let rest = cells.get(2..).unwrap_or(&[]);
    let (readings, after) = rest.split_at_checked(count).filter(|(_, after)| after.len() >= 7).ok_or_else(short)?;
    let pose = |from: usize| -> Result<[f64; 3], PosesError> {
        let value = |k: usize, what| rows::number(line, what, after[from + k]);
        Ok([value(0, "x")?, value(1, "y")?, value(2, "theta")?])
    };
    let reading = |cell: &&str| rows::number(line, "a reading", cell).map(|r| r as f32);
    Ok(Scan {
        line,
        stamp: carmen::since(rows::stamp_s(line, after[6])?, start),
        readings_m: readings.iter().map(reading).collect::<Result<_, _>>()?,
        laser: pose(0)?,
        odometry: pose(3)?,
    })
}

/// The poses of a corrected log (those of its laser) at the times of the raw log in which the same scans stand.
///
/// A corrected scan takes the stamp of the next raw scan with the same readings, so that a robot that stood and saw the same twice
/// does not go back in time. Stamps are those that [`super::read`] gives the raw log's poses.
///
/// # Errors
/// [`PosesError::Times`] when the raw log cannot be read; [`PosesError::OtherScans`] when less than half of the corrected scans are
/// in it: they are not of one drive.
pub(super) fn at_raw_stamps(corrected: &str, raw: &Path, notes: &mut Vec<String>) -> Result<Vec<RawPose>, PosesError> {
    let in_raw = text::read(raw).map_err(PosesError::from).and_then(|text| read(&text, notes));
    let mut known: HashMap<Vec<u16>, Vec<Stamp>> = HashMap::new();
    for scan in in_raw.map_err(|why| PosesError::Times { path: raw.to_owned(), why: Box::new(why) })? {
        known.entry(scan.fingerprint()).or_default().push(scan.stamp);
    }
    // The corrected log's own stamps are of no use, nor is its clock's start.
    let scans = all(corrected, Stamp(0))?;
    let mut found: Vec<(Stamp, &Scan)> = Vec::new();
    for scan in &scans {
        let Some(times) = known.get(&scan.fingerprint()) else { continue };
        let after = found.last().map_or(Stamp(i64::MIN), |(stamp, _)| *stamp);
        // Nothing later: the one before was an accident, or this one is; the longest increasing sequence decides.
        let time = times.iter().find(|time| **time > after).or(times.last());
        found.extend(time.map(|time| (*time, scan)));
    }
    carmen::keep_increasing(&mut found, |(stamp, _)| *stamp);
    let (got, total) = (found.len(), scans.len());
    if got < 2 || 2 * got < total {
        return Err(PosesError::OtherScans { found: got, total });
    }
    notes.push(format!("{got} of {total} corrected scans are in the raw log, and have its stamps"));
    let pose =
        |[x, y, theta]: [f64; 3]| Rigid3::from_parts(Vector3::new(x, y, 0.0), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), theta));
    Ok(found.into_iter().map(|(stamp, scan)| RawPose { line: scan.line, stamp, world_from_thing: pose(scan.laser) }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::PosesOptions;

    #[test]
    fn readings_go_from_the_right_to_the_left() {
        let last = |count: usize| (Scan::fan(count).0 + (count - 1) as f64 * Scan::fan(count).1).to_degrees();
        assert!((last(180) - 89.0).abs() < 1e-9 && (last(181) - 90.0).abs() < 1e-9 && (last(361) - 90.0).abs() < 1e-9);
        // Degenerate fans divide by nothing.
        assert!(Scan::fan(0).1.is_finite() && Scan::fan(1).1.is_finite());
    }

    #[test]
    fn scans_share_the_clock_of_the_wheels() {
        let text = "ODOM 0 0 0 0 0 0 100.5 h 0\nFLASER 3 1 2 3 0 0 0 0 0 0 100.75 h 0\nODOM 1 0 0 0 0 0 101.5 h 1\n";
        let scans = read(text, &mut Vec::new()).unwrap();
        assert_eq!((scans.len(), scans[0].stamp), (1, Stamp(250_000_000)));
        assert_eq!(scans[0].readings_m, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn cut_off_scans_are_named_with_their_line() {
        let head = "ODOM 0 0 0 0 0 0 1 h 0\nODOM 1 0 0 0 0 0 2 h 1\n";
        let error = |row: &str| read(&format!("{head}{row}\n"), &mut Vec::new()).err().unwrap();
        assert!(matches!(error("FLASER 3 1 2"), PosesError::Columns { line: 3, .. }));
        assert!(matches!(error("FLASER"), PosesError::Columns { line: 3, .. }));
        assert!(matches!(error("FLASER 18446744073709551615 1"), PosesError::Columns { line: 3, .. }));
        assert!(matches!(error("FLASER 1 nan 0 0 0 0 0 0 1 h 1"), PosesError::NotANumber { line: 3, .. }));
    }

    #[test]
    fn corrected_poses_get_the_times_of_the_scans_they_share() {
        let dir = tempfile::tempdir().unwrap();
        let (raw, corrected) = (dir.path().join("raw"), dir.path().join("corrected"));
        // The robot stands for the first two scans, and the corrected log writes its numbers shorter.
        let scan = |r: &str, x: f64, t: &str| format!("FLASER 2 {r} {x} 0 0 {x} 0 0 {t} h 0\n");
        let rows = [scan("1.00 2.00", 0.0, "50.0"), scan("1.00 2.00", 0.0, "50.2"), scan("1.10 2.10", 1.0, "51.0")];
        std::fs::write(&raw, rows.concat()).unwrap();
        let rows = [scan("1 2", 5.0, "1e9"), scan("1 2", 5.1, "1e9"), scan("1.1 2.1", 6.0, "1e9")];
        std::fs::write(&corrected, rows.concat()).unwrap();
        let timed = || crate::trajectory::read_with_times(&corrected, &PosesOptions::default(), &raw);
        let file = timed().unwrap();
        let found: Vec<(i64, f64)> = file.trajectory.poses().iter().map(|(s, p)| (s.0, p.iso.translation.x)).collect();
        assert_eq!(found, [(0, 5.0), (200_000_000, 5.1), (1_000_000_000, 6.0)]);
        std::fs::write(&corrected, [scan("7 7", 5.0, "0"), scan("8 8", 5.0, "1")].concat()).unwrap();
        assert!(matches!(timed(), Err(PosesError::OtherScans { found: 0, total: 2 })));
        std::fs::write(&raw, "FLASER 3 1 2\n").unwrap();
        let why = timed().unwrap_err().to_string();
        assert!(why.contains("line 1") && why.contains(&raw.display().to_string()), "{why}");
    }
}

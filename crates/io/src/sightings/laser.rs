//! Which of a laser's readings are sightings? Those that met something, spread over the view, seen from the robot.

use planwalk_types::{Sighting, Stamp};

use super::SightingsError;
use crate::text;
use crate::trajectory::scan::{self, Scan};

/// Readings from here on mean that nothing was met, metres: lasers of robots write 81.83 or 81.91 then, and no corridor is as long.
const NOTHING_FROM_M: f32 = 50.0;
/// The same for lasers in their 8 m mode, which write 8.18 to 8.191.
const NOTHING_FROM_SHORT_M: f32 = 8.1;
/// A log is of the 8 m mode when no reading is longer.
const LONGEST_SHORT_M: f32 = 8.2;
/// Readings nearer than this are the robot itself, metres.
const OWN_BODY_M: f32 = 0.05;
/// Standard deviation of a reading, metres. Lasers of this kind err by 5 mm at random and up to 15 mm in common, logs are
/// written in whole centimetres, and the robot moves by some centimetres in the time of a scan.
const SIGMA_M: f64 = 0.03;
/// Readings that are kept lie about this far apart, radians (4°): some 45 a scan. A localiser that uses 16 rays of a few scans at
/// a time has ample choice, and an hour at 5 Hz is a million sightings instead of five. From scan to scan the choice moves on by
/// one reading, so that a robot that stands still shows all that it sees.
const APART_RAD: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// A laser sits on its robot: its offset from the odometry's pose may differ by this from scan to scan, metres or radians.
const OFFSET_SLACK: f64 = 0.01;

pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<Vec<Sighting>, SightingsError> {
    let scans = scan::read(text, notes)?;
    let limit_m = limit(text, &scans);
    let offset = mount(&scans, notes);
    let mut sightings = Vec::new();
    let mut readings = 0;
    for (index, scan) in scans.iter().enumerate() {
        readings += scan.readings_m.len();
        let (first, step) = Scan::fan(scan.readings_m.len());
        let stride = (APART_RAD / step).round().max(1.0) as usize;
        for (k, range) in scan.readings_m.iter().enumerate().skip(index % stride).step_by(stride) {
            if (OWN_BODY_M..limit_m).contains(range) {
                sightings.extend(seen(scan.stamp, first + k as f64 * step, f64::from(*range), offset));
            }
        }
    }
    if sightings.is_empty() {
        return Err(SightingsError::NothingMet { readings, limit_m });
    }
    notes.push(format!(
        "{} laser scans: every {:.0}° a reading is taken, those of {limit_m} m or more saw nothing; {} sightings",
        scans.len(),
        APART_RAD.to_degrees(),
        sightings.len()
    ));
    Ok(sightings)
}

/// The reading as the body sees it, when the laser sits at `[x, y, theta]` in the body's frame.
fn seen(stamp: Stamp, bearing_rad: f64, range: f64, [x, y, theta]: [f64; 3]) -> Option<Sighting> {
    let (s, c) = (theta + bearing_rad).sin_cos();
    let (forward, left) = (x + range * c, y + range * s);
    let range = forward.hypot(left);
    (range > 0.0).then(|| Sighting { stamp, bearing_rad: left.atan2(forward), range, sigma: SIGMA_M })
}

/// From where on readings mean nothing, metres: as the log's own parameter says, else as its longest reading shows.
fn limit(text: &str, scans: &[Scan]) -> f32 {
    let parameter = text::data_lines(text).take_while(|(_, row)| !row.starts_with("FLASER")).find_map(|(_, row)| {
        let mut words = row.split_whitespace();
        let is_it = words.next() == Some("PARAM") && words.next().is_some_and(|name| name.ends_with("front_laser_max"));
        words.next().filter(|_| is_it)?.parse().ok().filter(|max: &f32| *max > OWN_BODY_M)
    });
    let longest = scans.iter().flat_map(|scan| &scan.readings_m).fold(0.0f32, |longest, r| longest.max(*r));
    let seen = if (NOTHING_FROM_SHORT_M..LONGEST_SHORT_M).contains(&longest) { NOTHING_FROM_SHORT_M } else { NOTHING_FROM_M };
    parameter.map_or(seen, |max| seen.min(max))
}

/// Where the laser sits on the robot, `body ← laser`: its pose against the odometry's, if it is the same in all scans.
fn mount(scans: &[Scan], notes: &mut Vec<String>) -> [f64; 3] {
    let relative = |scan: &Scan| {
        let ([lx, ly, lt], [x, y, theta]) = (scan.laser, scan.odometry);
        let (s, c) = theta.sin_cos();
        let (dx, dy) = (lx - x, ly - y);
        [c * dx + s * dy, c * dy - s * dx, planwalk_types::wrap_angle(lt - theta)]
    };
    let first = scans.first().map_or([0.0; 3], relative);
    let fixed = scans.iter().all(|scan| relative(scan).iter().zip(first).all(|(a, b)| (a - b).abs() < OFFSET_SLACK));
    if !fixed {
        notes.push(
            "the laser's poses are not fixed to the odometry (a corrected log?): it is taken to sit at the robot's centre".to_owned(),
        );
        return [0.0; 3];
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const HEAD: &str = "ODOM 0 0 0 0 0 0 10 h 0\nODOM 1 0 0 0 0 0 20 h 1\n";

    fn scan(readings: &[f64], poses: &str, time_s: f64) -> String {
        let readings: Vec<String> = readings.iter().map(f64::to_string).collect();
        format!("FLASER {} {} {poses} {time_s} h 0\n", readings.len(), readings.join(" "))
    }

    fn sightings(lines: &[String]) -> (Vec<Sighting>, Vec<String>) {
        let mut notes = Vec::new();
        (read(&format!("{HEAD}{}", lines.concat()), &mut notes).unwrap(), notes)
    }

    #[test]
    fn the_first_reading_is_on_the_right_and_the_last_on_the_left() {
        // Three readings are 90° apart: none is thinned out.
        let (seen, _) = sightings(&[scan(&[1.0, 2.0, 3.0], "0 0 0 0 0 0", 11.0)]);
        let bearings: Vec<(f64, f64)> = seen.iter().map(|s| (s.bearing_rad, s.range)).collect();
        assert_eq!(bearings, [(-FRAC_PI_2, 1.0), (0.0, 2.0), (FRAC_PI_2, 3.0)]);
        assert_eq!(seen[0].stamp, Stamp(1_000_000_000));
    }

    #[test]
    fn readings_that_met_nothing_are_no_sightings() {
        let (seen, _) = sightings(&[scan(&[81.91, 2.0, 0.0], "0 0 0 0 0 0", 11.0)]);
        assert_eq!(seen.len(), 1);
        let (short_mode, _) = sightings(&[scan(&[8.19, 2.0, 8.18], "0 0 0 0 0 0", 11.0)]);
        assert_eq!(short_mode.len(), 1);
        let by_parameter = format!("PARAM robot_front_laser_max 1.5 h 0\n{}", scan(&[1.0, 2.0, 8.18], "0 0 0 0 0 0", 11.0));
        assert_eq!(sightings(&[by_parameter]).0.len(), 1);
        let blind = read(&format!("{HEAD}{}", scan(&[81.91; 3], "0 0 0 0 0 0", 11.0)), &mut Vec::new());
        assert!(matches!(blind, Err(SightingsError::NothingMet { readings: 3, .. })));
    }

    #[test]
    fn a_robot_that_stands_shows_every_reading_in_time() {
        let stride = 4;
        let lines: Vec<String> = (0..stride).map(|i| scan(&[2.0; 180], "0 0 0 0 0 0", 11.0 + i as f64)).collect();
        let (seen, _) = sightings(&lines);
        assert_eq!(seen.len(), 180);
        let mut degrees: Vec<i64> = seen.iter().map(|s| s.bearing_rad.to_degrees().round() as i64).collect();
        degrees.sort_unstable();
        assert_eq!(degrees, (-90..90).collect::<Vec<_>>());
    }

    #[test]
    fn a_laser_in_front_of_the_robot_sees_from_there() {
        // Half a metre ahead of a robot that faces +y.
        let (seen, notes) = sightings(&[scan(&[1.0, 2.0, 1.0], "3 4.5 1.5707963267948966 3 4 1.5707963267948966", 11.0)]);
        let ahead = seen.iter().find(|s| s.bearing_rad.abs() < 1e-9).unwrap();
        assert!((ahead.range - 2.5).abs() < 1e-9);
        assert!((seen[2].range - 1.25f64.sqrt()).abs() < 1e-9 && (seen[2].bearing_rad - 1.0f64.atan2(0.5)).abs() < 1e-9);
        assert!(!notes.iter().any(|n| n.contains("centre")));
        let wandering = [scan(&[2.0; 3], "1 0 0 0 0 0", 11.0), scan(&[2.0; 3], "7 0 0 0 0 0", 12.0)];
        let (seen, notes) = sightings(&wandering);
        assert!(notes.iter().any(|n| n.contains("centre")) && seen.iter().all(|s| (s.range - 2.0).abs() < 1e-9));
    }
}

//! What was seen? A table, CSV `t_s,bearing_rad,range,sigma`, or a laser's scans in a robot's log (CARMEN, `FLASER`).
//!
//! Body frame: bearing in radians anticlockwise from forward; range and sigma in the odometry's unit. Gzip and bzip2 are unpacked.
//! Stamps of a log are those of the poses that are read from it: its first pose is zero.

mod laser;

use std::io::{BufWriter, Write};
use std::path::Path;

use planwalk_types::{Sighting, Stamp};

use crate::text;
use crate::trajectory::{PosesError, scan};

const COLUMNS: [&str; 4] = ["t_s", "bearing_rad", "range", "sigma"];

/// Why a table of sightings cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum SightingsError {
    /// The file system refuses.
    #[error("the sightings cannot be read or written: {0}")]
    Io(#[from] std::io::Error),
    /// The first line does not name the columns.
    #[error(
        "no column \"{missing}\" in the header: the first line must name t_s,bearing_rad,range,sigma; a robot's log needs FLASER lines"
    )]
    NoColumn {
        /// The column that is not there.
        missing: &'static str,
    },
    /// A cell is no number.
    #[error("line {line}: {column} is \"{value}\", not a finite number")]
    NotANumber {
        /// Line, counted from 1.
        line: usize,
        /// Its column.
        column: &'static str,
        /// What stands there.
        value: String,
    },
    /// A distance or its uncertainty is not positive.
    #[error("line {line}: {column} is {value}, but a length must not be negative, nor an uncertainty zero")]
    NotPositive {
        /// Line, counted from 1.
        line: usize,
        /// Its column.
        column: &'static str,
        /// What stands there.
        value: f64,
    },
    /// Time runs backwards.
    #[error("line {line}: {at_s:.6} s comes after {before_s:.6} s; sort the sightings by time")]
    StampsGoBack {
        /// Line, counted from 1.
        line: usize,
        /// Its stamp.
        at_s: f64,
        /// The stamp before.
        before_s: f64,
    },
    /// A robot's log that is broken.
    #[error("the robot's log: {0}")]
    Log(#[from] PosesError),
    /// Scans that never met anything.
    #[error("none of the {readings} readings in the log's scans is shorter than {limit_m} m: the laser saw nothing that could be compared")]
    NothingMet {
        /// Readings there are.
        readings: usize,
        /// From here on a reading means nothing, metres.
        limit_m: f32,
    },
    /// Nothing below the header.
    #[error("the file holds no sightings: leave the option away to go without")]
    Empty,
}

/// Sightings, and how they were read.
#[derive(Debug, Clone)]
pub struct SightingsFile {
    /// In time order; many may share a stamp.
    pub sightings: Vec<Sighting>,
    /// What was decided on the way, for people.
    pub notes: Vec<String>,
}

/// Reads sightings in time order; many may share a stamp. The same as [`open`] without its notes.
///
/// # Errors
/// [`SightingsError`], with the line.
pub fn read(path: &Path) -> Result<Vec<Sighting>, SightingsError> {
    Ok(open(path)?.sightings)
}

/// Reads a table of sightings, or the scans of a robot's log; its content says which.
///
/// A table's columns are found by name, others are passed over. Rows with a range of exactly zero are left out: that is how
/// sensors say that they saw nothing. Of a scan, readings some 4° apart are taken, see the notes of the result.
///
/// # Errors
/// [`SightingsError`], with the line.
pub fn open(path: &Path) -> Result<SightingsFile, SightingsError> {
    let text = text::read(path)?;
    let mut notes = Vec::new();
    let sightings = if scan::has_scans(&text) { laser::read(&text, &mut notes)? } else { table(&text)? };
    Ok(SightingsFile { sightings, notes })
}

fn table(text: &str) -> Result<Vec<Sighting>, SightingsError> {
    let mut lines = text::data_lines(text);
    let (_, header) = lines.next().ok_or(SightingsError::Empty)?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let mut at = [0; 4];
    for (place, missing) in at.iter_mut().zip(COLUMNS) {
        *place = names.iter().position(|name| *name == missing).ok_or(SightingsError::NoColumn { missing })?;
    }
    let mut sightings: Vec<Sighting> = Vec::new();
    for (line, row) in lines {
        let sighting = parse_row(line, row, at)?;
        if let Some(before) = sightings.last().filter(|s| s.stamp > sighting.stamp) {
            let (at_s, before_s) = (sighting.stamp.as_secs(), before.stamp.as_secs());
            return Err(SightingsError::StampsGoBack { line, at_s, before_s });
        }
        if sighting.range > 0.0 {
            sightings.push(sighting);
        }
    }
    if sightings.is_empty() { Err(SightingsError::Empty) } else { Ok(sightings) }
}

fn parse_row(line: usize, row: &str, at: [usize; 4]) -> Result<Sighting, SightingsError> {
    let cells: Vec<&str> = row.split(',').map(str::trim).collect();
    let cell = |k: usize| cells.get(at[k]).copied().unwrap_or("");
    let refuse = |k: usize| SightingsError::NotANumber { line, column: COLUMNS[k], value: cell(k).to_owned() };
    let number = |k: usize| cell(k).parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| refuse(k));
    let refuse_sign = |k: usize, value| SightingsError::NotPositive { line, column: COLUMNS[k], value };
    let stamp: Stamp = text::seconds(cell(0)).ok_or_else(|| refuse(0))?;
    let (bearing_rad, range, sigma) = (number(1)?, number(2)?, number(3)?);
    if range < 0.0 {
        return Err(refuse_sign(2, range));
    }
    if sigma <= 0.0 {
        return Err(refuse_sign(3, sigma));
    }
    Ok(Sighting { stamp, bearing_rad, range, sigma })
}

/// Writes sightings so that [`read`] gives back the same numbers.
///
/// # Errors
/// [`SightingsError::Io`].
pub fn write(path: &Path, sightings: &[Sighting]) -> Result<(), SightingsError> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    writeln!(file, "{}", COLUMNS.join(","))?;
    for s in sightings {
        writeln!(file, "{},{},{},{}", text::decimal_seconds(s.stamp), s.bearing_rad, s.range, s.sigma)?;
    }
    file.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(content: &str) -> Result<Vec<Sighting>, SightingsError> {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("s.csv"), content).unwrap();
        read(&dir.path().join("s.csv"))
    }

    #[test]
    fn what_was_written_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("s.csv");
        let of = |ns, bearing_rad, range| Sighting { stamp: Stamp(ns), bearing_rad, range, sigma: 0.1 };
        let sightings = vec![of(-5, -1.0 / 3.0, 2.0), of(7, 0.1, 1e-7), of(7, 0.2, 12.5)];
        write(&path, &sightings).unwrap();
        assert_eq!(read(&path).unwrap(), sightings);
    }

    #[test]
    fn columns_are_found_by_name() {
        let sightings = read_text("sigma,range,height,bearing_rad,t_s\n0.1,2,1.5,0.3,4\n").unwrap();
        assert_eq!(sightings, vec![Sighting { stamp: Stamp(4_000_000_000), bearing_rad: 0.3, range: 2.0, sigma: 0.1 }]);
    }

    #[test]
    fn a_sensor_that_saw_nothing_says_nothing() {
        assert_eq!(read_text("t_s,bearing_rad,range,sigma\n0,0,0.000,1\n0,0,2,1\n").unwrap().len(), 1);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let head = "t_s,bearing_rad,range,sigma\n0,0,1,1\n";
        let fails = |row: &str| read_text(&format!("{head}{row}\n")).unwrap_err();
        assert!(matches!(fails("1,NaN,1,1"), SightingsError::NotANumber { line: 3, column: "bearing_rad", .. }));
        assert!(matches!(fails("1,0,1"), SightingsError::NotANumber { line: 3, column: "sigma", .. }));
        assert!(matches!(fails("1,0,-1,1"), SightingsError::NotPositive { line: 3, column: "range", .. }));
        assert!(matches!(fails("1,0,1,0"), SightingsError::NotPositive { line: 3, column: "sigma", .. }));
        assert!(matches!(fails("-1,0,1,1"), SightingsError::StampsGoBack { line: 3, .. }));
        assert!(matches!(read_text("t,b\n"), Err(SightingsError::NoColumn { missing: "t_s" })));
        assert!(matches!(read_text(""), Err(SightingsError::Empty)));
        assert!(matches!(read_text(head.lines().next().unwrap()), Err(SightingsError::Empty)));
        assert!(matches!(read(Path::new("no such file")), Err(SightingsError::Io(_))));
    }
}

//! Where was the body, or the camera, and when? Trajectories in TUM, KITTI, EuRoC, CARMEN and CSV form.
//!
//! file (also .gz, .bz2) ─▶ format by content ─▶ timed poses ─▶ `odom ← body`, z up
//!
//! | format | a line | frame |
//! |---|---|---|
//! | TUM | `t x y z qx qy qz qw`, seconds | as said, else body |
//! | KITTI | 12 numbers, rows of `world ← camera`; times beside, else 10 Hz | camera |
//! | EuRoC | `ns, x, y, z, qw, qx, qy, qz, …` | as said, else body |
//! | CARMEN | `ODOM x y theta … t host t`, else the odometry in `FLASER` | body |
//! | CSV | columns by name: `t_s,x_m,y_m,yaw_rad` and their kin | as said, else body |
//! | a folder | `*.pose.txt`, a 4×4 matrix `world ← camera` each; times by rate, else 30 Hz | camera |
//!
//! Pitfall: w is last in TUM and first in EuRoC.

mod carmen;
mod detect;
mod folder;
mod frames;
mod rows;
pub(crate) mod scan;
mod table;

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

pub use rows::times_beside;

use planwalk_types::{Body, Odom, Rigid3, Stamp, Trajectory, TrajectoryError};

use crate::text;

/// A way of writing trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PosesFormat {
    /// `t x y z qx qy qz qw`.
    Tum,
    /// Twelve numbers a line.
    Kitti,
    /// Nanoseconds, position, w-first quaternion, by commas.
    Euroc,
    /// A robot's log.
    Carmen,
    /// A table with named columns.
    Csv,
    /// A folder with a 4×4 matrix a file.
    Matrices,
}

/// What a pose is the pose of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PosesFrame {
    /// x forward, y left, z up, in a world with z up.
    Body,
    /// x right, y down, z forward, in a world whose vertical axis is found from how the camera was held.
    Camera,
}

/// A name that is none of those that are known.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("\"{name}\" is not known: say {known}")]
pub struct UnknownName {
    /// What was given.
    pub name: String,
    /// What can be said.
    pub known: &'static str,
}

impl FromStr for PosesFormat {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name.to_ascii_lowercase().as_str() {
            "tum" => Ok(Self::Tum),
            "kitti" => Ok(Self::Kitti),
            "euroc" => Ok(Self::Euroc),
            "carmen" => Ok(Self::Carmen),
            "csv" => Ok(Self::Csv),
            "matrices" => Ok(Self::Matrices),
            _ => Err(UnknownName { name: name.to_owned(), known: "tum, kitti, euroc, carmen, csv or matrices" }),
        }
    }
}

impl FromStr for PosesFrame {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        match name.to_ascii_lowercase().as_str() {
            "body" => Ok(Self::Body),
            "camera" => Ok(Self::Camera),
            _ => Err(UnknownName { name: name.to_owned(), known: "body or camera" }),
        }
    }
}

/// Options of [`read`].
#[derive(Debug, Clone, Copy, Default)]
pub struct PosesOptions {
    /// How the file is written; `None` looks at its content.
    pub format: Option<PosesFormat>,
    /// What the poses are of; `None` is the format's own: camera for KITTI, else body.
    pub frame: Option<PosesFrame>,
    /// Poses per second of a folder of matrices.
    pub fps: Option<f64>,
}

/// A trajectory, and how it was read.
#[derive(Debug, Clone)]
pub struct PosesFile {
    /// The poses, `odom ← body`, z up.
    pub trajectory: Trajectory<Body>,
    /// How the file was written.
    pub format: PosesFormat,
    /// What its poses were of.
    pub frame: PosesFrame,
    /// Whether the file says where the body faced; else the direction of motion was taken.
    pub faces: bool,
    /// Whether the file's world was turned to bring z up: its x and y are then not those of the file.
    pub turned: bool,
    /// What was decided on the way, for people.
    pub notes: Vec<String>,
}

/// Why poses cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PosesError {
    /// The file system refuses.
    #[error("the poses cannot be read or written: {0}")]
    Io(#[from] std::io::Error),
    /// No data at all.
    #[error("the file holds no poses: it is empty, or comments only")]
    Empty,
    /// Not one of the formats.
    #[error(
        "the first data line (line {line}) is none of TUM, KITTI, EuRoC, CARMEN or a CSV with a header \
         (t_s,x_m,y_m,yaw_rad): {text:?}; if it is one, say which with --poses-format"
    )]
    UnknownFormat {
        /// Line, counted from 1.
        line: usize,
        /// How it begins.
        text: String,
    },
    /// A line with too few numbers, or too many.
    #[error("line {line} has {got} values, but {expected}")]
    Columns {
        /// Line, counted from 1.
        line: usize,
        /// How many there are.
        got: usize,
        /// What there should be.
        expected: &'static str,
    },
    /// No such column in a table's header.
    #[error("the table has no column for {what}: the header must name {names}")]
    NoColumn {
        /// What is missing.
        what: &'static str,
        /// Names that are understood.
        names: &'static str,
    },
    /// A value that is no number.
    #[error("line {line}: {what} is \"{value}\", not a finite number")]
    NotANumber {
        /// Line, counted from 1.
        line: usize,
        /// What should stand there.
        what: &'static str,
        /// What stands there.
        value: String,
    },
    /// A stamp that is no time.
    #[error("line {line}: \"{value}\" is no time in {unit}")]
    BadStamp {
        /// Line, counted from 1.
        line: usize,
        /// What stands there.
        value: String,
        /// What it should be in.
        unit: &'static str,
    },
    /// A quaternion or matrix that is no rotation.
    #[error("line {line}: the orientation is no rotation ({reason}); are the columns in the order that this format has?")]
    NotARotation {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Time runs backwards, or stands still.
    #[error("line {line}: stamps go back: {at_s:.6} s comes after {before_s:.6} s; sort the poses by time and drop repeated ones")]
    StampsGoBack {
        /// Line, counted from 1.
        line: usize,
        /// Its stamp.
        at_s: f64,
        /// The stamp before.
        before_s: f64,
    },
    /// Times that are not those of the poses.
    #[error("{times} times were given for {poses} poses: each pose needs one")]
    TimesMismatch {
        /// Times there are.
        times: usize,
        /// Poses there are.
        poses: usize,
    },
    /// The log that is to give the times cannot be read.
    #[error("the times are to come from another log, which cannot be read: {why} ({})", path.display())]
    Times {
        /// That log.
        path: PathBuf,
        /// What is wrong with it.
        why: Box<PosesError>,
    },
    /// A log whose clock does not run.
    #[error(
        "{dropped} of {total} lines have stamps that are repeated or go back: this log's clock is of no use; is there another version?"
    )]
    BadClock {
        /// Lines that would have to be dropped.
        dropped: usize,
        /// All lines.
        total: usize,
    },
    /// A corrected log of another drive.
    #[error(
        "{found} of {total} corrected scans are in the raw log in this order, at least half are needed to take its stamps: \
         are the two logs of the same drive?"
    )]
    OtherScans {
        /// Corrected scans that the raw log has.
        found: usize,
        /// All corrected scans.
        total: usize,
    },
    /// Read, but no trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// A pose as the file has it: its line, and the frame of the file's own choosing.
#[derive(Debug, Clone, Copy)]
struct RawPose {
    line: usize,
    stamp: Stamp,
    world_from_thing: Rigid3<Odom, Body>,
}

/// Reads a trajectory of any of the formats.
///
/// # Errors
/// [`PosesError`], with the line.
pub fn read(path: &Path, options: &PosesOptions) -> Result<PosesFile, PosesError> {
    read_timed(path, options, &rows::Times::beside(path))
}

/// As [`read`], but the times are in this file: of KITTI poses a time in seconds a line, as many as there are poses; of a robot's
/// corrected log the raw log in which the same scans stand: a
/// pose is then the laser's at the stamp of that scan. Other formats carry their own.
///
/// # Errors
/// [`PosesError`], with the line; [`PosesError::Times`], [`PosesError::TimesMismatch`], [`PosesError::OtherScans`].
pub fn read_with_times(path: &Path, options: &PosesOptions, times: &Path) -> Result<PosesFile, PosesError> {
    read_timed(path, options, &rows::Times::Given(times.to_owned()))
}

fn read_timed(path: &Path, options: &PosesOptions, times: &rows::Times) -> Result<PosesFile, PosesError> {
    let in_folder = path.is_dir();
    let text = if in_folder { String::new() } else { text::read(path)? };
    let format = match options.format {
        _ if in_folder => PosesFormat::Matrices,
        Some(format) => format,
        None => detect::format_of(&text)?,
    };
    let mut notes = Vec::new();
    let mut faces = true;
    let poses = match format {
        PosesFormat::Matrices => folder::read(path, options.fps, &mut notes)?,
        PosesFormat::Tum => rows::tum(&text, &mut notes)?,
        PosesFormat::Kitti => rows::kitti(&text, times, &mut notes)?,
        PosesFormat::Euroc => rows::euroc(&text)?,
        PosesFormat::Carmen => match times {
            rows::Times::Given(raw) => scan::at_raw_stamps(&text, raw, &mut notes)?,
            _ => carmen::read(&text, &mut notes)?,
        },
        PosesFormat::Csv => {
            let (poses, has_headings) = table::read(&text, &mut notes)?;
            faces = has_headings;
            poses
        }
    };
    if poses.is_empty() {
        return Err(PosesError::Empty);
    }
    for pair in poses.windows(2) {
        if pair[1].stamp <= pair[0].stamp {
            let (at_s, before_s) = (pair[1].stamp.as_secs(), pair[0].stamp.as_secs());
            return Err(PosesError::StampsGoBack { line: pair[1].line, at_s, before_s });
        }
    }
    let own = if matches!(format, PosesFormat::Kitti | PosesFormat::Matrices) { PosesFrame::Camera } else { PosesFrame::Body };
    let frame = options.frame.unwrap_or(own);
    let (poses, turned) = match frame {
        PosesFrame::Camera => frames::body_from_camera(&poses, &mut notes),
        PosesFrame::Body => {
            frames::note_if_not_upright(&poses, &mut notes);
            (poses.iter().map(|p| (p.stamp, p.world_from_thing)).collect(), false)
        }
    };
    Ok(PosesFile { trajectory: Trajectory::new(poses)?, format, frame, faces, turned, notes })
}

/// Writes poses in TUM form: `t x y z qx qy qz qw`, single spaces, nine decimals of time, none at the end of a line.
///
/// # Errors
/// [`PosesError::Io`].
pub fn write_tum<A, B>(path: &Path, poses: impl IntoIterator<Item = (Stamp, Rigid3<A, B>)>) -> Result<(), PosesError> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    for (stamp, pose) in poses {
        let (t, q) = (pose.iso.translation.vector, pose.iso.rotation);
        let time = text::decimal_seconds(stamp);
        writeln!(file, "{time} {:.9} {:.9} {:.9} {:.9} {:.9} {:.9} {:.9}", t.x, t.y, t.z, q.i, q.j, q.k, q.w)?;
    }
    Ok(file.flush()?)
}

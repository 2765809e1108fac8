//! Tables with named columns: a time, x and y, and a heading or a quaternion.
//!
//! Names are matched without regard to case, and with or without a unit (`t_s`, `time[s]`, `x_m`, `yaw_deg`). Lines above the
//! header are passed over. Without a heading, the direction of motion is taken.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Rigid3, Stamp};

use super::{PosesError, RawPose, rows};
use crate::text;

/// Lines that may stand above the header.
const TITLE_LINES: usize = 5;
/// Shortest way from which a direction of motion is taken, in the table's unit: below it lies the noise of clicking on a plan.
const DIRECTION_OVER: f64 = 0.05;

const TIME: [&str; 5] = ["t", "time", "timestamp", "stamp", "seconds"];
const X: [&str; 6] = ["x", "px", "tx", "pos_x", "position_x", "east"];
const Y: [&str; 6] = ["y", "py", "ty", "pos_y", "position_y", "north"];
const Z: [&str; 6] = ["z", "pz", "tz", "pos_z", "position_z", "up"];
const YAW: [&str; 5] = ["yaw", "theta", "heading", "phi", "psi"];
const QUATERNION: [[&str; 2]; 4] = [["qw", "q_w"], ["qx", "q_x"], ["qy", "q_y"], ["qz", "q_z"]];

/// Which column is what.
pub(super) struct Columns {
    time: usize,
    nanoseconds: bool,
    x: usize,
    y: usize,
    z: Option<usize>,
    yaw: Option<(usize, bool)>,
    quaternion: Option<[usize; 4]>,
}

/// Line of the header, and its columns: the first of the lines on top that names a time, x and y.
pub(super) fn find_header(text: &str) -> Option<(usize, Columns)> {
    // A header may be a comment.
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()).take(TITLE_LINES);
    lines.filter_map(|(line, row)| Some((line, Columns::of(row).ok()?))).next()
}

/// The name without its unit, and the unit.
fn split_unit(name: &str) -> (String, String) {
    let name = name.trim().trim_start_matches('#').trim().trim_matches('"').to_ascii_lowercase();
    let bare = name.trim_end_matches([']', ')']);
    if let Some((name, unit)) = bare.split_once(['[', '(']) {
        return (name.trim().to_owned(), unit.trim().to_owned());
    }
    match bare.rsplit_once('_') {
        Some((name, unit @ ("s" | "sec" | "ns" | "m" | "rad" | "deg"))) => (name.to_owned(), unit.to_owned()),
        _ => (bare.to_owned(), String::new()),
    }
}

impl Columns {
    fn of(header: &str) -> Result<Self, PosesError> {
        let names: Vec<(String, String)> = header.split([',', ';', '\t']).map(split_unit).collect();
        let find = |known: &[&str]| names.iter().position(|(name, _)| known.contains(&name.as_str()));
        let missing = |what, names| PosesError::NoColumn { what, names };
        let time = find(&TIME).ok_or(missing("the time", "t_s, time or timestamp"))?;
        let yaw = find(&YAW).map(|at| (at, names[at].1.starts_with("deg")));
        let [w, x, y, z] = QUATERNION.map(|known| find(&known));
        Ok(Self {
            time,
            nanoseconds: names[time].1 == "ns",
            x: find(&X).ok_or(missing("x", "x_m or x"))?,
            y: find(&Y).ok_or(missing("y", "y_m or y"))?,
            z: find(&Z),
            yaw,
            quaternion: w.zip(x).zip(y.zip(z)).map(|((w, x), (y, z))| [w, x, y, z]),
        })
    }
}

/// The poses, and whether the table says where they face.
pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<(Vec<RawPose>, bool), PosesError> {
    let Some((header, columns)) = find_header(text) else {
        // Says which column is missing in what should be the header.
        let first = text.lines().find(|line| !line.trim().is_empty()).ok_or(PosesError::Empty)?;
        return Err(Columns::of(first).err().unwrap_or(PosesError::Empty));
    };
    let mut poses = Vec::new();
    for (line, row) in text::data_lines(text).filter(|(line, _)| *line > header) {
        let cells: Vec<&str> = row.split([',', ';', '\t']).map(str::trim).collect();
        poses.push(pose(line, &cells, &columns)?);
    }
    let faces = columns.yaw.is_some() || columns.quaternion.is_some();
    if !faces {
        notes.push("the table has no heading: the direction of motion is taken, and the step forward with it".to_owned());
        face_the_motion(&mut poses);
    }
    Ok((poses, faces))
}

fn pose(line: usize, cells: &[&str], columns: &Columns) -> Result<RawPose, PosesError> {
    let number = |at: usize, what| rows::number(line, what, cells.get(at).copied().unwrap_or(""));
    let time = cells.get(columns.time).copied().unwrap_or("");
    let stamp = if columns.nanoseconds {
        time.parse().map(Stamp).map_err(|_| PosesError::BadStamp { line, value: time.to_owned(), unit: "whole nanoseconds" })?
    } else {
        rows::stamp_s(line, time)?
    };
    let z = columns.z.map_or(Ok(0.0), |at| number(at, "z"))?;
    let at = Vector3::new(number(columns.x, "x")?, number(columns.y, "y")?, z);
    let rotation = match (columns.quaternion, columns.yaw) {
        (Some([w, x, y, z]), _) => rows::quaternion(line, number(w, "qw")?, number(x, "qx")?, number(y, "qy")?, number(z, "qz")?)?,
        (None, Some((yaw, in_degrees))) => {
            let yaw = number(yaw, "the heading")?;
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), if in_degrees { yaw.to_radians() } else { yaw })
        }
        (None, None) => UnitQuaternion::identity(),
    };
    Ok(RawPose { line, stamp, world_from_thing: Rigid3::from_parts(at, rotation) })
}

/// Turns each pose to where the walk goes next; one that stands still at the end keeps the direction before it.
fn face_the_motion(poses: &mut [RawPose]) {
    let at: Vec<Vector3<f64>> = poses.iter().map(|p| p.world_from_thing.iso.translation.vector).collect();
    let mut heading = 0.0;
    let mut from = 0;
    let mut face = |range: std::ops::Range<usize>, heading: f64| {
        for i in range {
            poses[i].world_from_thing = Rigid3::from_parts(at[i], UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading));
        }
    };
    for i in 0..at.len() {
        let way = at[i] - at[from];
        if way.xy().norm() > DIRECTION_OVER {
            heading = way.y.atan2(way.x);
            face(from..i, heading);
            from = i;
        }
    }
    face(from..at.len(), heading);
}

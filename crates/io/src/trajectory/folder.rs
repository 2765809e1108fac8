//! One pose a file: a folder of `*.pose.txt`, each a 4×4 matrix `world ← camera` (7-Scenes, ScanNet).

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Rigid3, Stamp};

use super::{PosesError, RawPose, rows};
use crate::text;

/// What frames without any time are taken to be, and a note says so.
const ASSUMED_FPS: f64 = 30.0;

/// The poses in the order of their names, at `fps`.
pub(super) fn read(folder: &Path, fps: Option<f64>, notes: &mut Vec<String>) -> Result<Vec<RawPose>, PosesError> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let file = entry?.path();
        if file.file_name().is_some_and(|name| name.to_string_lossy().ends_with(".pose.txt")) {
            files.push(file);
        }
    }
    files.sort();
    if fps.is_none() {
        notes.push(format!("the poses carry no time: {ASSUMED_FPS} a second are assumed"));
    }
    let rate = fps.unwrap_or(ASSUMED_FPS);
    let pose = |(index, file): (usize, &std::path::PathBuf)| {
        let stamp = Stamp::from_secs(index as f64 / rate).ok_or(PosesError::BadStamp {
            line: index + 1,
            value: format!("{index} / {rate}"),
            unit: "seconds",
        })?;
        matrix(&text::read(file)?, index, stamp)
    };
    files.iter().enumerate().map(pose).collect()
}

/// A pose of sixteen numbers; `index` counts files, and stands for the line in messages.
fn matrix(text: &str, index: usize, stamp: Stamp) -> Result<RawPose, PosesError> {
    let line = index + 1;
    let tokens: Vec<&str> = text::data_lines(text).flat_map(|(_, row)| row.split_whitespace()).collect();
    if tokens.len() != 16 {
        return Err(PosesError::Columns { line, got: tokens.len(), expected: "a pose is a matrix of 16" });
    }
    let values: Vec<f64> = tokens.iter().map(|token| rows::number(line, "an element of the matrix", token)).collect::<Result<_, _>>()?;
    let at = |row: usize, column: usize| values[4 * row + column];
    let rotation = Matrix3::from_fn(at);
    let rotation = rows::rotation(line, &rotation)?;
    let world_from_thing = Rigid3::from_parts(Vector3::new(at(0, 3), at(1, 3), at(2, 3)), rotation);
    Ok(RawPose { line, stamp, world_from_thing })
}

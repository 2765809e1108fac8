//! What does a robot's map say? ROS `map.yaml` with its image, as `map_server` of ROS 1 and nav2 read it.
//!
//! Occupancy is 1 − shade (shade if `negate`); wall above `occupied_thresh`, free below `free_thresh`, both strictly, else
//! unknown. `origin` is the pose (x, y, yaw) of the lower-left corner.
//! Pitfalls: the saver writes unknown as 205, which is occupancy 0.196; with the common `free_thresh` of 0.25 it comes back as
//! free. In `trinary` mode alpha is averaged in like a colour. Many programs ignore yaw; it is not ignored here.

use std::path::Path;

use image::DynamicImage;
use planwalk_types::{Cell, FloorPlan, Plan, Pt2};
use serde_norway::Value;

use super::cells::Pixels;
use super::{PlanFile, PlanFileError};
use crate::raster::{self, SizeLimit};
use crate::text;

/// What the savers write for unknown.
const SAVED_UNKNOWN: u8 = 205;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Trinary,
    Scale,
    Raw,
}

struct Rule {
    mode: Mode,
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
}

pub(super) fn read(path: &Path, stated_scale: Option<f64>) -> Result<PlanFile, PlanFileError> {
    let value: Value = serde_norway::from_str(&text::read(path)?.replace('\t', "    "))?;
    let mut notes = Vec::new();
    let resolution = number(&value, "resolution").filter(|r| *r > 0.0);
    let resolution = resolution.ok_or(PlanFileError::BadKey { key: "resolution", expected: "a number of metres above zero" })?;
    let metres_per_pixel = stated_scale.unwrap_or(resolution);
    if metres_per_pixel != resolution {
        notes.push(format!("the map says {resolution} m per pixel; the given {metres_per_pixel} is used"));
    }
    let (corner, yaw_rad) = origin(&value)?;
    let rule = rule(&value)?;
    let name = value.get("image").and_then(Value::as_str).ok_or(PlanFileError::BadKey { key: "image", expected: "a file name" })?;
    let image_path = path.parent().unwrap_or(Path::new("")).join(name);
    let picture = raster::open(&image_path, SizeLimit::PLAN).map_err(|source| PlanFileError::MapImage { name: name.to_owned(), source })?;
    let pixels = classify(picture, &rule, &mut notes);
    let mut cells = pixels.coarsen(metres_per_pixel, &mut notes);
    let mut corner = corner;
    if yaw_rad != 0.0 {
        notes.push(format!("the map is turned by its origin's yaw of {:.2}°", yaw_rad.to_degrees()));
        (cells, corner) = cells.turned(corner, yaw_rad);
    }
    let plan = FloorPlan::new(corner, cells.cell_m, cells.width, cells.height, cells.cells)?;
    Ok(PlanFile { plan, notes })
}

fn number(value: &Value, key: &str) -> Option<f64> {
    value.get(key)?.as_f64().filter(|v| v.is_finite())
}

fn origin(value: &Value) -> Result<(Pt2<Plan>, f64), PlanFileError> {
    let list = value.get("origin").and_then(Value::as_sequence);
    let numbers: Option<Vec<f64>> = list.and_then(|list| list.iter().map(|v| v.as_f64().filter(|v| v.is_finite())).collect());
    match numbers.as_deref() {
        Some([x, y, yaw]) => Ok((Pt2::new(*x, *y), *yaw)),
        _ => Err(PlanFileError::BadKey { key: "origin", expected: "a list [x, y, yaw] of numbers" }),
    }
}

fn rule(value: &Value) -> Result<Rule, PlanFileError> {
    let negate = match value.get("negate") {
        None => false,
        Some(v) => match (v.as_bool(), v.as_f64()) {
            (Some(yes), _) => yes,
            (_, Some(n)) => n != 0.0,
            _ => return Err(PlanFileError::BadKey { key: "negate", expected: "0, 1, true or false" }),
        },
    };
    let mode = match value.get("mode").map(|v| v.as_str()) {
        None | Some(Some("trinary")) => Mode::Trinary,
        Some(Some("scale")) => Mode::Scale,
        Some(Some("raw")) => Mode::Raw,
        Some(_) => return Err(PlanFileError::BadKey { key: "mode", expected: "trinary, scale or raw" }),
    };
    let threshold = |key: &'static str| {
        let expected = "a number between 0 and 1";
        number(value, key).filter(|t| (0.0..=1.0).contains(t)).ok_or(PlanFileError::BadKey { key, expected })
    };
    Ok(Rule { mode, negate, occupied_thresh: threshold("occupied_thresh")?, free_thresh: threshold("free_thresh")? })
}

impl Rule {
    /// What a pixel of this shade (0 black, 255 white) is.
    fn cell(&self, shade: f64, opaque: bool) -> Cell {
        let occupancy = match self.mode {
            // Transparent means unknown in this mode only.
            Mode::Scale if !opaque => return Cell::Unknown,
            // The value itself is the percentage.
            Mode::Raw if shade.round() > 100.0 => return Cell::Unknown,
            Mode::Raw => shade.round() / 100.0,
            Mode::Trinary | Mode::Scale if self.negate => shade / 255.0,
            Mode::Trinary | Mode::Scale => 1.0 - shade / 255.0,
        };
        if occupancy > self.occupied_thresh {
            Cell::Wall
        } else if occupancy < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}

fn classify(picture: DynamicImage, rule: &Rule, notes: &mut Vec<String>) -> Pixels {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let cells: Vec<Cell> = match picture {
        DynamicImage::ImageLuma8(grey) => {
            let table: [Cell; 256] = std::array::from_fn(|shade| rule.cell(shade as f64, true));
            note_saved_unknown(grey.as_raw(), rule, notes);
            grey.as_raw().iter().map(|shade| table[usize::from(*shade)]).collect()
        }
        other => {
            let has_alpha = other.color().has_alpha();
            other.into_rgba8().pixels().map(|p| rgba_cell(p.0, has_alpha, rule)).collect()
        }
    };
    Pixels { width, height, cells }
}

fn rgba_cell([r, g, b, a]: [u8; 4], has_alpha: bool, rule: &Rule) -> Cell {
    let sum = f64::from(r) + f64::from(g) + f64::from(b);
    let shade = if has_alpha && rule.mode == Mode::Trinary { (sum + f64::from(a)) / 4.0 } else { sum / 3.0 };
    rule.cell(shade, a == 255)
}

fn note_saved_unknown(shades: &[u8], rule: &Rule, notes: &mut Vec<String>) {
    let read_as_free = rule.mode != Mode::Raw && rule.cell(f64::from(SAVED_UNKNOWN), true) == Cell::Free;
    let count = shades.iter().filter(|shade| **shade == SAVED_UNKNOWN).count();
    if read_as_free && count > 0 {
        notes.push(format!(
            "{count} pixels of shade {SAVED_UNKNOWN}, which map savers write for unknown, are read as free because free_thresh is {}: \
             set it to 0.196 to keep them unknown",
            rule.free_thresh
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(mode: Mode, negate: bool) -> Rule {
        Rule { mode, negate, occupied_thresh: 0.65, free_thresh: 0.196 }
    }

    #[test]
    fn thresholds_are_strict() {
        let at = Rule { occupied_thresh: 0.6, free_thresh: 0.2, ..rule(Mode::Trinary, true) };
        assert_eq!(at.cell(0.6 * 255.0, true), Cell::Unknown);
        assert_eq!(at.cell(0.2 * 255.0, true), Cell::Unknown);
        assert_eq!(at.cell(0.6 * 255.0 + 1e-6, true), Cell::Wall);
        assert_eq!(at.cell(0.2 * 255.0 - 1e-6, true), Cell::Free);
    }

    #[test]
    fn the_savers_three_shades_come_back_as_three_kinds() {
        let trinary = rule(Mode::Trinary, false);
        assert_eq!([0.0, 205.0, 254.0].map(|s| trinary.cell(s, true)), [Cell::Wall, Cell::Unknown, Cell::Free]);
        let negated = rule(Mode::Trinary, true);
        assert_eq!([255.0, 0.0].map(|s| negated.cell(s, true)), [Cell::Wall, Cell::Free]);
    }

    #[test]
    fn raw_values_are_percentages_and_255_is_unknown() {
        let raw = rule(Mode::Raw, true);
        assert_eq!([0.0, 50.0, 100.0, 255.0].map(|s| raw.cell(s, true)), [Cell::Free, Cell::Unknown, Cell::Wall, Cell::Unknown]);
    }

    #[test]
    fn alpha_counts_as_a_colour_in_trinary_and_as_unknown_in_scale() {
        // Opaque black: (0 + 0 + 0 + 255) / 4 is a quarter of white, occupancy 0.75.
        assert_eq!(rgba_cell([0, 0, 0, 255], true, &rule(Mode::Trinary, false)), Cell::Wall);
        assert_eq!(rgba_cell([100, 100, 100, 0], true, &rule(Mode::Trinary, false)), Cell::Wall);
        assert_eq!(rgba_cell([100, 100, 100, 0], true, &rule(Mode::Scale, false)), Cell::Unknown);
        assert_eq!(rgba_cell([0, 0, 0, 255], true, &rule(Mode::Scale, false)), Cell::Wall);
    }
}

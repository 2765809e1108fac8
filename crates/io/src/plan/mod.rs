//! Where are the walls? A floor plan from a picture, or from a ROS `map.yaml` with its picture.
//!
//! file ─▶ pixels: wall, free or unknown ─▶ cells of at least 5 cm, row 0 at the bottom ─▶ [`FloorPlan`]
//!
//! Plan frame: metres, x right, y up; the origin is the picture's bottom-left corner, or what the `map.yaml` says.
//! Pitfall: pictures have row 0 at the top.

mod cells;
mod drawing;
mod measure;
mod ros;
mod write;

use std::path::Path;

use planwalk_types::{FloorPlan, PlanError, Pt2};

use crate::raster::{self, RasterError, SizeLimit};

pub use measure::{Measure, MeasureError};
pub use write::{ros_map_image, ros_map_yaml};

/// Options of [`read`].
#[derive(Debug, Clone, Copy, Default)]
pub struct PlanOptions {
    /// Metres in one pixel of the picture. A `map.yaml` has its own; this one goes before it.
    pub metres_per_pixel: Option<f64>,
    /// A known length in the picture, instead of [`PlanOptions::metres_per_pixel`].
    pub measure: Option<Measure>,
}

/// A plan, and what a user should know about how it was read.
#[derive(Debug, Clone)]
pub struct PlanFile {
    /// The plan.
    pub plan: FloorPlan,
    /// What was decided on the way, for people.
    pub notes: Vec<String>,
}

/// Why a plan cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// The file system refuses.
    #[error("the plan cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The picture cannot be read.
    #[error("the plan's picture: {0}")]
    Raster(#[from] RasterError),
    /// The picture that a `map.yaml` names cannot be read.
    #[error("the map's image {name}: {source}")]
    MapImage {
        /// Its name in the `map.yaml`.
        name: String,
        /// Why.
        source: RasterError,
    },
    /// A picture alone says nothing of metres.
    #[error(
        "the plan has no scale: give --metres-per-pixel M, or the length of something in the picture: \
         --measure u1,v1,u2,v2=3.6m (two points in pixels from the top left corner)"
    )]
    NoScale,
    /// Two scales.
    #[error("--metres-per-pixel and --measure both give the scale: leave one of them away")]
    TwoScales,
    /// A scale that is none.
    #[error("{metres_per_pixel} m per pixel is no scale: it must be above 0 and at most 10 m")]
    BadScale {
        /// What was given or follows.
        metres_per_pixel: f64,
    },
    /// Not YAML.
    #[error("the map file is not YAML: {0}")]
    Yaml(#[from] serde_norway::Error),
    /// A key of a `map.yaml` is not there, or is not what it should be.
    #[error("the map file's \"{key}\" is missing or is not {expected}")]
    BadKey {
        /// The key.
        key: &'static str,
        /// What is expected there.
        expected: &'static str,
    },
    /// Read, but no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Reads a plan: a picture (PNG, JPEG, PGM, BMP, TIFF, WebP), or a ROS `map.yaml`.
///
/// # Errors
/// [`PlanFileError`], with the remedy.
pub fn read(path: &Path, options: &PlanOptions) -> Result<PlanFile, PlanFileError> {
    let scale = stated_scale(options)?;
    let is_yaml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("yaml") || e.eq_ignore_ascii_case("yml"));
    if is_yaml {
        return ros::read(path, scale);
    }
    std::fs::metadata(path)?;
    let metres_per_pixel = scale.ok_or(PlanFileError::NoScale)?;
    let picture = raster::open(path, SizeLimit::PLAN)?;
    let (pixels, mut notes) = drawing::classify(picture, metres_per_pixel);
    let cells = pixels.coarsen(metres_per_pixel, &mut notes);
    let plan = FloorPlan::new(Pt2::new(0.0, 0.0), cells.cell_m, cells.width, cells.height, cells.cells)?;
    Ok(PlanFile { plan, notes })
}

fn stated_scale(options: &PlanOptions) -> Result<Option<f64>, PlanFileError> {
    let scale = match (options.metres_per_pixel, options.measure) {
        (Some(_), Some(_)) => return Err(PlanFileError::TwoScales),
        (Some(scale), None) => Some(scale),
        (None, Some(measure)) => Some(measure.metres_per_pixel()),
        (None, None) => None,
    };
    match scale {
        Some(metres_per_pixel) if !(metres_per_pixel > 0.0 && metres_per_pixel <= 10.0) => {
            Err(PlanFileError::BadScale { metres_per_pixel })
        }
        scale => Ok(scale),
    }
}

//! Where are the walls? A floor plan from a picture, a ROS `map.yaml` with its picture, GeoJSON, or a list of walls.
//!
//! picture, map.yaml ─▶ pixels: wall, free or unknown ─┐
//!                                                     ├─▶ cells of at least 5 cm, row 0 at the bottom ─▶ [`FloorPlan`]
//! GeoJSON, wall list ─▶ shapes: wall, door, window, floor ─┘
//!
//! Plan frame: metres, x right, y up; the origin is the picture's bottom-left corner, or what the `map.yaml` says, or that of the
//! shapes' own metres. Doors and windows are known to shapes only.
//! Pitfall: pictures have row 0 at the top.

mod cells;
mod drawing;
mod geojson;
mod kind;
mod measure;
mod projection;
mod ros;
mod vector;
mod wall_list;
mod write;

use std::io::Read;
use std::path::Path;

use planwalk_types::{FloorPlan, PlanError, Pt2};

use crate::raster::{self, RasterError, SizeLimit};
use crate::text;

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
    /// A vector plan, which has metres of its own.
    #[error("this plan is drawn in metres already: leave --metres-per-pixel and --measure away")]
    ScaleNotNeeded,
    /// Neither a feature collection nor anything else of GeoJSON.
    #[error("the plan begins like JSON, but is no GeoJSON: {why}; export it as a FeatureCollection of walls, doors and rooms")]
    GeoJson {
        /// What its reader says.
        why: String,
    },
    /// GeoJSON in which nothing is drawn that could be a wall or a floor.
    #[error(
        "none of the {features} features is a wall, door, window or room: say what they are in a property \"type\" \
         (or category, feature_type, indoor, class); found {found}"
    )]
    NothingKnown {
        /// Features there are.
        features: usize,
        /// Words found in those properties.
        found: String,
    },
    /// A site that is no floor, or a point far off.
    #[error(
        "the shapes span {width_m:.0} m × {height_m:.0} m, over the 3 square kilometres that a floor may have: is a point astray \
         (the farthest is {x}, {y}), or are the coordinates not in metres?"
    )]
    TooWide {
        /// From the leftmost to the rightmost point.
        width_m: f64,
        /// From the lowest to the highest.
        height_m: f64,
        /// The point farthest from the origin.
        x: f64,
        /// Its other coordinate.
        y: f64,
    },
    /// More to draw than any floor has.
    #[error("the shapes have more than {limit} crossings with the grid's rows: simplify them, e.g. to 1 cm")]
    TooIntricate {
        /// Most that are drawn.
        limit: u64,
    },
    /// A row of a list of walls.
    #[error("line {line}: {why}; a wall is x0,y0,x1,y1 in metres, and wall, door or window if you like")]
    BadWall {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong with it.
        why: String,
    },
    /// Read, but no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Reads a plan: a picture (PNG, JPEG, PGM, BMP, TIFF, WebP), a ROS `map.yaml`, GeoJSON, or a list of walls
/// (`x0,y0,x1,y1[,kind]`). The latter two may be packed by gzip or bzip2, and are known by their content.
///
/// # Errors
/// [`PlanFileError`], with the remedy.
pub fn read(path: &Path, options: &PlanOptions) -> Result<PlanFile, PlanFileError> {
    let scale = stated_scale(options)?;
    let is_yaml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("yaml") || e.eq_ignore_ascii_case("yml"));
    if is_yaml {
        return ros::read(path, scale);
    }
    if let Some(text) = vector_text(path)? {
        if scale.is_some() {
            return Err(PlanFileError::ScaleNotNeeded);
        }
        return if text.trim_start().starts_with('{') { geojson::read(&text) } else { wall_list::read(&text) };
    }
    let metres_per_pixel = scale.ok_or(PlanFileError::NoScale)?;
    let picture = raster::open(path, SizeLimit::PLAN)?;
    let (pixels, mut notes) = drawing::classify(picture, metres_per_pixel);
    let cells = pixels.coarsen(metres_per_pixel, &mut notes);
    let plan = FloorPlan::new(Pt2::new(0.0, 0.0), cells.cell_m, cells.width, cells.height, cells.cells)?;
    Ok(PlanFile { plan, notes })
}

/// Bytes looked at to tell text from pictures.
const LOOKED_AT: u64 = 4096;

/// The text of a plan that is drawn in shapes; `None` for pictures.
fn vector_text(path: &Path) -> Result<Option<String>, PlanFileError> {
    let mut head = Vec::new();
    std::fs::File::open(path)?.take(LOOKED_AT).read_to_end(&mut head)?;
    let packed = head.starts_with(&[0x1f, 0x8b]) || head.starts_with(b"BZh");
    let head = String::from_utf8_lossy(&head);
    let head = head.trim_start_matches('\u{feff}').trim_start();
    if packed || head.starts_with('{') || wall_list::is_one(head) { Ok(Some(text::read(path)?)) } else { Ok(None) }
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

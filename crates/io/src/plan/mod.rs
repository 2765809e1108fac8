//! Where are the walls? A floor plan from a picture, a robot's map, a drawing, a map of the world or a list of walls.
//!
//! picture, ROS map.yaml ─▶ pixels: wall, free or unknown ────────────────┐
//! SVG, PDF, DXF ─▶ `sketch` ─▶ `interpret` ─┐                            ├─▶ cells of at least 5 cm ─▶ [`FloorPlan`]
//! GeoJSON, IMDF, OpenStreetMap, wall list, ─┴─▶ [`Building`]: storeys ───┘
//! `*.plan.json`                                 of elements
//!
//! Plan frame: metres, x right, y up; the origin is the picture's bottom-left corner, or what the `map.yaml` says, or that of the
//! shapes' own metres. Doors are known to shapes, and to pictures where they are drawn open or in colour; windows to shapes only.
//! Pitfall: pictures have row 0 at the top.

mod astray;
pub mod audit;
mod bounds;
mod cells;
mod drafter;
mod drawing;
mod dxf;
pub mod export;
mod geojson;
pub mod georeference;
mod imdf;
mod interpret;
mod kind;
mod measure;
mod mercator;
pub mod native;
mod notation;
mod open;
mod osm;
mod outline;
mod pdf;
mod projection;
mod provenance;
mod ros;
mod scale;
mod scan;
mod sketch;
mod storeys;
mod svg;
mod vector;
mod wall_list;

use std::path::Path;

use planwalk_types::{Building, FloorPlan, Level, PlanError, Pt2};

use crate::raster::RasterError;

use audit::Audit;
pub use export::{ros_map_image, ros_map_yaml};
pub use measure::{Measure, MeasureError};
use native::{PlanDocument, Source};
use open::Opened;
pub use provenance::provenance;

/// Options of [`read`].
#[derive(Debug, Clone, Default)]
pub struct PlanOptions {
    /// Metres in one pixel of the picture, or in one unit of the drawing. A `map.yaml` and a DXF have their own; this one goes before
    /// it.
    pub metres_per_pixel: Option<f64>,
    /// Known lengths in the picture, instead of [`PlanOptions::metres_per_pixel`]. Two that disagree are told in a note.
    pub measures: Vec<Measure>,
    /// Name or ordinal of the storey, where the file has several. Without it the ground floor, or the lowest above it.
    pub level: Option<String>,
    /// Page of a PDF, from 1. Without it the first on which something is drawn.
    pub page: Option<usize>,
    /// What one metre on paper stands for, of a drawing that is to scale: 100 for 1:100.
    pub drawing_scale: Option<f64>,
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
    #[error("--metres-per-pixel, --measure and --drawing-scale each give the scale: keep one of them")]
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
    #[error("this plan is drawn in metres already: leave --metres-per-pixel, --measure and --drawing-scale away")]
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
        "the shapes span {width_m:.0} m × {height_m:.0} m, over the {limit_km2:.0} square kilometres that a floor (3) or a map of roads (51) may \
         have: is a point astray (the farthest is {x}, {y}), or are the coordinates not in metres?"
    )]
    TooWide {
        /// From the leftmost to the rightmost point.
        width_m: f64,
        /// From the lowest to the highest.
        height_m: f64,
        /// Most that there may be, square kilometres.
        limit_km2: f64,
        /// The point farthest from the middle of the others.
        x: f64,
        /// Its other coordinate.
        y: f64,
    },
    /// Shapes that cannot be one building.
    #[error(
        "the shapes span {width_km:.0} km × {height_km:.0} km, and no site is wider than 100 km: the farthest from all the rest is {what}, at \
         ({x}, {y}); take it out if it is astray, or save the coordinates in metres if they are none"
    )]
    Astray {
        /// From the leftmost to the rightmost point.
        width_km: f64,
        /// From the lowest to the highest.
        height_km: f64,
        /// What lies farthest from the middle of the others.
        what: String,
        /// Its point there.
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
    /// A text that no reader knows.
    #[error(
        "the file is a text that begins \"{begins}\", and no plan that is known: a list of walls is x0,y0,x1,y1 a line, in metres; other \
         texts that are read are SVG, DXF, GeoJSON, OpenStreetMap XML, a robot's map.yaml (by this ending) and .plan.json"
    )]
    UnknownText {
        /// Its first words.
        begins: String,
    },
    /// A list of something else than walls.
    #[error(
        "{points} of the {rows} rows begin and end at one place: this is no list of walls but of places, perhaps of a walk; a wall is x0,y0,x1,y1, \
         two ends"
    )]
    NoLengths {
        /// Rows whose ends are one.
        points: usize,
        /// All rows.
        rows: usize,
    },
    /// Read, but no plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A zip archive that is no venue.
    #[error("the archive is no IMDF venue: {why}; an IMDF archive holds a GeoJSON file for each type of feature")]
    Archive {
        /// What is wrong with it.
        why: String,
    },
    /// A drawing on paper without its scale.
    #[error(
        "the drawing has no scale, and neither areas in its rooms nor doors tell it: give --drawing-scale 100 for 1:100, or \
         --metres-per-pixel M for one unit of it, or the length of something: --measure u1,v1,u2,v2=3.6m (two points in its units)"
    )]
    NoDrawingScale,
    /// A scale on paper of what was never on paper.
    #[error(
        "--drawing-scale is for what is drawn on paper, PDF and SVG: say metres with --metres-per-pixel or --measure, if they are missing"
    )]
    NotOnPaper,
    /// A page of what has none.
    #[error("--page {page} is for PDFs: this plan has no pages, leave it away")]
    NoPages {
        /// Page that was asked for.
        page: usize,
    },
    /// A drawing's scale that is none.
    #[error("a drawing of 1:{scale} is no floor plan: give a number from 1 to 100000, such as 100 for 1:100")]
    BadDrawingScale {
        /// What was given.
        scale: f64,
    },
    /// A unit that makes the drawing a doll's house, or a country.
    #[error(
        "by the file's own unit of {metres_per_unit} m the drawing is {width_m:.2} m × {height_m:.2} m, which is no building: say what \
         one unit is with --metres-per-pixel M, or measure something: --measure x1,y1,x2,y2=3.6m (two points in its units)"
    )]
    ImplausibleUnit {
        /// What the file says.
        metres_per_unit: f64,
        /// Width that follows.
        width_m: f64,
        /// Height that follows.
        height_m: f64,
    },
    /// A file that is no plan by its size.
    #[error("the file is over {limit_mb} MB, more than any plan: is it the right one?")]
    FileTooLarge {
        /// Most that is read, megabytes.
        limit_mb: u64,
    },
    /// No storey of this name.
    #[error("there is no storey \"{wish}\" in this plan: it has {levels}")]
    NoSuchLevel {
        /// What was asked for.
        wish: String,
        /// What there is.
        levels: String,
    },
    /// An OpenStreetMap file that breaks off, or is none.
    #[error("the OpenStreetMap file is broken at line {line}, column {column}: {why}; download or save it again")]
    Osm {
        /// Line, counted from 1.
        line: usize,
        /// Byte in the line, counted from 1.
        column: usize,
        /// What is wrong there.
        why: String,
    },
    /// An OpenStreetMap file of a country.
    #[error("the OpenStreetMap file has more than {limit} {what}: cut the building out of it, e.g. by JOSM or osmium extract")]
    OsmTooLarge {
        /// What there is too much of.
        what: &'static str,
        /// Most that is read.
        limit: usize,
    },
    /// An OpenStreetMap file without rooms and roads.
    #[error(
        "neither rooms (indoor=room, area, corridor or wall) nor roads (highway=*) are drawn in the OpenStreetMap file: it has \
         {found}; download the place again with all of its nodes, or draw the rooms by Simple Indoor Tagging, e.g. in JOSM"
    )]
    OsmNothingDrawn {
        /// What there is instead.
        found: String,
    },
    /// A plan file of Planwalk's own that is damaged or badly written.
    #[error("the plan file is not as docs/plan-format.md says: {why}")]
    Native {
        /// What is wrong with it.
        why: String,
    },
    /// A plan file of another version.
    #[error("the plan file's schema is \"{found}\", and this program reads \"{read}\": export it again for that, or use a newer Planwalk")]
    OtherSchema {
        /// What it says.
        found: String,
        /// What is read.
        read: &'static str,
    },
    /// An element of a plan file that is none.
    #[error("element {element} (counted from 0) of the storey \"{level}\": {why}")]
    BadElement {
        /// Name of its storey.
        level: String,
        /// Its place in the storey's list, counted from 0.
        element: usize,
        /// What is wrong with it.
        why: String,
    },
    /// A picture in which the borders of dark areas turn at every pixel.
    #[error(
        "the outlines of the picture's walls have more than {limit} corners: is it a photograph, or are its greys dots? Smooth it \
         first (e.g. magick IN -blur 0x2 -threshold 50% OUT.png)"
    )]
    TooRagged {
        /// Most corners that are followed.
        limit: usize,
    },
    /// A picture of coloured lines: a plan in colour, or no plan.
    #[error(
        "the picture's lines are coloured ({coloured} px of them, and {walls} px of dark walls): walls are read where they are dark; if \
         the coloured lines are its walls, save it in black and white first (e.g. magick IN -threshold 70% OUT.png); a view in \
         perspective is no floor plan"
    )]
    ColouredLines {
        /// Pixels of coloured lines.
        coloured: usize,
        /// Pixels of dark walls.
        walls: usize,
    },
    /// A drawing in the format that CAD programmes keep to themselves.
    #[error(
        "this is a DWG drawing ({version}), which only CAD programmes can read: save it as DXF with the one it comes from, \
         with LibreCAD, or with the free ODA File Converter"
    )]
    Dwg {
        /// Its release, e.g. AC1027.
        version: String,
    },
    /// A DXF drawing of which nothing is left.
    #[error("the DXF drawing cannot be used: {why}; save it once more as DXF (2000 or later) with a CAD programme")]
    Dxf {
        /// What is wrong with it.
        why: String,
    },
    /// More than a floor's drawing has.
    #[error("the drawing has more than {limit} {what}: save only what belongs to this floor, without its hatches and furniture")]
    DrawingTooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How many are read.
        limit: usize,
    },
    /// A vector drawing with more points than any floor has.
    #[error("the drawing has more than {limit} points: leave furniture, hatches and texts drawn as curves away, or simplify it")]
    DrawingTooIntricate {
        /// Most that are read.
        limit: usize,
    },
    /// A vector drawing on which nothing is to be seen.
    #[error("nothing is drawn in the {format}: {why}")]
    NothingDrawn {
        /// SVG or PDF.
        format: &'static str,
        /// What there is instead, and what to do.
        why: String,
    },
    /// No SVG, or a damaged one.
    #[error("the SVG cannot be read: {why}")]
    Svg {
        /// What is wrong, and what to do.
        why: String,
    },
    /// No PDF, or a damaged, locked or overlarge one.
    #[error("the PDF cannot be read: {why}")]
    Pdf {
        /// What is wrong, and what to do.
        why: String,
    },
    /// A page that is not there.
    #[error("the PDF has no page {page}: it has {pages}, counted from 1")]
    NoPage {
        /// Page that was asked for.
        page: usize,
        /// Pages there are.
        pages: usize,
    },
}

/// Reads one storey of a plan of any format as cells.
///
/// # Errors
/// [`PlanFileError`], with the remedy.
pub fn read(path: &Path, options: &PlanOptions) -> Result<PlanFile, PlanFileError> {
    let mut notes = Vec::new();
    let plan = cells(&open::open(path, options, &mut notes)?.0, options, &mut notes)?;
    Ok(PlanFile { plan, notes })
}

/// Reads a plan as [`read`] does and as [`import`] does, at once.
///
/// # Errors
/// As [`read`].
pub fn survey(path: &Path, options: &PlanOptions) -> Result<(PlanFile, PlanDocument), PlanFileError> {
    let mut notes = Vec::new();
    let (opened, source) = open::open(path, options, &mut notes)?;
    let mut shape_notes = notes.clone();
    let plan = cells(&opened, options, &mut notes)?;
    let document = document(opened, source, options, &mut shape_notes)?;
    Ok((PlanFile { plan, notes }, PlanDocument { notes: shape_notes, ..document }))
}

fn cells(opened: &Opened, options: &PlanOptions, notes: &mut Vec<String>) -> Result<FloorPlan, PlanFileError> {
    Ok(match opened {
        Opened::Map(plan) => plan.clone(),
        Opened::Picture { pixels, metres_per_pixel } => {
            let cells = pixels.coarsen(*metres_per_pixel, notes);
            FloorPlan::new(Pt2::new(0.0, 0.0), cells.cell_m, cells.width, cells.height, cells.cells)?
        }
        Opened::Drawn(building) => storey(building, options, notes)?,
        Opened::Kept(document) => {
            notes.extend(document.building.georeference.as_ref().map(georeference::words));
            storey(&document.building, options, notes)?
        }
    })
}

/// Reads all storeys of a plan of any format as shapes, or that of [`PlanOptions::level`], to be kept ([`native::write`]) or handed on ([`export`]).
///
/// # Errors
/// As [`read`].
pub fn import(path: &Path, options: &PlanOptions) -> Result<PlanDocument, PlanFileError> {
    let mut notes = Vec::new();
    let (opened, source) = open::open(path, options, &mut notes)?;
    let document = document(opened, source, options, &mut notes)?;
    Ok(PlanDocument { notes, ..document })
}

fn document(opened: Opened, source: Source, options: &PlanOptions, notes: &mut Vec<String>) -> Result<PlanDocument, PlanFileError> {
    let placed = if let Opened::Kept(document) = &opened { document.placed.clone() } else { None };
    let mut building = open::building(opened, notes)?;
    if options.level.is_some() {
        building.levels = vec![storeys::choose(&building, options.level.as_deref(), notes)?.clone()];
    }
    Ok(PlanDocument { building, source, placed, notes: Vec::new() })
}

/// Adds the rooms that are found between the walls of each storey, and names from the texts in them; gives what was found on each
/// storey, in their order. A storey that cannot be looked at (empty, all wall, or too intricate) stays as it is, with a note.
pub fn complete(document: &mut PlanDocument) -> Vec<Audit> {
    let PlanDocument { building, notes, .. } = document;
    let look = |level: &mut Level| {
        let audit = Audit::of(level).unwrap_or_else(|why| {
            notes.push(format!("storey {}: rooms are not looked for, nor mistakes: {why}", level.name));
            Audit::default()
        });
        audit.complete(level);
        audit
    };
    building.levels.iter_mut().map(look).collect()
}

/// The storey that is meant: the one that is asked for, or the ground floor; with a note for people where there are others.
///
/// # Errors
/// [`PlanFileError::NoSuchLevel`].
pub fn level<'a>(building: &'a Building, options: &PlanOptions, notes: &mut Vec<String>) -> Result<&'a Level, PlanFileError> {
    storeys::choose(building, options.level.as_deref(), notes)
}

fn storey(building: &Building, options: &PlanOptions, notes: &mut Vec<String>) -> Result<FloorPlan, PlanFileError> {
    let level = level(building, options, notes)?;
    vector::draw(&level.elements, notes)
}

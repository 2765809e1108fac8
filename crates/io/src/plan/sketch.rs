//! What is on a drawing, before anybody knows which of its lines are walls? Paths and texts with their looks.
//!
//! SVG, PDF, DXF ─▶ [`Sketch`] ─▶ walls, doors, windows, rooms
//!
//! Coordinates are the drawing's own unit, x right, y **up**: readers turn what has y down over.

/// A point in the drawing's unit.
pub(super) type SketchPoint = [f64; 2];

/// A drawing as its file has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sketch {
    /// What is drawn, in the file's order (later ones lie on top). Curves are already chains of short chords.
    pub paths: Vec<SketchPath>,
    /// Rings that are in the file without fill and line: rooms, as a rule, that one may click on.
    pub hidden: Vec<SketchPath>,
    /// What is written.
    pub texts: Vec<SketchText>,
    /// Metres in one unit, where the file says so.
    pub metres_per_unit: Option<f64>,
    /// Of a drawing that this program exported: plan coordinates of the origin, metres. Its layers are kinds of elements.
    pub exported_from: Option<[f64; 2]>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// One chain of points, or one ring.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SketchPath {
    /// At least two points; a ring does not repeat its first.
    pub points: Vec<SketchPoint>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
    /// Colour that its inside is filled with, if it is; paths filled together (an outline with its holes) share [`SketchPath::group`].
    pub fill: Option<[u8; 3]>,
    /// Colour of its line, if it has one.
    pub stroke: Option<[u8; 3]>,
    /// Width of the line, drawing units; 0 is a hairline.
    pub width: f64,
    /// Whether the line is dashed or dotted: hidden edges, centre lines, projections.
    pub dashed: bool,
    /// Whether it was a curve (an arc, a circle, a Bézier) before it became chords.
    pub curved: bool,
    /// Which object of the file it was part of; paths of one number were drawn by one command.
    pub group: usize,
    /// Layer, group id, class or block names, joined by "/": what the file calls it. May be empty.
    pub layer: String,
}

/// A piece of text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SketchText {
    /// Left end of its base line.
    pub at: SketchPoint,
    /// Height of a capital letter, drawing units; 0 where unknown.
    pub height: f64,
    /// The words.
    pub text: String,
    /// As of paths.
    pub layer: String,
}

//! Which of a drawing's lines are walls? Those on layers that say so; where none does, those that look like walls.
//!
//! [`Sketch`] ─▶ pens: layer, colour, width ─▶ pens that draw walls ─▶ filled shapes, pairs of lines, single lines ─▶ elements
//!                                          └▶ swings of doors, flights of stairs
//!
//! Walls are told from the rest as people do it: they are long, straight, run in few directions, reach over the whole drawing, and
//! are filled or drawn with the broadest pen. None of these is sure by itself; [`pens::choose`] weighs them together.
//! Metres must be known before: what is as thick as a wall and as wide as a door depends on them.

mod double_lines;
mod frame;
pub(super) mod nearby;
mod openings;
mod pens;
mod specks;
mod stairs;
pub(super) mod swings;

use std::collections::BTreeSet;

use planwalk_types::{Element, ElementKind, Form, Plan, Pt2};

use super::PlanFileError;
use super::bounds::Bounds;
use super::kind::Meaning;
use super::sketch::{Sketch, SketchPath, SketchPoint};
use pens::Pen;
use swings::Swing;

/// Most points that are looked at: a drawing of a whole airport has a tenth of it.
const POINTS_MOST: usize = 2_000_000;
/// What is filled is a wall up to this thickness, metres: twice its area over its outline, so that square columns have half their side.
const THICKEST_M: f64 = 0.7;
/// Colours from here on, of 255, are paper: what is filled with them hides, and is nothing itself.
const PAPER: u8 = 245;

/// A straight piece of a line, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub from: SketchPoint,
    pub to: SketchPoint,
}

impl Piece {
    fn way(&self) -> SketchPoint {
        [self.to[0] - self.from[0], self.to[1] - self.from[1]]
    }

    pub(super) fn length(&self) -> f64 {
        let [x, y] = self.way();
        x.hypot(y)
    }

    /// Unit vector along it.
    fn direction(&self) -> SketchPoint {
        let ([x, y], length) = (self.way(), self.length().max(f64::MIN_POSITIVE));
        [x / length, y / length]
    }

    /// Where a point is as seen from its beginning: along it, and to its left.
    fn seen_from(&self, point: SketchPoint) -> SketchPoint {
        let ([x, y], [c, s]) = ([point[0] - self.from[0], point[1] - self.from[1]], self.direction());
        [c * x + s * y, c * y - s * x]
    }

    /// The point that is so far along it, and so far to its left.
    fn point_at(&self, along: f64, left: f64) -> SketchPoint {
        let [c, s] = self.direction();
        [self.from[0] + c * along - s * left, self.from[1] + s * along + c * left]
    }

    fn distance_to(&self, at: SketchPoint) -> f64 {
        let [along, left] = self.seen_from(at);
        (along - along.clamp(0.0, self.length())).hypot(left)
    }

    fn form(&self) -> Form {
        Form::Line(vec![point(self.from), point(self.to)])
    }
}

/// The box around some pieces.
fn around<'a>(pieces: impl IntoIterator<Item = &'a Piece>) -> Option<Bounds> {
    let ends: Vec<SketchPoint> = pieces.into_iter().flat_map(|piece| [piece.from, piece.to]).collect();
    Bounds::of(&ends)
}

fn point(at: SketchPoint) -> Pt2<Plan> {
    Pt2::new(at[0], at[1])
}

/// A drawing's paths in metres, with what can be said of each by itself.
struct Drawn<'a> {
    path: &'a SketchPath,
    points: Vec<SketchPoint>,
    /// Its place in the drawing's order.
    number: usize,
}

impl Drawn<'_> {
    /// Its straight pieces; none shorter than a millimetre.
    fn pieces(&self) -> impl Iterator<Item = Piece> + '_ {
        let count = self.points.len();
        let ends = if self.path.closed { count } else { count.saturating_sub(1) };
        (0..ends).map(move |i| Piece { from: self.points[i], to: self.points[(i + 1) % count] }).filter(|piece| piece.length() > 1e-3)
    }

    /// Area by the shoelace formula, signed, m².
    fn area_m2(&self) -> f64 {
        let pairs = self.points.iter().zip(self.points.iter().cycle().skip(1));
        0.5 * pairs.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
    }

    fn length_m(&self) -> f64 {
        self.pieces().map(|piece| piece.length()).sum()
    }

    /// Whether something lies inside of it that is not paper.
    fn is_filled(&self) -> bool {
        self.path.fill.is_some_and(|fill| fill.iter().any(|v| *v < PAPER))
    }
}

/// Paths of one group that are filled: an outline and its holes.
fn shapes<'a, 'b>(paths: &'b [&'b Drawn<'a>]) -> Vec<&'b [&'b Drawn<'a>]> {
    paths.chunk_by(|a, b| a.path.group == b.path.group && a.is_filled() == b.is_filled()).collect()
}

/// Twice the area over the outline, metres: the thickness of what is long.
fn thickness_m(shape: &[&Drawn<'_>]) -> f64 {
    let mut areas: Vec<f64> = shape.iter().map(|ring| ring.area_m2().abs()).collect();
    areas.sort_by(f64::total_cmp);
    // The largest ring is the outline, the others are holes in it.
    let area = areas.pop().unwrap_or(0.0) - areas.iter().sum::<f64>();
    let outline: f64 = shape.iter().map(|ring| ring.length_m()).sum();
    2.0 * area.max(0.0) / outline.max(f64::MIN_POSITIVE)
}

/// What a drawing of this program's own shows: each layer is a kind, and what is on it has its name behind the layer's. `origin` is
/// where the drawing's own is on the plan.
pub(super) fn exported(sketch: &Sketch, metres_per_unit: f64, origin: SketchPoint) -> Vec<Element> {
    let metric = |at: &SketchPoint| Pt2::new(origin[0] + metres_per_unit * at[0], origin[1] + metres_per_unit * at[1]);
    let chain = |path: &SketchPath| -> Vec<Pt2<Plan>> { path.points.iter().map(metric).collect() };
    let objects = sketch.paths.chunk_by(|a, b| a.group == b.group);
    objects
        .filter_map(|paths| {
            let mut words = paths[0].layer.split('/');
            let word = words.next()?;
            let kind = ElementKind::ALL.into_iter().find(|kind| kind.word() == word)?;
            let form = if paths.iter().all(|path| path.closed) {
                Form::Area(paths.iter().map(chain).collect())
            } else {
                Form::Line(chain(&paths[0]))
            };
            Some(Element { name: words.next().map(str::to_owned), ..Element::new(kind, form) })
        })
        .collect()
}

/// What a drawing shows, metres.
pub(super) fn elements(sketch: &Sketch, metres_per_unit: f64, notes: &mut Vec<String>) -> Result<Vec<Element>, PlanFileError> {
    let count: usize = sketch.paths.iter().map(|path| path.points.len()).sum();
    if count > POINTS_MOST {
        return Err(PlanFileError::DrawingTooIntricate { limit: POINTS_MOST });
    }
    let metric = |path: &SketchPath| path.points.iter().map(|at| at.map(|v| v * metres_per_unit)).collect();
    let drawn: Vec<Drawn<'_>> =
        sketch.paths.iter().enumerate().map(|(number, path)| Drawn { path, points: metric(path), number }).collect();
    let drawn = frame::without(&drawn, notes);
    let pens = pens::sort(&drawn);
    let swings = swings::on(&drawn);
    let mut found = Vec::new();
    let walls = pens::choose(&pens, notes);
    for pen in &walls {
        draw_walls(pen, &swings, &mut found)?;
    }
    let by_layer = |kinds: &'static [ElementKind]| {
        pens.iter().filter_map(move |pen| match pen.meaning {
            Some(Meaning::Part(kind)) if kinds.contains(&kind) => Some((pen, kind)),
            _ => None,
        })
    };
    for (pen, kind) in by_layer(&[ElementKind::Window, ElementKind::Stairs, ElementKind::Lift, ElementKind::Room, ElementKind::Floor]) {
        found.extend(pen.paths.iter().filter_map(|path| as_drawn(kind, path)));
    }
    for (pen, kind) in by_layer(&[ElementKind::Door]) {
        // Leaves stand open as a rule: what is drawn as a line says where a leaf is, not where the door is.
        found.extend(pen.paths.iter().filter(|path| path.path.closed && !path.path.curved).filter_map(|path| as_drawn(kind, path)));
    }
    let doors = swings::doors(&swings, &found)?;
    notes.push(format!("{} doors are known by the arcs in which they swing, of {} such arcs", doors.len(), swings.len()));
    found.extend(doors);
    let of_walls: BTreeSet<usize> = walls.iter().flat_map(|pen| &pen.paths).map(|path| path.number).collect();
    let openings = openings::find(&drawn, |path| of_walls.contains(&path.number), &found, notes)?;
    found.extend(openings);
    Ok(found)
}

/// Walls of a pen: filled shapes as they are, lines as they are, and what lies between two lines that are one wall.
fn draw_walls(pen: &Pen<'_>, swings: &[Swing], found: &mut Vec<Element>) -> Result<(), PlanFileError> {
    let source = |shape: &[&Drawn<'_>]| shape.first().map(|ring| ring.path.layer.clone()).filter(|layer| !layer.is_empty());
    let mut lines: Vec<Piece> = Vec::new();
    for shape in shapes(&pen.paths) {
        let is_wall = shape[0].is_filled() && shape.iter().all(|ring| ring.path.closed) && thickness_m(shape) <= THICKEST_M;
        if is_wall {
            let rings = shape.iter().map(|ring| ring.points.iter().copied().map(point).collect()).collect();
            found.push(Element { source: source(shape), ..Element::new(ElementKind::Wall, Form::Area(rings)) });
        } else if shape[0].path.stroke.is_some() {
            // An arc of a door is none of a wall.
            lines.extend(shape.iter().filter(|ring| Swing::of(ring).is_none()).flat_map(|ring| ring.pieces()));
        }
    }
    let (flights, lines) = stairs::take(swings::without_leaves(lines, swings)?);
    let lines = specks::without(lines)?;
    found.extend(flights);
    found.extend(double_lines::between(&lines)?.into_iter().map(|form| Element::new(ElementKind::Wall, form)));
    found.extend(lines.iter().map(|piece| Element::new(ElementKind::Wall, piece.form())));
    Ok(())
}

/// What a layer says, where it is drawn. Ground is an area, or nothing.
fn as_drawn(kind: ElementKind, path: &Drawn<'_>) -> Option<Element> {
    let mut points: Vec<Pt2<Plan>> = path.points.iter().copied().map(point).collect();
    let form = if path.path.closed && (kind.is_ground() || path.is_filled() || kind == ElementKind::Door) {
        Form::Area(vec![points])
    } else if kind.is_ground() {
        return None;
    } else {
        points.extend(path.path.closed.then(|| points.first().copied()).flatten());
        Form::Line(points)
    };
    Some(Element { source: Some(path.path.layer.clone()), ..Element::new(kind, form) })
}

#[cfg(test)]
mod tests;

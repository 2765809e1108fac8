//! Which pens drew walls? A pen is what lines have in common: layer, colour, width.

use std::collections::BTreeMap;

use planwalk_types::ElementKind;

use super::super::bounds::Bounds;
use super::super::kind::{self, Meaning};
use super::{Drawn, Piece, THICKEST_M, around, shapes, thickness_m};

/// Walls are made of pieces that are at least this long, metres; text and furniture are not.
const LONG_M: f64 = 0.5;
/// A layer's name tells pens apart where so many paths bear it; an id that each path has for itself does not.
const SHARED_BY: usize = 3;
/// Layers are believed when what they call walls is this long, metres: a room's outline.
const BELIEVED_M: f64 = 8.0;
/// Directions are counted in steps of one degree, of a quarter turn.
const DIRECTIONS: usize = 90;
/// A direction is one of the building's when it has this share of the whole length.
const MAIN_SHARE: f64 = 0.05;
/// Other pens than the best draw walls too from this share of its score on, if they are like it …
const GOOD_SHARE: f64 = 0.3;
/// … and from this one on if they have another layer and another colour: routes and axes are long and straight too.
const UNLIKE_SHARE: f64 = 0.6;
/// What is filled is a piece of wall, and no column, if its outline is this many times its thickness: it is four times as long as thick.
const SLENDER: f64 = 12.0;
/// Pens that draw around the same things begin and end this near to each other, metres.
const SAME_M: f64 = 0.1;
/// What is filled and thin looks like a wall, more than any line does.
const FILLED_COUNTS: f64 = 3.0;

/// What one pen drew.
pub(super) struct Pen<'a> {
    /// What its layer says.
    pub meaning: Option<Meaning>,
    /// In the order in which they were drawn.
    pub paths: Vec<&'a Drawn<'a>>,
    width: f64,
    dashed: bool,
    name: String,
}

/// Sorts paths by pen, in the order of their looks.
pub(super) fn sort<'a>(drawn: &[&'a Drawn<'a>]) -> Vec<Pen<'a>> {
    let mut shared: BTreeMap<&str, usize> = BTreeMap::new();
    for part in drawn.iter().flat_map(|path| path.path.layer.split('/')) {
        *shared.entry(part).or_default() += 1;
    }
    let layer_of = |layer: &str| {
        let parts: Vec<&str> = layer.split('/').filter(|part| shared.get(part).is_some_and(|count| *count >= SHARED_BY)).collect();
        parts.join("/")
    };
    let mut pens: BTreeMap<_, Pen<'a>> = BTreeMap::new();
    for path in drawn {
        let p = path.path;
        let (layer, thousandth) = (layer_of(&p.layer), (1000.0 * p.width).round().clamp(0.0, 1e9) as u64);
        let meaning = p.layer.split('/').rev().find_map(kind::of);
        let look = (layer.clone(), p.stroke, p.fill, thousandth, p.dashed, meaning);
        let pen = pens.entry(look).or_insert_with(|| Pen { meaning, paths: Vec::new(), width: p.width, dashed: p.dashed, name: layer });
        pen.paths.push(path);
    }
    pens.into_values().collect()
}

impl Pen<'_> {
    fn straight(&self) -> impl Iterator<Item = Piece> + '_ {
        self.paths.iter().filter(|path| !path.path.curved).flat_map(|path| path.pieces())
    }

    fn is_solid(&self) -> bool {
        let thin = |shape: &&[&Drawn<'_>]| shape[0].is_filled() && thickness_m(shape) <= THICKEST_M;
        let all = shapes(&self.paths);
        2 * all.iter().filter(|shape| thin(shape)).count() > all.len()
    }

    /// Whether layer or colour are the same, or both fill what they draw.
    fn is_like(&self, other: &Self) -> bool {
        let colour = |pen: &Self| pen.paths.first().and_then(|path| path.path.stroke);
        self.name == other.name || colour(self) == colour(other) || self.is_solid() && other.is_solid()
    }

    /// Whether it drew, by bare lines, what lies below or above the walls, such as a roof's edge, where walls are drawn so broad.
    fn is_below(&self, cut: f64) -> bool {
        !self.is_solid() && 2.0 * self.width < cut
    }

    /// Outlines of pieces of wall that are filled, metres.
    fn slender_m(&self) -> f64 {
        let length = |shape: &[&Drawn<'_>]| shape.iter().map(|ring| ring.length_m()).sum::<f64>();
        let is_slender = |shape: &&[&Drawn<'_>]| shape[0].is_filled() && length(shape) >= SLENDER * thickness_m(shape);
        shapes(&self.paths).into_iter().filter(is_slender).map(length).sum()
    }

    /// The box around what it drew straight.
    fn bounds(&self) -> Option<Bounds> {
        around(&self.straight().collect::<Vec<_>>())
    }

    fn says(&self, wanted: ElementKind) -> bool {
        self.meaning == Some(Meaning::Part(wanted))
    }

    /// Metres of long straight pieces along the building's directions, less where they do not reach over the drawing.
    fn score(&self, of: &Whole) -> f64 {
        if self.dashed || self.meaning.is_some() && !self.says(ElementKind::Wall) {
            return 0.0;
        }
        let long: Vec<Piece> = self.straight().filter(|piece| piece.length() >= LONG_M).collect();
        let along: f64 = long.iter().filter(|piece| of.main[direction(piece)]).map(Piece::length).sum();
        let reach = area_m2(&long) / of.area_m2.max(f64::MIN_POSITIVE);
        along * reach.clamp(0.0, 1.0) * if self.is_solid() { FILLED_COUNTS } else { 1.0 }
    }
}

/// The pens that drew walls; with a note of how they were known.
pub(super) fn choose<'a, 'b>(pens: &'b [Pen<'a>], notes: &mut Vec<String>) -> Vec<&'b Pen<'a>> {
    let by_layer: Vec<&Pen<'a>> = pens.iter().filter(|pen| pen.says(ElementKind::Wall)).collect();
    let length: f64 = by_layer.iter().flat_map(|pen| pen.straight()).map(|piece| piece.length()).sum();
    if length >= BELIEVED_M {
        notes.push(format!("walls are what layers call so: {length:.0} m of lines"));
        return by_layer;
    }
    let whole = Whole::of(pens);
    let cut = width_of_cuts(pens);
    let scores: Vec<f64> = pens.iter().map(|pen| if pen.is_below(cut) { 0.0 } else { pen.score(&whole) }).collect();
    let Some((best, most)) = pens.iter().zip(&scores).max_by(|a, b| a.1.total_cmp(b.1)) else { return Vec::new() };
    let good = |(pen, score): &(&'b Pen<'a>, &f64)| {
        let share = if pen.is_like(best) { GOOD_SHARE } else { UNLIKE_SHARE };
        **score > 0.0 && **score >= share * most && (pen.is_solid() || 2.0 * pen.width >= best.width)
    };
    let chosen: Vec<&Pen<'a>> = pens.iter().zip(&scores).filter(good).map(|(pen, _)| pen).collect();
    let names: Vec<String> = chosen.iter().map(|pen| format!("\"{}\" of width {:.2}", pen.name, pen.width)).collect();
    notes.push(format!(
        "no layer says what is a wall: of {} pens those are taken that draw long straight lines all over the drawing: {}",
        pens.len(),
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    ));
    chosen
}

/// How broad the pen is that goes around walls which are filled: what is cut is drawn so. 0 where nothing tells it.
fn width_of_cuts(pens: &[Pen<'_>]) -> f64 {
    let cut: Vec<Bounds> =
        pens.iter().filter(|pen| pen.is_solid() && pen.slender_m() >= BELIEVED_M).filter_map(|pen| pen.bounds()).collect();
    let is_same = |a: &Bounds, b: &Bounds| {
        let near = |a: [f64; 2], b: [f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() <= SAME_M);
        near(a.low, b.low) && near(a.high, b.high)
    };
    let goes_around = |pen: &&Pen<'_>| !cut.is_empty() && pen.bounds().is_some_and(|bounds| cut.iter().any(|cut| is_same(cut, &bounds)));
    pens.iter().filter(goes_around).map(|pen| pen.width).fold(0.0, f64::max)
}

/// Degrees modulo a quarter turn, rounded.
fn direction(piece: &Piece) -> usize {
    let [x, y] = piece.way();
    (y.atan2(x).to_degrees().rem_euclid(90.0).round() as usize) % DIRECTIONS
}

/// Of the box around them.
fn area_m2(pieces: &[Piece]) -> f64 {
    around(pieces).map_or(0.0, Bounds::area)
}

/// What all pens drew.
struct Whole {
    area_m2: f64,
    /// Which directions are the building's.
    main: [bool; DIRECTIONS],
}

impl Whole {
    fn of(pens: &[Pen<'_>]) -> Self {
        let long: Vec<Piece> = pens.iter().flat_map(|pen| pen.straight()).filter(|piece| piece.length() >= LONG_M).collect();
        let mut metres = [0.0; DIRECTIONS];
        for piece in &long {
            metres[direction(piece)] += piece.length();
        }
        let all: f64 = metres.iter().sum();
        // A degree to either side belongs to it.
        let near = |k: usize| metres[k] + metres[(k + 1) % DIRECTIONS] + metres[(k + DIRECTIONS - 1) % DIRECTIONS];
        Self { area_m2: area_m2(&long), main: std::array::from_fn(|k| near(k) >= MAIN_SHARE * all) }
    }
}

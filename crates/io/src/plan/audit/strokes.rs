//! Which strokes of walls cannot be meant? Those shorter than walls are thick that end freely, and those drawn twice.

use std::collections::BTreeMap;

use planwalk_types::{ElementKind, Form, Level, Plan, Pt2};

use super::finding::Finding;
use super::scale::wall_m;

/// Walls are so thick where they are drawn as lines, metres: a partition.
const PARTITION_M: f64 = 0.1;
/// Ends nearer than this meet, metres.
const MEET_M: f64 = 0.05;
/// Strokes nearer than this are one, metres.
const SAME_M: f64 = 0.01;
/// What is drawn twice for less than this is a corner, metres.
const SHORTEST_TWICE_M: f64 = 0.3;
/// Parallel: sine of 1°.
const PARALLEL: f64 = 0.0175;
/// Strokes are looked up by squares of this side, metres.
const SQUARE_M: f64 = 2.0;
/// Most strokes, and most entries of them in squares, that are compared: a site of a square kilometre. Of more, none are.
const MOST: usize = 2_000_000;
/// More strokes in a square are a hatching, which is looked at by nobody.
const MOST_IN_SQUARE: usize = 2000;
/// Most squares that a stroke is entered in.
const MOST_SQUARES: usize = 4096;

/// A straight piece of a wall that is drawn as a line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stroke {
    from: Pt2<Plan>,
    to: Pt2<Plan>,
    /// Which element it is part of.
    of: usize,
}

impl Stroke {
    fn length_m(&self) -> f64 {
        self.from.distance(self.to)
    }

    /// Along it and to its left, metres.
    fn seen_from(&self, at: Pt2<Plan>) -> (f64, f64) {
        let length = self.length_m().max(f64::MIN_POSITIVE);
        let (c, s) = ((self.to.x - self.from.x) / length, (self.to.y - self.from.y) / length);
        let (x, y) = (at.x - self.from.x, at.y - self.from.y);
        (c * x + s * y, c * y - s * x)
    }

    fn distance(&self, at: Pt2<Plan>) -> f64 {
        let (along, left) = self.seen_from(at);
        (along - along.clamp(0.0, self.length_m())).hypot(left)
    }

    /// Middle and length of what another stroke repeats of it.
    fn repeated_by(&self, other: &Self) -> Option<(Pt2<Plan>, f64)> {
        let (a, b) = (self.seen_from(other.from), self.seen_from(other.to));
        let is_same = a.1.abs() < SAME_M && b.1.abs() < SAME_M && (a.1 - b.1).abs() <= PARALLEL * other.length_m();
        let (low, high) = (a.0.min(b.0).max(0.0), a.0.max(b.0).min(self.length_m()));
        let share = 0.5 * (low + high) / self.length_m().max(f64::MIN_POSITIVE);
        let at = Pt2::new(self.from.x + share * (self.to.x - self.from.x), self.from.y + share * (self.to.y - self.from.y));
        (is_same && high - low >= SHORTEST_TWICE_M).then_some((at, high - low))
    }
}

/// Strokes of walls, and where to find them.
struct Strokes {
    all: Vec<Stroke>,
    squares: BTreeMap<(i64, i64), Vec<usize>>,
}

impl Strokes {
    /// All straight pieces of walls drawn as lines; or of everything that a wall may end at.
    fn of(level: &Level, is_all: bool) -> Self {
        let mut all = Vec::new();
        for (of, element) in level.elements.iter().enumerate().filter(|(_, e)| !e.kind.is_ground()) {
            let closed = matches!(element.form, Form::Area(_));
            if !is_all && (closed || element.kind != ElementKind::Wall) {
                continue;
            }
            for chain in element.form.chains() {
                let ends = chain.iter().zip(chain.iter().cycle().skip(1)).take(chain.len().saturating_sub(usize::from(!closed)));
                all.extend(ends.filter(|(a, b)| a != b).map(|(a, b)| Stroke { from: *a, to: *b, of }));
            }
            if all.len() > MOST {
                return Self::none();
            }
        }
        let mut squares: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
        let mut entries = 0;
        for (n, stroke) in all.iter().enumerate() {
            for square in along(stroke) {
                let list = squares.entry(square).or_default();
                if list.last() != Some(&n) {
                    list.push(n);
                    entries += 1;
                }
            }
            if entries > MOST {
                return Self::none();
            }
        }
        Self { all, squares }
    }

    fn none() -> Self {
        Self { all: Vec::new(), squares: BTreeMap::new() }
    }

    /// Strokes that may be within [`MEET_M`] of a point.
    fn near(&self, at: Pt2<Plan>) -> impl Iterator<Item = &Stroke> {
        let steps = [-MEET_M, MEET_M];
        let mut squares: Vec<_> = steps.iter().flat_map(|dx| steps.map(|dy| square(Pt2::new(at.x + dx, at.y + dy)))).collect();
        squares.sort_unstable();
        squares.dedup();
        squares.into_iter().filter_map(|square| self.squares.get(&square)).flatten().map(|n| &self.all[*n])
    }
}

fn square(at: Pt2<Plan>) -> (i64, i64) {
    ((at.x / SQUARE_M).floor() as i64, (at.y / SQUARE_M).floor() as i64)
}

/// The squares that a stroke passes, in its order; each point of it is within half a step of one that is asked.
fn along(stroke: &Stroke) -> impl Iterator<Item = (i64, i64)> + use<> {
    let stroke = *stroke;
    let count = ((4.0 * stroke.length_m() / SQUARE_M).ceil() as usize).clamp(1, MOST_SQUARES);
    (0..=count).map(move |i| {
        let t = i as f64 / count as f64;
        square(Pt2::new(stroke.from.x + t * (stroke.to.x - stroke.from.x), stroke.from.y + t * (stroke.to.y - stroke.from.y)))
    })
}

/// Walls drawn as lines that are shorter than walls are thick, and that no wall, window or door meets at one end at least.
pub(super) fn short(level: &Level) -> Vec<Finding> {
    let thickness_m = wall_m(level).unwrap_or(PARTITION_M);
    let strokes = Strokes::of(level, true);
    let is_free = |at: Pt2<Plan>, of: usize| !strokes.near(at).any(|stroke| stroke.of != of && stroke.distance(at) <= MEET_M);
    let mut findings = Vec::new();
    for (of, element) in level.elements.iter().enumerate().filter(|(_, e)| e.kind == ElementKind::Wall) {
        let Form::Line(line) = &element.form else { continue };
        let (Some(first), Some(last)) = (line.first(), line.last()) else { continue };
        let length_m: f64 = line.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        if length_m < thickness_m && !strokes.all.is_empty() && (is_free(*first, of) || is_free(*last, of)) {
            let at = Pt2::new(0.5 * (first.x + last.x), 0.5 * (first.y + last.y));
            findings.push(Finding::ShortWall { at, length_m, thickness_m });
        }
    }
    findings
}

/// Walls drawn as lines that lie on each other. Areas that abut share their borders, and are no mistake; neither is the outline of an area
/// drawn as a line besides.
pub(super) fn doubled(level: &Level) -> Vec<Finding> {
    let strokes = Strokes::of(level, false);
    let mut found: BTreeMap<(usize, usize), (Pt2<Plan>, f64)> = BTreeMap::new();
    for list in strokes.squares.values().filter(|list| list.len() <= MOST_IN_SQUARE) {
        for (n, a) in list.iter().enumerate() {
            for b in &list[n + 1..] {
                let (first, second) = (&strokes.all[*a], &strokes.all[*b]);
                if first.of != second.of
                    && !found.contains_key(&(*a, *b))
                    && let Some(repeated) = first.repeated_by(second)
                {
                    found.insert((*a, *b), repeated);
                }
            }
        }
    }
    found.into_values().map(|(at, length_m)| Finding::DoubledWall { at, length_m }).collect()
}

//! Where can one pass or look through a wall? At its gaps: where lines span them are windows or thresholds, else ways through.
//!
//! walls ─▶ faces ─┬─ lines from one wall's end to another's ─▶ side by side: glass ─▶ windows; else doors
//!                 ├─ paper laid over a wall ─▶ the same                    (`paper`)
//!                 └─ ends that look at each other, and nothing between ─▶ doors (`gaps`)
//!
//! Arcs are read before (`swings`): where a leaf swings is a door, whatever lies on its threshold.

mod gaps;
mod paper;

use std::collections::HashMap;

use planwalk_types::{Element, ElementKind, Form, Groups};

use super::super::PlanFileError;
use super::nearby::Nearby;
use super::{Drawn, Piece, SketchPoint, point};

/// A line spans a gap if it is this long, metres: from a hatch in a door to a shop's front.
const SPAN_M: std::ops::RangeInclusive<f64> = 0.4..=6.0;
/// It ends this near to a wall, or to the next line that goes on, metres: glass is drawn inside its frame, or into the wall.
const TOUCH_M: f64 = 0.1;
/// What ends this near to a wall's corner runs along its face, metres; glass is further in.
const AT_CORNER_M: f64 = 0.03;
/// A wall's end is as wide as the wall is thick, metres.
const END_M: std::ops::RangeInclusive<f64> = 0.04..=0.8;
/// Square to each other or parallel is what is this near to it, as a sine: 6°.
const ASLANT: f64 = 0.1;
/// No wall is nearer to the middle of a gap, metres: a sill or a radiator before a wall spans no gap.
const CLEAR_M: f64 = 0.3;
/// Lines are of one window if they are this near to each other, metres, across and at their ends.
const TOGETHER_M: [f64; 2] = [0.7, 0.25];
/// Ways through are no wider than this, metres.
const WIDEST_DOOR_M: f64 = 2.5;
/// A single line may be a threshold or glass: across a gap up to this wide it is a threshold, metres.
const WIDEST_THRESHOLD_M: f64 = 1.3;
/// Openings with middles this near to each other are one, metres.
const SAME_GAP_M: f64 = 0.5;
/// No opening is thinner as an area, metres.
const THIN_M: f64 = 0.02;

/// The sides of all walls, to be asked what is near.
pub(super) struct Faces {
    /// Sides of areas, and lines.
    pieces: Vec<Piece>,
    nearby: Nearby,
}

impl Faces {
    /// Of the walls among these.
    pub(super) fn of(found: &[Element]) -> Self {
        let walls = found.iter().filter(|element| element.kind == ElementKind::Wall);
        let pieces: Vec<Piece> = walls.flat_map(|wall| sides(&wall.form)).collect();
        let nearby = Nearby::of(pieces.iter().enumerate());
        Self { pieces, nearby }
    }

    fn around(&self, at: SketchPoint) -> impl Iterator<Item = &Piece> {
        self.nearby.to_point(at).into_iter().filter_map(|i| self.pieces.get(i))
    }

    /// Metres to the nearest; infinite where none is within a metre or two.
    fn distance(&self, at: SketchPoint) -> f64 {
        self.around(at).map(|piece| piece.distance_to(at)).fold(f64::INFINITY, f64::min)
    }

    /// How a line ends here, that goes on in this direction.
    fn end(&self, at: SketchPoint, onward: SketchPoint) -> Option<End> {
        let mut end = None;
        for piece in self.around(at).filter(|piece| piece.length() > 1e-3 && piece.distance_to(at) <= TOUCH_M) {
            let [c, s] = piece.direction();
            let along = c * onward[0] + s * onward[1];
            let corner = distance(at, piece.from).min(distance(at, piece.to));
            let goes_on =
                [piece.from, piece.to].iter().any(|far| (far[0] - at[0]) * onward[0] + (far[1] - at[1]) * onward[1] > 2.0 * TOUCH_M);
            let kind = if along.abs() <= 3.0 * ASLANT && END_M.contains(&piece.length()) {
                End::OfWall { inner: corner > AT_CORNER_M }
            } else if along.abs() >= 1.0 - ASLANT && corner <= TOUCH_M && goes_on {
                End::OfWall { inner: false }
            } else if along.abs() <= 3.0 * ASLANT {
                End::OnFace
            } else {
                continue;
            };
            end = end.max(Some(kind));
        }
        end
    }
}

/// Sides of an area, pieces of a line.
fn sides(form: &Form) -> Vec<Piece> {
    let closed = matches!(form, Form::Area(_));
    let of = |chain: &[planwalk_types::Pt2<planwalk_types::Plan>]| -> Vec<Piece> {
        let ends = chain.iter().zip(chain.iter().skip(1).chain(chain.first().filter(|_| closed)));
        ends.map(|(from, to)| Piece { from: [from.x, from.y], to: [to.x, to.y] }).collect()
    };
    form.chains().flat_map(of).collect()
}

/// What a line meets at its end, the better witness of a gap the greater.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    /// The long side of a wall: steps and partitions end like this at both ends.
    OnFace,
    /// A wall that ends here and goes on behind.
    OfWall {
        /// Between its two faces, where glass is.
        inner: bool,
    },
}

/// A line across a gap.
struct Span {
    piece: Piece,
    /// Whether it, or the panes in line with it, ends between the faces of a wall.
    inner: bool,
}

impl Span {
    /// Whether the other spans the same gap.
    fn is_beside(&self, other: &Self) -> bool {
        let ends = [other.piece.from, other.piece.to].map(|at| self.piece.seen_from(at));
        let [across, along] = TOGETHER_M;
        let beside = ends.iter().all(|end| end[1].abs() <= across) && (ends[0][1] - ends[1][1]).abs() <= along;
        let (low, high) = (ends[0][0].min(ends[1][0]), ends[0][0].max(ends[1][0]));
        beside && low.abs() <= along && (high - self.piece.length()).abs() <= along
    }
}

/// Lines from one end of a wall to another, or to the long side of one; panes may follow each other on the way.
fn spans(lines: &[Piece], faces: &Faces) -> Result<Vec<Span>, PlanFileError> {
    let long: Vec<Piece> = lines.iter().filter(|piece| SPAN_M.contains(&piece.length())).copied().collect();
    let ends: Vec<[Option<End>; 2]> = long
        .iter()
        .map(|piece| {
            let [c, s] = piece.direction();
            [faces.end(piece.from, [-c, -s]), faces.end(piece.to, [c, s])]
        })
        .collect();
    let chains = chains(&long, &ends)?;
    let mut held: Vec<Vec<End>> = vec![Vec::new(); long.len()];
    for (chain, of_piece) in chains.iter().zip(&ends) {
        held[*chain].extend(of_piece.iter().flatten());
    }
    let is_span = |i: &usize| {
        let (piece, held) = (&long[*i], &held[chains[*i]]);
        let clear = CLEAR_M.min(0.45 * piece.length());
        let is_held = held.len() >= 2 && held.iter().any(|end| *end != End::OnFace);
        is_held && faces.distance(piece.point_at(0.5 * piece.length(), 0.0)) > clear
    };
    let span = |i: usize| Span { piece: long[i], inner: held[chains[i]].contains(&End::OfWall { inner: true }) };
    let found = (0..long.len()).filter(is_span).map(span).collect();
    faces.nearby.check()?;
    Ok(found)
}

/// For each line the number of its chain, that of its first: lines follow each other where one ends at no wall, and the next goes on
/// from there in its direction.
fn chains(lines: &[Piece], ends: &[[Option<End>; 2]]) -> Result<Vec<usize>, PlanFileError> {
    let spots: Vec<(usize, SketchPoint, SketchPoint)> = (0..lines.len())
        .flat_map(|i| {
            let ([c, s], line) = (lines[i].direction(), &lines[i]);
            [(i, line.from, [-c, -s], ends[i][0]), (i, line.to, [c, s], ends[i][1])]
        })
        .filter(|(_, _, _, end)| end.is_none())
        .map(|(i, at, onward, _)| (i, at, onward))
        .collect();
    let points: Vec<Piece> = spots.iter().map(|(_, at, _)| Piece { from: *at, to: *at }).collect();
    let nearby = Nearby::of(points.iter().enumerate());
    let mut chains = Groups::new(lines.len());
    for (i, at, onward) in &spots {
        for (j, other, back) in nearby.to_point(*at).into_iter().filter_map(|k| spots.get(k)) {
            let (dx, dy) = (other[0] - at[0], other[1] - at[1]);
            let aside = (dy * onward[0] - dx * onward[1]).abs();
            let opposed = onward[0] * back[0] + onward[1] * back[1] < -1.0 + 0.5 * ASLANT * ASLANT;
            if i != j && opposed && dx.hypot(dy) <= TOUCH_M && aside <= AT_CORNER_M {
                chains.join(*i, *j);
            }
        }
    }
    nearby.check()?;
    Ok((0..lines.len()).map(|i| chains.first(i)).collect())
}

/// Windows and ways through that the lines show which are no walls; `doors` are known already. What is found is counted in a note.
pub(super) fn find(
    drawn: &[&Drawn<'_>],
    is_wall: impl Fn(&Drawn<'_>) -> bool,
    found: &[Element],
    notes: &mut Vec<String>,
) -> Result<Vec<Element>, PlanFileError> {
    let faces = Faces::of(found);
    let is_line = |path: &&&Drawn<'_>| path.path.stroke.is_some() && !path.path.dashed && !path.path.curved && !is_wall(path);
    let lines: Vec<Piece> = drawn.iter().filter(is_line).flat_map(|path| path.pieces()).collect();
    let mut openings = together(&spans(&lines, &faces)?)?;
    openings.extend(paper::laid_over(drawn, &is_wall, &lines)?);
    // A leaf that swings says more than the line on its threshold, and a layer more than both.
    let is_opening = |element: &&Element| matches!(element.kind, ElementKind::Door | ElementKind::Window);
    let mut taken = Taken::default();
    found.iter().filter(is_opening).filter_map(middle).for_each(|at| taken.add(at));
    openings.retain(|opening| middle(opening).is_none_or(|at| !taken.holds(at)));
    openings.iter().filter_map(middle).for_each(|at| taken.add(at));
    let ways = gaps::between(found, &faces, &mut taken)?;
    faces.nearby.check()?;
    let count = |kind: ElementKind| openings.iter().filter(|opening| opening.kind == kind).count();
    if openings.len() + ways.len() > 0 {
        notes.push(format!(
            "of gaps in walls {} are windows by the glass drawn in them, {} are ways through by a threshold, {} by nothing between",
            count(ElementKind::Window),
            count(ElementKind::Door),
            ways.len()
        ));
    }
    openings.extend(ways);
    Ok(openings)
}

/// Where openings are known, by squares as wide as [`SAME_GAP_M`].
#[derive(Default)]
struct Taken(HashMap<(i64, i64), Vec<SketchPoint>>);

impl Taken {
    fn square(at: SketchPoint) -> (i64, i64) {
        at.map(|v| (v / SAME_GAP_M).floor() as i64).into()
    }

    /// Whether an opening is near.
    fn holds(&self, at: SketchPoint) -> bool {
        let (x, y) = Self::square(at);
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (x.saturating_add(dx), y.saturating_add(dy))));
        around.filter_map(|square| self.0.get(&square)).flatten().any(|other| distance(at, *other) <= SAME_GAP_M)
    }

    /// Nothing, where one is near: so squares stay nearly empty.
    fn add(&mut self, at: SketchPoint) {
        if !self.holds(at) {
            self.0.entry(Self::square(at)).or_default().push(at);
        }
    }
}

/// Spans of one gap as one opening each.
fn together(spans: &[Span]) -> Result<Vec<Element>, PlanFileError> {
    let middles: Vec<Piece> =
        spans.iter().map(|span| span.piece.point_at(0.5 * span.piece.length(), 0.0)).map(|at| Piece { from: at, to: at }).collect();
    let nearby = Nearby::of(middles.iter().enumerate());
    let mut taken = vec![false; spans.len()];
    let mut openings = Vec::new();
    for (i, first) in spans.iter().enumerate() {
        if taken[i] {
            continue;
        }
        let beside: Vec<usize> =
            nearby.to_point(middles[i].from).into_iter().filter(|j| !taken[*j] && first.is_beside(&spans[*j])).collect();
        let lefts: Vec<f64> = beside.iter().map(|j| first.piece.seen_from(middles[*j].from)[1]).chain([0.0]).collect();
        let (low, high) = lefts.iter().fold((0.0_f64, 0.0_f64), |(low, high), left| (low.min(*left), high.max(*left)));
        // A line drawn twice is one.
        let mut apart = lefts.clone();
        apart.sort_by(f64::total_cmp);
        apart.dedup_by(|a, b| *a - *b < 5e-3);
        let glass = first.inner || beside.iter().any(|j| spans[*j].inner);
        beside.iter().for_each(|j| taken[*j] = true);
        taken[i] = true;
        openings.push(opening(kind_of(apart.len(), glass, first.piece.length()), &first.piece, low, high));
    }
    nearby.check()?;
    Ok(openings)
}

/// What so many lines over a gap of this width are.
fn kind_of(lines: usize, glass: bool, width_m: f64) -> ElementKind {
    let widest = match lines {
        0 | 1 => WIDEST_THRESHOLD_M,
        // Only along both faces: as people draw an opening, or a threshold.
        2 if !glass => WIDEST_DOOR_M,
        _ => 0.0,
    };
    if width_m <= widest { ElementKind::Door } else { ElementKind::Window }
}

/// A rectangle along a piece, from so far to its left to so far.
fn opening(kind: ElementKind, along: &Piece, low: f64, high: f64) -> Element {
    let length = along.length();
    let form = if high - low < THIN_M {
        Form::Line(vec![point(along.from), point(along.to)])
    } else {
        Form::Area(vec![[(0.0, low), (length, low), (length, high), (0.0, high)].map(|(x, y)| point(along.point_at(x, y))).to_vec()])
    };
    Element::new(kind, form)
}

/// Middle of its points.
fn middle(element: &Element) -> Option<SketchPoint> {
    let points: Vec<_> = element.form.points().collect();
    let count = points.len() as f64;
    (!points.is_empty()).then(|| [points.iter().map(|p| p.x).sum::<f64>() / count, points.iter().map(|p| p.y).sum::<f64>() / count])
}

fn distance(a: SketchPoint, b: SketchPoint) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

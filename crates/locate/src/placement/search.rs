//! Which starts survive at which headings and scales? Branch and bound over boxes of (heading, scale).
//!
//! box of headings × scales ──▶ each point of the path lies within a window of cells ──▶ starts for which a window has no free cell
//! are dropped for the whole box; the rest goes on to the box's halves ──▶ one heading, one scale: tested cell by cell
//!
//! Safe: a window holds every cell in which the point lies for any heading and scale of the box, so what is dropped fits nowhere in
//! it, and the answer is that of trying them all. Points near the start have small windows already in wide boxes: they cut first.
//! Pitfall: a window as wide as a wall is thick does not see the wall. Wide windows still see the outside of a robot's map.

use std::ops::Range;

use planwalk_types::FloorPlan;
use rayon::prelude::*;

use super::bits::{Bitmap, Survivors};
use super::modes::Heaps;

/// Widest window that is looked at, cells; wider ones hardly ever drop a start.
const WIDEST: usize = 6;
/// How far points may move within a box to be looked at, cells, and how many of them are looked at. Those that move less were looked
/// at in a wider box; windows of the first kind still see most walls, those of the second only what is wide, like the unknown.
const LOOKS: [(f64, f64, usize); 2] = [(0.35, 1.0, 20), (1.0, 2.5, 5)];
/// Points of a single placement tested far-apart first, before the rest follows along the path.
const FAR_APART: usize = 400;
/// Boxes whose survivors are counted between two reports of progress.
const BATCH: usize = 24;

/// The path as points that every placement must have on free cells, and the headings and scales to try.
#[derive(Debug)]
pub(super) struct Candidates {
    /// Points in the path's unit, from its start.
    pub points: Vec<(f64, f64)>,
    /// Headings of the first pose, ascending, radians.
    pub headings: Vec<f64>,
    /// Metres per unit, ascending.
    pub scales: Vec<f64>,
}

/// What was found.
#[derive(Debug)]
pub(super) struct Found {
    pub starts: Bitmap,
    pub ends: Bitmap,
    pub start_heaps: Heaps,
    pub end_heaps: Heaps,
}

impl Found {
    fn nothing(grid: &Bitmap, plan: &FloorPlan) -> Self {
        Self { starts: grid.emptied(), ends: grid.emptied(), start_heaps: Heaps::new(plan), end_heaps: Heaps::new(plan) }
    }

    fn merge(&mut self, other: Found) {
        self.starts.or(&other.starts);
        self.ends.or(&other.ends);
        self.start_heaps.merge(other.start_heaps);
        self.end_heaps.merge(other.end_heaps);
    }
}

/// A range of headings and one of scales, by index.
#[derive(Debug, Clone)]
struct Box2 {
    headings: Range<usize>,
    scales: Range<usize>,
}

/// Cell in which a point lies for one heading and scale, from the start's.
pub(super) fn offset((x, y): (f64, f64), (sin, cos): (f64, f64), cells_per_unit: f64) -> (i64, i64) {
    // A path that is wider than any plan places nowhere; the bound keeps it countable.
    let cell = |v: f64| (v * cells_per_unit).clamp(-1e9, 1e9).round() as i64;
    (cell(cos * x - sin * y), cell(sin * x + cos * y))
}

/// The search's fixed parts.
struct Search<'a> {
    candidates: &'a Candidates,
    plan: &'a FloorPlan,
    /// Free cells by the side of the window that must hold one.
    windows: Vec<Bitmap>,
    /// Order in which points are looked at.
    order: Vec<usize>,
    /// All points of the path, those that are far apart first.
    points: Vec<(f64, f64)>,
    end_turn_rad: f64,
}

/// All starts; `progress` is told the share done. The walker's heading has turned by `end_turn_rad` at the path's end.
pub(super) fn all(
    candidates: &Candidates,
    plan: &FloorPlan,
    (starts, free): (&Bitmap, Bitmap),
    end_turn_rad: f64,
    progress: &mut dyn FnMut(f64),
) -> Found {
    let mut windows = vec![free];
    for side in 2..=WIDEST {
        windows.push(windows[side - 2].windows(2));
    }
    let order = spread_order(candidates.points.len());
    let first = &order[..order.len().min(FAR_APART)];
    let mut later = vec![true; order.len()];
    first.iter().for_each(|i| later[*i] = false);
    let indices = first.iter().copied().chain((0..later.len()).filter(|i| later[*i]));
    let points = indices.map(|i| candidates.points[i]).collect();
    let search = Search { candidates, plan, windows, order, points, end_turn_rad };
    let boxes = search.first_boxes();
    let all_starts = starts.survivors();
    let mut found = Found::nothing(starts, plan);
    for (batch, group) in boxes.chunks(BATCH).enumerate() {
        let parts: Vec<Found> = group
            .par_iter()
            .map(|first| {
                let mut part = Found::nothing(starts, plan);
                search.descend(first, all_starts.clone(), starts, &mut part);
                part
            })
            .collect();
        parts.into_iter().for_each(|part| found.merge(part));
        progress(((batch * BATCH + group.len()) as f64 / boxes.len() as f64).min(1.0));
    }
    found
}

impl Search<'_> {
    /// Some hundred boxes: enough to share out, and few enough to have a common bound each.
    fn first_boxes(&self) -> Vec<Box2> {
        let pieces = |n: usize, most: usize| {
            let size = n.div_ceil(most).max(1);
            (0..n).step_by(size).map(move |from| from..(from + size).min(n)).collect::<Vec<_>>()
        };
        let scales = pieces(self.candidates.scales.len(), 8);
        let headings = pieces(self.candidates.headings.len(), 36);
        scales.iter().flat_map(|s| headings.iter().map(move |h| Box2 { headings: h.clone(), scales: s.clone() })).collect()
    }

    fn descend(&self, at: &Box2, mut left: Survivors, grid: &Bitmap, found: &mut Found) {
        if at.headings.len() == 1 && at.scales.len() == 1 {
            self.place(self.candidates.headings[at.headings.start], self.candidates.scales[at.scales.start], left, grid, found);
            return;
        }
        let bounds = self.bounds(at);
        self.look(&bounds, &mut left);
        if left.words() == 0 {
            return;
        }
        // The half that shrinks the windows more.
        let by_heading = at.scales.len() == 1 || (at.headings.len() > 1 && bounds.by_heading >= bounds.by_scale);
        let halves = |r: &Range<usize>| {
            let middle = r.start + r.len() / 2;
            [r.start..middle, middle..r.end]
        };
        let [one, other] = if by_heading {
            halves(&at.headings).map(|headings| Box2 { headings, scales: at.scales.clone() })
        } else {
            halves(&at.scales).map(|scales| Box2 { headings: at.headings.clone(), scales })
        };
        self.descend(&one, left.clone(), grid, found);
        self.descend(&other, left, grid, found);
    }

    /// Drops the starts that no heading and scale of the box can have.
    fn look(&self, bounds: &Bounds, left: &mut Survivors) {
        let moved = bounds.by_heading + bounds.by_scale;
        let mut held = left.words();
        for (least, most, looks) in LOOKS {
            let of_kind = |p: &&(f64, f64)| (least..most).contains(&(p.0.hypot(p.1) * moved));
            let points = self.order.iter().map(|i| &self.candidates.points[*i]).filter(of_kind);
            for (i, (dx, dy, side)) in points.filter_map(|point| bounds.window(*point)).take(looks).enumerate() {
                if !left.keep(&self.windows[side - 1], dx, dy) {
                    return;
                }
                // Looks that drop little cost more here than in the halves.
                if i % 5 == 4 {
                    let now = left.words();
                    if 10 * now > 9 * held {
                        break;
                    }
                    held = now;
                }
            }
        }
    }

    /// The starts for one heading and scale, exactly.
    fn place(&self, heading: f64, scale: f64, mut left: Survivors, grid: &Bitmap, found: &mut Found) {
        let turn = libm::sincos(heading);
        let per_unit = scale / self.plan.cell_m();
        let mut last = None;
        for point in &self.points {
            let cell = offset(*point, turn, per_unit);
            if last.replace(cell) == Some(cell) {
                continue;
            }
            if !left.keep(&self.windows[0], cell.0, cell.1) {
                return;
            }
        }
        let end = self.candidates.points.last().map_or((0, 0), |p| offset(*p, turn, per_unit));
        found.starts.add(&left, 0, 0);
        found.ends.add(&left, end.0, end.1);
        let cells = left.cells(grid);
        found.start_heaps.add(cells.iter().copied(), heading, scale);
        // The end is free, so it is on the grid.
        let moved =
            |(column, row): (usize, usize)| Some((column.checked_add_signed(end.0 as isize)?, row.checked_add_signed(end.1 as isize)?));
        found.end_heaps.add(cells.into_iter().filter_map(moved), heading + self.end_turn_rad, scale);
    }

    fn bounds(&self, at: &Box2) -> Bounds {
        let ends = |values: &[f64], r: &Range<usize>| (values[r.start], values[r.end - 1]);
        let (first, last) = ends(&self.candidates.headings, &at.headings);
        let (low, high) = ends(&self.candidates.scales, &at.scales);
        let (scale, cell_m) = (0.5 * (low + high), self.plan.cell_m());
        Bounds {
            turn: libm::sincos(0.5 * (first + last)),
            per_unit: scale / cell_m,
            by_heading: scale * 0.5 * (last - first) / cell_m,
            by_scale: 0.5 * (high - low) / cell_m,
        }
    }
}

/// Where points can lie for the headings and scales of a box.
struct Bounds {
    /// Sine and cosine of the middle heading.
    turn: (f64, f64),
    /// Cells a unit, middle scale.
    per_unit: f64,
    /// Cells by which a point a unit from the start moves from the middle heading to the outermost ones.
    by_heading: f64,
    /// The same for the scale.
    by_scale: f64,
}

impl Bounds {
    /// Lower left corner and side of the window that holds the point's cell, from the start's; `None` where it is too wide.
    ///
    /// |s R(h) p − s₀ R(h₀) p| ≤ |p| (|s − s₀| + s₀ |h − h₀|).
    fn window(&self, (x, y): (f64, f64)) -> Option<(i64, i64, usize)> {
        let off = x.hypot(y) * (self.by_heading + self.by_scale);
        if !(off < WIDEST as f64) {
            return None;
        }
        let (sin, cos) = self.turn;
        // The margin is for round-off: these are numbers of cells, thousands at most.
        let reach = off + 1e-6;
        let span = |v: f64| ((v - reach).round() as i64, (v + reach).round() as i64);
        let (left, right) = span((cos * x - sin * y) * self.per_unit);
        let (bottom, top) = span((sin * x + cos * y) * self.per_unit);
        let side = (right - left).max(top - bottom) as usize + 1;
        (side <= WIDEST).then_some((left, bottom, side))
    }
}

/// 0..n with far-apart indices first: the end, the middle, the quarters …
pub(super) fn spread_order(n: usize) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::with_capacity(n);
    let mut stride = n.next_power_of_two();
    order.extend(n.checked_sub(1));
    let mut taken = vec![false; n];
    if let Some(last) = taken.last_mut() {
        *last = true;
    }
    while stride > 0 {
        for i in (0..n).step_by(stride) {
            if !taken[i] {
                taken[i] = true;
                order.push(i);
            }
        }
        stride /= 2;
    }
    order
}

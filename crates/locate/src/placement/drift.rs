//! Where could a walk have started and ended whose trajectory drifts? Sets of places, moved along the path and cut by walls.
//!
//! for each scale and first heading: a set of cells ──▶ [move, grow by what drift allows, cut by walls] along a stretch of the path,
//! ──▶ pass the set on to the neighbouring headings ──▶ the next stretch ──▶ … ──▶ ends; the same backwards from there ──▶ starts
//!
//! A filter of sets: nothing is weighed, and nothing within the tolerance is lost. Three roundings, all outwards, make it so:
//! * A set's cells say where the walker would be, had the path stood still since the last *anchor*; the path since then is added
//!   exactly. A new anchor spreads each cell over the 2 × 2 cells that it covers after the move.
//! * Drift moves the walker within its cell's neighbourhood. Each half cell of it grows the set by a cell; up to then the walker is
//!   within half a cell of its cell, and so in a square of 3 × 3 cells of the plan. If none of them is free, the cell is dropped.
//! * A heading stands for all within half a sector. Over a stretch of ℓ metres drift is at most D √ℓ = half a sector: within the
//!   stretch the heading is at most one sector off, after it the set goes to both neighbours. Those that are farther from the first
//!   heading than drift allows since the start are dropped.
//!
//! Pitfall: walls thinner than three cells would not be seen, so such plans are cut into finer cells.

use std::f64::consts::TAU;

use planwalk_types::FloorPlan;
use rayon::prelude::*;

use super::bits::Bitmap;
use super::modes::Heaps;
use super::{PlaceOptions, Placement, Tolerance, may_pass, may_start, samples};
use crate::LocateError;

/// Largest heading drift, radians per √metre (20°): beyond it a walk of some metres may go anywhere.
const MOST_DRIFT: f64 = 0.35;
/// Largest error of a step's length.
const MOST_LENGTH_ERROR: f64 = 0.3;
/// Narrowest and widest sector of heading, radians.
const SECTOR_RAD: (f64, f64) = (0.035, 0.21);
/// Metres between anchors where no drift asks for them more often.
const ANCHOR_M: f64 = 8.0;
/// First headings followed between two reports of progress.
const BATCH: usize = 16;
/// Most cells that a plan is cut into.
const MOST_CELLS: usize = 2_000_000;
/// Share of the walls that must be thick enough: a few glazing bars do not make a plan four times as dear.
const MOSTLY: f64 = 0.9;
/// How far sets may grow over the plan's edge between anchors, cells.
const MARGIN: usize = 24;

/// Regions of a trajectory within its tolerance; `scales` are possible ones, `end_turn_rad` is the heading at the end from that at the start.
pub(super) fn place(
    corners: &[(f64, f64)],
    plan: &FloorPlan,
    options: &PlaceOptions,
    scales: (f64, f64),
    end_turn_rad: f64,
    progress: &mut dyn FnMut(f64),
) -> Result<Placement, LocateError> {
    let sectors = Sectors::of(options)?;
    let ground = Ground::new(plan, options);
    let (middles, half_ratio) = scale_bins(scales, options.scale_ratio);
    let mut sums = [ground.free.emptied(), ground.free.emptied()];
    let mut heaps = [Heaps::new(plan), Heaps::new(plan)];
    for (i, scale) in middles.iter().enumerate() {
        let walk = Walk::new(corners, *scale, half_ratio, &sectors, &ground);
        let firsts: Vec<usize> = if sectors.known { vec![0] } else { (0..sectors.count).collect() };
        for (batch, group) in firsts.chunks(BATCH).enumerate() {
            let parts: Vec<[Vec<Held>; 2]> = group.par_iter().map(|first| walk.both_ways(*first)).collect();
            for (which, turned) in [0.0, end_turn_rad].into_iter().enumerate() {
                for Held { heading_rad, set } in parts.iter().flat_map(|part| &part[which]) {
                    sums[which].or(set);
                    heaps[which].add(ground.plan_cells(set, plan).into_iter(), heading_rad + turned, *scale);
                }
            }
            let done = (batch * BATCH + group.len()) as f64 / firsts.len() as f64;
            progress((i as f64 + done) / middles.len() as f64);
        }
    }
    let regions = sums.map(|sum| {
        let mut region = vec![false; plan.cells().len()];
        ground.plan_cells(&sum, plan).into_iter().for_each(|(column, row)| region[row * plan.width() + column] = true);
        region
    });
    Ok(Placement::of(plan, regions, heaps, sectors.count * middles.len()))
}

/// Places at one heading of the path's first pose.
struct Held {
    heading_rad: f64,
    set: Bitmap,
}

/// Middles of the bins of scale, and by which ratio the bins reach to both sides of them.
fn scale_bins((low, high): (f64, f64), ratio: f64) -> (Vec<f64>, f64) {
    let whole = libm::log(high / low);
    let count = (whole / libm::log(ratio.clamp(1.005, 1.2))).ceil().max(1.0);
    let middles = (0..count as usize).map(|i| low * libm::exp(whole * (i as f64 + 0.5) / count)).collect();
    (middles, libm::exp(0.5 * whole / count))
}

/// Headings in sectors.
struct Sectors {
    tolerance: Tolerance,
    count: usize,
    /// Heading of sector 0.
    first_rad: f64,
    /// Whether only sector 0 is a start.
    known: bool,
}

impl Sectors {
    fn of(options: &PlaceOptions) -> Result<Self, LocateError> {
        let tolerance = options.tolerance;
        let Tolerance { drift_rad_per_sqrt_m: drift, length_error } = tolerance;
        if !((0.0..=MOST_DRIFT).contains(&drift) && (0.0..=MOST_LENGTH_ERROR).contains(&length_error)) {
            let (most_drift, most_length_error) = (MOST_DRIFT, MOST_LENGTH_ERROR);
            return Err(LocateError::BadTolerance { drift_rad_per_sqrt_m: drift, most_drift, length_error, most_length_error });
        }
        // Half a sector in 4 m: anchors and what they cost stay rare.
        let width = (4.0 * drift).max(options.heading_step_rad.min(SECTOR_RAD.0)).clamp(0.2f64.to_radians(), SECTOR_RAD.1);
        let count = (TAU / width).ceil() as usize;
        let first_rad = options.heading_rad.filter(|h| h.is_finite());
        Ok(Self { tolerance, count, first_rad: first_rad.unwrap_or(0.0), known: first_rad.is_some() })
    }

    fn width_rad(&self) -> f64 {
        TAU / self.count as f64
    }

    fn heading(&self, sector: usize) -> f64 {
        self.first_rad + sector as f64 * self.width_rad()
    }

    /// Metres in which drift reaches half a sector; `None` without drift.
    fn stretch_m(&self) -> Option<f64> {
        let drift = self.tolerance.drift_rad_per_sqrt_m;
        (drift > 0.0).then(|| (0.5 * self.width_rad() / drift).powi(2))
    }

    /// How many sectors the heading may be from the first one after so many metres.
    fn off_after(&self, walked_m: f64) -> usize {
        // Half a sector at the start, half a sector here, and what drift adds.
        let sectors = 1.0 + self.tolerance.drift_rad_per_sqrt_m * walked_m.max(0.0).sqrt() / self.width_rad();
        if self.tolerance.drift_rad_per_sqrt_m > 0.0 { ((sectors + 1e-9) as usize).min(self.count / 2) } else { 0 }
    }
}

/// The plan in cells that walls are at least three of thick, where that can be afforded.
struct Ground {
    /// Cells of ours along a cell of the plan.
    finer: usize,
    cell_m: f64,
    starts: Bitmap,
    free: Bitmap,
    /// Whether one of the 3 × 3 cells rightwards and upwards is free.
    windows: Bitmap,
}

impl Ground {
    fn new(plan: &FloorPlan, options: &PlaceOptions) -> Self {
        let finer = finer(plan, options);
        let (width, height) = (finer * plan.width(), finer * plan.height());
        let index = |c: usize, r: usize| r / finer * plan.width() + c / finer;
        let free = Bitmap::of(width, height, MARGIN, |c, r| may_pass(plan, options, index(c, r)));
        let starts = Bitmap::of(width, height, MARGIN, |c, r| may_start(plan, options, index(c, r)));
        Self { finer, cell_m: plan.cell_m() / finer as f64, starts, windows: free.windows(3), free }
    }

    /// The cells of the plan that hold one of these, each once.
    fn plan_cells(&self, set: &Bitmap, plan: &FloorPlan) -> Vec<(usize, usize)> {
        let mut cells: Vec<(usize, usize)> = set.cells().map(|(c, r)| (r / self.finer, c / self.finer)).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.retain(|(row, column)| *row < plan.height() && *column < plan.width());
        cells.into_iter().map(|(row, column)| (column, row)).collect()
    }
}

/// Into how many cells a cell of the plan is cut along each side, so that (nearly) all walls are three cells thick.
fn finer(plan: &FloorPlan, options: &PlaceOptions) -> usize {
    let (width, height) = (plan.width(), plan.height());
    if 4 * width * height > MOST_CELLS {
        // Sound all the same: thin walls are then walked through, and the regions are larger than they need be.
        return 1;
    }
    let solid = |c: usize, r: usize| !may_pass(plan, options, r * width + c);
    // Share of the solid cells that lie in a solid square of this side.
    let thick = |side: usize| {
        let mut held = vec![false; width * height];
        for row in 0..(height + 1).saturating_sub(side) {
            for column in 0..(width + 1).saturating_sub(side) {
                let square = || (0..side * side).map(|i| (column + i % side, row + i / side));
                if square().all(|(c, r)| solid(c, r)) {
                    square().for_each(|(c, r)| held[r * width + c] = true);
                }
            }
        }
        let all = (0..width * height).filter(|i| solid(i % width, i / width)).count();
        held.iter().filter(|h| **h).count() as f64 >= MOSTLY * all as f64
    };
    let wanted = if thick(3) {
        1
    } else if thick(2) {
        2
    } else {
        3
    };
    (1..=wanted).rev().find(|k| k * k * width * height <= MOST_CELLS).unwrap_or(1)
}

/// The path at one scale.
struct Walk<'a> {
    sectors: &'a Sectors,
    ground: &'a Ground,
    /// Points of the path in cells, the path's own axes.
    points: Vec<(f64, f64)>,
    /// How far a step's end may be off, as a share of the step: along it and across.
    off: (f64, f64),
    /// Cells of path between anchors.
    stretch: f64,
    /// Metres walked in a cell of path, at most.
    metres: f64,
}

impl<'a> Walk<'a> {
    fn new(corners: &[(f64, f64)], scale: f64, half_ratio: f64, sectors: &'a Sectors, ground: &'a Ground) -> Self {
        let stretch_m = sectors.stretch_m().unwrap_or(ANCHOR_M).min(ANCHOR_M);
        let turn = 0.5 * sectors.width_rad() + sectors.tolerance.drift_rad_per_sqrt_m * stretch_m.sqrt();
        let longer = half_ratio * (1.0 + sectors.tolerance.length_error);
        // (longer − 1) along; and what a turn of the whole step does to both.
        let off = (longer - 1.0 + 0.5 * turn * turn, turn * longer);
        // Along and across together stay under the half cell that a set stands for.
        let spacing = (0.45 / (off.0 + off.1)).min(1.0);
        let per_unit = scale / ground.cell_m;
        let points = samples(corners, spacing / per_unit).into_iter().map(|(x, y)| (x * per_unit, y * per_unit)).collect();
        // The longest step of the tolerance is longer than the middle one: stretches are metres walked. Within one, a set must not
        // grow out of the grid's margin.
        let stretch = (stretch_m / ground.cell_m / longer).min((MARGIN - 4) as f64 / (off.0 + off.1));
        Self { sectors, ground, points, off, stretch, metres: longer * ground.cell_m }
    }

    /// Starts and ends of walks whose first heading is in this sector.
    fn both_ways(&self, first: usize) -> [Vec<Held>; 2] {
        let whole = self.metres * self.points.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum::<f64>();
        let most = self.sectors.off_after(whole);
        let mut sets = vec![self.ground.free.emptied(); 2 * most + 1];
        sets[most] = self.ground.starts.clone();
        let ends = self.follow(sets, first, &self.points, &|walked_m| walked_m);
        let back: Vec<(f64, f64)> = self.points.iter().rev().copied().collect();
        let mut starts = self.follow(ends.clone(), first, &back, &|walked_m| whole - walked_m);
        for set in &mut starts {
            set.and_moved(&self.ground.starts, 0, 0);
        }
        let held = |(i, set): (usize, Bitmap)| {
            let heading_rad = self.sectors.heading(first) + (i as f64 - most as f64) * self.sectors.width_rad();
            (!set.is_empty()).then_some(Held { heading_rad, set })
        };
        // A walk starts in its first sector.
        let starts = starts.into_iter().enumerate().filter(|(i, _)| *i == most).filter_map(held).collect();
        [starts, ends.into_iter().enumerate().filter_map(held).collect()]
    }

    /// Where the walker may be after these points, by sector of heading around the first one. `from_start_m` says how far from the
    /// path's start one is after so many metres of them.
    fn follow(&self, mut sets: Vec<Bitmap>, first: usize, points: &[(f64, f64)], from_start_m: &dyn Fn(f64) -> f64) -> Vec<Bitmap> {
        let most = sets.len() / 2;
        let (mut from, mut walked) = (0, 0.0);
        while from + 1 < points.len() {
            let mut length = 0.0;
            let mut to = from + 1;
            while to < points.len() {
                let step = (points[to].0 - points[to - 1].0).hypot(points[to].1 - points[to - 1].1);
                if length + step > self.stretch && to > from + 1 {
                    break;
                }
                length += step;
                to += 1;
            }
            let part = &points[from..to];
            let heading = |i: usize| self.sectors.heading(first) + (i as f64 - most as f64) * self.sectors.width_rad();
            sets = sets.into_iter().enumerate().map(|(i, set)| self.along(part, heading(i), set)).collect();
            walked += length;
            // A metre more, for what was rounded on the way.
            let off = self.sectors.off_after(from_start_m(self.metres * walked) + 1.0);
            sets = spread(&sets, most, off);
            if sets.iter().all(Bitmap::is_empty) {
                return sets;
            }
            from = to - 1;
        }
        sets
    }

    /// A set moved along a stretch, at one heading.
    fn along(&self, part: &[(f64, f64)], heading_rad: f64, mut set: Bitmap) -> Bitmap {
        let (sin, cos) = libm::sincos(heading_rad);
        let turned = |(x, y): (f64, f64)| (cos * x - sin * y, sin * x + cos * y);
        let anchor = turned(part[0]);
        let mut last = anchor;
        let mut drift = (0.0, 0.0);
        let mut tested = None;
        for point in &part[1..] {
            if set.is_empty() {
                return set;
            }
            let at = turned(*point);
            let (dx, dy) = ((at.0 - last.0).abs(), (at.1 - last.1).abs());
            let step = (self.off.0 * dx + self.off.1 * dy, self.off.0 * dy + self.off.1 * dx);
            // Half a cell of drift is what the test below forgives.
            for (so_far, more, along_row) in [(&mut drift.0, step.0, true), (&mut drift.1, step.1, false)] {
                if *so_far + more > 0.5 {
                    set.grow(along_row);
                    *so_far = 0.0;
                    tested = None;
                }
                *so_far += more;
            }
            last = at;
            let corner = ((at.0 - anchor.0 - 0.5).floor() as i64, (at.1 - anchor.1 - 0.5).floor() as i64);
            if tested.replace(corner) != Some(corner) {
                set.and_moved(&self.ground.windows, corner.0, corner.1);
            }
        }
        self.anchored(set, (last.0 - anchor.0, last.1 - anchor.1), drift)
    }

    /// The set at the stretch's end, moved there.
    fn anchored(&self, mut set: Bitmap, (x, y): (f64, f64), drift: (f64, f64)) -> Bitmap {
        for (so_far, along_row) in [(drift.0, true), (drift.1, false)] {
            if so_far > 0.0 && !set.is_empty() {
                set.grow(along_row);
            }
        }
        let mut moved = set.emptied();
        if set.is_empty() {
            return moved;
        }
        let (left, bottom) = (x.floor() as i64, y.floor() as i64);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            moved.or_moved(&set, -(left + dx), -(bottom + dy));
        }
        // The walker stands on one of these cells itself: nothing is forgiven here.
        moved.and_moved(&self.ground.free, 0, 0);
        moved
    }
}

/// Each heading's set with those of its neighbours, as far as `off` from the middle one.
fn spread(sets: &[Bitmap], middle: usize, off: usize) -> Vec<Bitmap> {
    let with_neighbours = |i: usize| {
        if i.abs_diff(middle) > off {
            return sets[i].emptied();
        }
        let mut all = sets[i].clone();
        let neighbours = [i.checked_sub(1), Some(i + 1)];
        neighbours.into_iter().flatten().filter_map(|n| sets.get(n)).filter(|set| !set.is_empty()).for_each(|set| all.or(set));
        all
    };
    (0..sets.len()).map(with_neighbours).collect()
}

//! From where can this trajectory be walked without hitting a wall? All starts, exactly, for a perfect trajectory.
//!
//! for each heading and scale: AND of the free cells, shifted by every point of the trajectory ──▶ start cells ──▶ region, modes
//!
//! This is the localisation of perfect kinematics: placing the trajectory on the map. 64 cells are tested by one instruction;
//! points are taken far-apart first, so that most headings die after a few dozen of them.
//! Pitfall: "perfect" is meant; drift of a corridor's half width over the whole path empties the region.

use planwalk_types::{Cell, FloorPlan, Path, PlanPose};
use rayon::prelude::*;

use crate::LocateError;

/// Options of [`place`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceOptions {
    /// Heading of the path's first pose on the plan, radians; `None` tries all.
    pub heading_rad: Option<f64>,
    /// Largest step between the headings that are tried, radians. Steps are finer, down to 0.1°, where the farthest point of the
    /// path would move by more than two cells from one to the next: it would jump over doors.
    pub heading_step_rad: f64,
    /// Lowest and highest scale, metres per unit of the path.
    pub scales: (f64, f64),
    /// Ratio between the scales that are tried.
    pub scale_ratio: f64,
    /// How sure a start must be inside the building, 0..=1; 0 admits all free cells.
    pub inside: f64,
    /// Whether the walk may pass over cells that the plan does not know.
    pub through_unknown: bool,
}

impl Default for PlaceOptions {
    /// All headings, metres as they are.
    fn default() -> Self {
        Self {
            heading_rad: None,
            heading_step_rad: 2f64.to_radians(),
            scales: (1.0, 1.0),
            scale_ratio: 1.05,
            inside: 0.5,
            through_unknown: false,
        }
    }
}

/// A cluster of placements: neighbours in place and heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacementMode {
    /// Mean start.
    pub start: PlanPose,
    /// Mean scale, metres per unit of the path.
    pub scale: f64,
    /// Share of all placements (start cell, heading, scale) found, 0..=1.
    pub share: f64,
}

/// Every placement of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Cells from which some heading and scale hit no wall; row 0 at the bottom, as the plan's.
    pub start_region: Vec<bool>,
    /// Area of the region, m².
    pub area_m2: f64,
    /// Clusters, most placements first.
    pub modes: Vec<PlacementMode>,
    /// Headings and scales tried.
    pub tried: usize,
}

/// A plan of bits: 64 cells a word, rows padded to whole words.
#[derive(Debug, Clone)]
struct Bitmap {
    words: Vec<u64>,
    per_row: usize,
    width: usize,
    height: usize,
}

impl Bitmap {
    fn of(plan: &FloorPlan, mut hold: impl FnMut(usize) -> bool) -> Self {
        let (width, height) = (plan.width(), plan.height());
        let per_row = width.div_ceil(64);
        let mut words = vec![0u64; per_row * height];
        for index in 0..width * height {
            if hold(index) {
                let (column, row) = (index % width, index / width);
                words[row * per_row + column / 64] |= 1 << (column % 64);
            }
        }
        Self { words, per_row, width, height }
    }

    /// Keeps the cells from which the cell (dx, dy) farther is in `other` (and on the grid); says whether any is left.
    fn and_shifted(&mut self, other: &Bitmap, dx: i64, dy: i64, rows: &mut std::ops::Range<usize>) -> bool {
        let (mut first, mut last) = (usize::MAX, 0);
        for row in rows.clone() {
            let words = &mut self.words[row * self.per_row..(row + 1) * self.per_row];
            let source = row as i64 + dy;
            if source < 0 || source >= self.height as i64 {
                words.fill(0);
                continue;
            }
            let source = &other.words[source as usize * self.per_row..(source as usize + 1) * self.per_row];
            if and_row(words, source, dx) {
                first = first.min(row);
                last = row;
            }
        }
        *rows = if first == usize::MAX { 0..0 } else { first..last + 1 };
        rows.start < rows.end
    }

    fn cells(&self, rows: std::ops::Range<usize>) -> impl Iterator<Item = (usize, usize)> + '_ {
        rows.flat_map(move |row| {
            self.words[row * self.per_row..(row + 1) * self.per_row].iter().enumerate().flat_map(move |(i, word)| {
                let mut rest = *word;
                std::iter::from_fn(move || {
                    let bit = rest.trailing_zeros() as usize;
                    rest &= rest.wrapping_sub(1);
                    (bit < 64).then_some((64 * i + bit, row))
                })
            })
        })
    }
}

/// Cells of one block: how many, and the sums of their columns and rows.
type BlockCount = (usize, usize, usize);

impl Bitmap {
    /// Adds the other's cells in these rows.
    fn or_rows(&mut self, other: &Bitmap, rows: std::ops::Range<usize>) {
        let words = rows.start * self.per_row..rows.end * self.per_row;
        for (word, more) in self.words[words.clone()].iter_mut().zip(&other.words[words]) {
            *word |= more;
        }
    }

    /// The cells in these rows by blocks of `block` × `block`.
    fn blocks(&self, rows: std::ops::Range<usize>, block: usize) -> Vec<((usize, usize), BlockCount)> {
        let columns = self.width.div_ceil(block);
        let mut found = Vec::new();
        let mut counts: Vec<BlockCount> = vec![(0, 0, 0); columns];
        for block_row in rows.start / block..rows.end.div_ceil(block) {
            let within = (block_row * block).max(rows.start)..((block_row + 1) * block).min(rows.end);
            for (column, row) in self.cells(within) {
                let count = &mut counts[column / block];
                *count = (count.0 + 1, count.1 + column, count.2 + row);
            }
            for (block_column, count) in counts.iter_mut().enumerate().filter(|(_, count)| count.0 > 0) {
                found.push(((block_column, block_row), std::mem::take(count)));
            }
        }
        found
    }
}

/// `words[c] &= source[c + dx]` for every cell c of one row; bits beyond the row are 0.
fn and_row(words: &mut [u64], source: &[u64], dx: i64) -> bool {
    let (shift_words, shift_bits) = (dx.div_euclid(64), dx.rem_euclid(64) as u32);
    let at = |i: i64| usize::try_from(i).ok().and_then(|i| source.get(i)).copied().unwrap_or(0);
    let mut any = 0;
    for (i, word) in words.iter_mut().enumerate() {
        if *word == 0 {
            continue;
        }
        let low = at(i as i64 + shift_words) >> shift_bits;
        let high = if shift_bits == 0 { 0 } else { at(i as i64 + shift_words + 1) << (64 - shift_bits) };
        *word &= low | high;
        any |= *word;
    }
    any != 0
}

/// Every start on the plan from which the path hits no wall. Deterministic; `progress` is told the share done.
///
/// The path's own noise is ignored: it is taken to be perfect. Starts are cell centres; the path is sampled at half a cell and
/// its points are rounded to cells.
///
/// # Errors
/// [`LocateError`] when the path is empty or not finite, or the range of scales holds nothing. No placement is an answer.
pub fn place(path: &Path, plan: &FloorPlan, options: &PlaceOptions, progress: &mut dyn FnMut(f64)) -> Result<Placement, LocateError> {
    let points = points_of(path)?;
    let poses = candidates(options, &points, plan.cell_m())?;
    let free = Bitmap::of(plan, |i| match plan.cells()[i] {
        Cell::Free | Cell::Door => true,
        Cell::Wall | Cell::Window => false,
        Cell::Unknown => options.through_unknown,
    });
    let starts = Bitmap::of(plan, |i| plan.cells()[i].is_floor() && f64::from(plan.inside()[i]) >= options.inside);
    let mut region = Bitmap { words: vec![0; starts.words.len()], ..starts.clone() };
    let mut heaps = Heaps::new(plan);
    let block = heaps.block;
    // Batches bound the memory and give the progress a pulse.
    const BATCH: usize = 64;
    for (batch, group) in poses.chunks(BATCH).enumerate() {
        let found: Vec<_> = group
            .par_iter()
            .map(|(heading, scale)| {
                let (cells, rows) = placements(&points, *heading, *scale, plan.cell_m(), &starts, &free);
                let blocks = cells.blocks(rows.clone(), block);
                (cells, rows, blocks)
            })
            .collect();
        for ((heading, scale), (cells, rows, blocks)) in group.iter().zip(found) {
            region.or_rows(&cells, rows);
            for (key, count) in blocks {
                heaps.add(key, count, *heading, *scale);
            }
        }
        progress(((batch * BATCH + group.len()) as f64 / poses.len() as f64).min(1.0));
    }
    let mut start_region = vec![false; plan.cells().len()];
    for (column, row) in region.cells(0..region.height) {
        start_region[row * plan.width() + column] = true;
    }
    let area_m2 = start_region.iter().filter(|r| **r).count() as f64 * plan.cell_m() * plan.cell_m();
    Ok(Placement { start_region, area_m2, modes: heaps.modes(plan), tried: poses.len() })
}

fn points_of(path: &Path) -> Result<Vec<(f64, f64)>, LocateError> {
    if path.steps.is_empty() {
        return Err(LocateError::EmptyPath { steps: 0 });
    }
    let broken = |s: &planwalk_types::Step| !(s.forward.is_finite() && s.left.is_finite() && s.turn_rad.is_finite());
    if let Some(index) = path.steps.iter().position(broken) {
        return Err(LocateError::NotFinite { index });
    }
    Ok(path.poses().iter().map(|pose| (pose.x, pose.y)).collect())
}

/// All (heading, scale) to try.
fn candidates(options: &PlaceOptions, points: &[(f64, f64)], cell_m: f64) -> Result<Vec<(f64, f64)>, LocateError> {
    let (low, high) = options.scales;
    if !(low > 0.0 && high >= low && high.is_finite() && options.scale_ratio.is_finite()) {
        return Err(LocateError::BadScaleRange { low, high });
    }
    // Bounded: 0.1° and 0.1 % are finer than any cell.
    let ratio = options.scale_ratio.max(1.001);
    let scale_steps = (libm::log(high / low) / libm::log(ratio)).ceil().min(10_000.0) as usize;
    let scales = (0..=scale_steps).map(|i| low * libm::pow(high / low, if scale_steps > 0 { i as f64 / scale_steps as f64 } else { 0.0 }));
    let headings: Vec<f64> = match options.heading_rad {
        Some(heading) => vec![if heading.is_finite() { heading } else { 0.0 }],
        None => {
            let reach_m = high * points.iter().map(|p| p.0.hypot(p.1)).fold(0.0, f64::max);
            let step = options.heading_step_rad.min(2.0 * cell_m / reach_m.max(cell_m)).max(0.1f64.to_radians());
            let count = (std::f64::consts::TAU / step).ceil().max(1.0) as usize;
            (0..count).map(|i| i as f64 * std::f64::consts::TAU / count as f64).collect()
        }
    };
    Ok(scales.flat_map(|scale| headings.iter().map(move |heading| (*heading, scale)).collect::<Vec<_>>()).collect())
}

/// Start cells for one heading and scale.
fn placements(
    points: &[(f64, f64)],
    heading: f64,
    scale: f64,
    cell_m: f64,
    starts: &Bitmap,
    free: &Bitmap,
) -> (Bitmap, std::ops::Range<usize>) {
    let mut cells = starts.clone();
    let mut rows = 0..starts.height;
    for (dx, dy) in offsets(points, heading, scale / cell_m) {
        if dx.unsigned_abs() as usize >= starts.width || !cells.and_shifted(free, dx, dy, &mut rows) {
            return (cells, 0..0);
        }
    }
    (cells, rows)
}

/// The cells that the path touches, as seen from its start, each once, the most telling order first.
fn offsets(points: &[(f64, f64)], heading: f64, cells_per_unit: f64) -> Vec<(i64, i64)> {
    let (s, c) = libm::sincos(heading);
    let turned = |(x, y): (f64, f64)| ((c * x - s * y) * cells_per_unit, (s * x + c * y) * cells_per_unit);
    // A path that is wider than any plan places nowhere; the bound keeps its samples countable.
    let bounded = |v: f64| v.clamp(-1e6, 1e6);
    let mut along = vec![(0i64, 0i64)];
    for pair in points.windows(2) {
        let (from, to) = (turned(pair[0]), turned(pair[1]));
        let count = (2.0 * (to.0 - from.0).hypot(to.1 - from.1)).ceil().clamp(1.0, 1e6) as usize;
        for i in 1..=count {
            let t = i as f64 / count as f64;
            let cell = (bounded(from.0 + t * (to.0 - from.0)).round() as i64, bounded(from.1 + t * (to.1 - from.1)).round() as i64);
            if along.last() != Some(&cell) {
                along.push(cell);
            }
        }
    }
    let mut seen = std::collections::BTreeSet::new();
    spread_order(along.len()).into_iter().map(|i| along[i]).filter(|cell| seen.insert(*cell)).collect()
}

/// 0..n with far-apart indices first: the end, the middle, the quarters …
fn spread_order(n: usize) -> Vec<usize> {
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

/// Placements gathered by half a metre and heading, for clustering.
struct Heaps {
    block: usize,
    heaps: std::collections::BTreeMap<(i64, i64, i64), Heap>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Heap {
    count: f64,
    column: f64,
    row: f64,
    sin: f64,
    cos: f64,
    scale: f64,
}

/// Sectors of heading that cluster: 10°.
const SECTORS: i64 = 36;

impl Heaps {
    fn new(plan: &FloorPlan) -> Self {
        Self { block: (0.5 / plan.cell_m()).round().max(1.0) as usize, heaps: std::collections::BTreeMap::new() }
    }

    fn add(&mut self, (column, row): (usize, usize), (count, columns, rows): BlockCount, heading: f64, scale: f64) {
        let turn = heading / std::f64::consts::TAU;
        let sector = ((turn - turn.floor()) * SECTORS as f64) as i64 % SECTORS;
        let heap = self.heaps.entry((column as i64, row as i64, sector)).or_default();
        let (s, c) = libm::sincos(heading);
        let cells = count as f64;
        heap.count += cells;
        heap.column += columns as f64;
        heap.row += rows as f64;
        heap.sin += cells * s;
        heap.cos += cells * c;
        heap.scale += cells * scale;
    }

    /// Connected components of the heaps, largest first.
    fn modes(mut self, plan: &FloorPlan) -> Vec<PlacementMode> {
        let total: f64 = self.heaps.values().map(|h| h.count).sum();
        let mut modes = Vec::new();
        while let Some((key, heap)) = self.heaps.pop_first() {
            let mut sum = Heap::default();
            let mut open = vec![(key, heap)];
            while let Some(((column, row, sector), heap)) = open.pop() {
                sum = sum.with(&heap);
                for (dc, dr, ds) in neighbours() {
                    let key = (column + dc, row + dr, (sector + ds).rem_euclid(SECTORS));
                    if let Some(heap) = self.heaps.remove(&key) {
                        open.push((key, heap));
                    }
                }
            }
            modes.push(sum.mode(plan, total));
        }
        modes.sort_by(|a, b| b.share.total_cmp(&a.share));
        modes
    }
}

fn neighbours() -> impl Iterator<Item = (i64, i64, i64)> {
    (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

impl Heap {
    fn with(self, other: &Heap) -> Heap {
        Heap {
            count: self.count + other.count,
            column: self.column + other.column,
            row: self.row + other.row,
            sin: self.sin + other.sin,
            cos: self.cos + other.cos,
            scale: self.scale + other.scale,
        }
    }

    fn mode(&self, plan: &FloorPlan, total: f64) -> PlacementMode {
        let centre = |sum: f64| (sum / self.count + 0.5) * plan.cell_m();
        let (x, y) = (plan.origin().x + centre(self.column), plan.origin().y + centre(self.row));
        let start = PlanPose::new(x, y, libm::atan2(self.sin, self.cos));
        PlacementMode { start, scale: self.scale / self.count, share: self.count / total }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;
    use planwalk_types::{Pt2, Stamp, Step, Wall};

    /// Two rooms and a corridor with a corner, 7 m × 5 m, coarse cells.
    fn plan() -> FloorPlan {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
        let walls = [
            wall(0.0, 0.0, 7.0, 0.0),
            wall(7.0, 0.0, 7.0, 5.0),
            wall(7.0, 5.0, 0.0, 5.0),
            wall(0.0, 5.0, 0.0, 0.0),
            wall(0.0, 1.5, 5.5, 1.5),
            wall(3.0, 1.5, 3.0, 5.0),
        ];
        FloorPlan::from_walls(&walls, 0.1, 0.5).unwrap()
    }

    fn path(legs: &[(f64, f64)]) -> Path {
        let step = |(i, (forward, turn_rad)): (usize, &(f64, f64))| Step {
            from: Stamp(i as i64),
            to: Stamp(i as i64 + 1),
            forward: *forward,
            left: 0.0,
            turn_rad: *turn_rad,
            covariance: Matrix3::zeros(),
            unit_change: 0.0,
        };
        Path { steps: legs.iter().enumerate().map(step).collect() }
    }

    /// A corner: 4 m ahead, left, 2 m ahead.
    fn corner() -> Path {
        path(&[(4.0, std::f64::consts::FRAC_PI_2), (2.0, 0.0)])
    }

    #[test]
    fn bits_agree_with_brute_force() {
        let plan = plan();
        let options = PlaceOptions { heading_step_rad: 0.3, scales: (0.8, 1.2), scale_ratio: 1.2, inside: 0.0, ..Default::default() };
        let placement = place(&corner(), &plan, &options, &mut |_| {}).unwrap();
        let points = points_of(&corner()).unwrap();
        let mut region = vec![false; plan.cells().len()];
        for (heading, scale) in candidates(&options, &points, plan.cell_m()).unwrap() {
            let offsets = offsets(&points, heading, scale / plan.cell_m());
            for (index, start) in region.iter_mut().enumerate() {
                let (column, row) = ((index % plan.width()) as i64, (index / plan.width()) as i64);
                let free = |(dx, dy): &(i64, i64)| {
                    let (c, r) = (column + dx, row + dy);
                    let held = c >= 0 && r >= 0 && c < plan.width() as i64 && r < plan.height() as i64;
                    held && plan.cells()[r as usize * plan.width() + c as usize] == Cell::Free
                };
                *start |= offsets.iter().all(free);
            }
        }
        assert!(region.iter().any(|r| *r), "a test that finds nothing tests nothing");
        assert_eq!(placement.start_region, region);
    }

    #[test]
    fn the_true_start_is_in_the_region_and_the_corner_has_one_place() {
        let plan = plan();
        // From the corridor's left end, 5.5 m along it, then left through the gap and up.
        let walk = path(&[(5.5, std::f64::consts::FRAC_PI_2), (2.5, 0.0)]);
        let placement = place(&walk, &plan, &PlaceOptions { heading_rad: Some(0.0), ..Default::default() }, &mut |_| {}).unwrap();
        let (column, row) = plan.cell_at(Pt2::new(0.7, 0.7)).unwrap();
        assert!(placement.start_region[row * plan.width() + column]);
        assert_eq!(placement.modes.len(), 1, "{:?}", placement.modes);
        assert!(placement.modes[0].start.origin().distance(Pt2::new(0.8, 0.75)) < 0.6, "{:?}", placement.modes[0]);
        assert!((placement.modes[0].share - 1.0).abs() < 1e-12);
        let area = placement.start_region.iter().filter(|r| **r).count() as f64 * 0.01;
        assert!((placement.area_m2 - area).abs() < 1e-9);
    }

    #[test]
    fn a_walk_longer_than_the_building_has_no_place() {
        let placement = place(&path(&[(30.0, 0.0)]), &plan(), &PlaceOptions::default(), &mut |_| {}).unwrap();
        assert!(placement.modes.is_empty() && placement.area_m2 == 0.0);
        let scaled = PlaceOptions { scales: (0.05, 1.0), ..Default::default() };
        let placement = place(&path(&[(30.0, 0.0)]), &plan(), &scaled, &mut |_| {}).unwrap();
        assert!(placement.area_m2 > 0.0, "at a small enough scale it fits");
        assert!(placement.modes.iter().all(|m| m.scale < 0.25), "{:?}", placement.modes);
    }

    #[test]
    fn what_cannot_be_tried_is_refused() {
        let run = |path: &Path, scales: (f64, f64)| place(path, &plan(), &PlaceOptions { scales, ..Default::default() }, &mut |_| {});
        assert!(matches!(run(&Path::default(), (1.0, 1.0)), Err(LocateError::EmptyPath { .. })));
        assert!(matches!(run(&path(&[(f64::NAN, 0.0)]), (1.0, 1.0)), Err(LocateError::NotFinite { index: 0 })));
        assert!(matches!(run(&corner(), (2.0, 1.0)), Err(LocateError::BadScaleRange { .. })));
        assert!(matches!(run(&corner(), (f64::NAN, 1.0)), Err(LocateError::BadScaleRange { .. })));
    }

    #[test]
    fn shifted_rows_agree_with_single_bits() {
        let source = [0x8000_0000_0000_0001u64, 0xdead_beef_0123_4567, 0x1];
        for dx in [-130, -65, -64, -63, -1, 0, 1, 63, 64, 65, 130] {
            let mut words = [u64::MAX; 3];
            and_row(&mut words, &source, dx);
            for c in 0..192i64 {
                let bit = |words: &[u64], i: i64| (0..192).contains(&i) && words[i as usize / 64] >> (i % 64) & 1 == 1;
                assert_eq!(bit(&words, c), bit(&source, c + dx), "cell {c} shifted by {dx}");
            }
        }
    }
}

//! From where can this trajectory be walked without hitting a wall? All starts and all ends.
//!
//! perfect trajectory: boxes of headings × scales ──▶ starts that survive their bounds ──▶ ... ──▶ start cells, exactly ──▶ region, modes
//! noisy trajectory:   sets of places, one a heading ──▶ moved, grown by the drift, cut by walls, step by step ──▶ end and start regions
//!
//! This is the localisation by kinematics: placing the trajectory on the map (Chu 2013, section 2.1). 64 cells are tested by one
//! instruction. What cannot fit is skipped only where a bound proves it (`search`), and a trajectory that drifts within the stated
//! [`Tolerance`] is never missed (`drift`).
//! Pitfall: with no tolerance "perfect" is meant; drift of a corridor's half width over the whole path empties the region.

mod bits;
mod drift;
mod modes;
mod search;

use planwalk_types::{Cell, FloorPlan, Path, PlanPose};

use crate::LocateError;
use bits::Bitmap;
use modes::Heaps;
use search::Candidates;

/// How far a trajectory may be from the walk that it measures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tolerance {
    /// Heading drift, radians per √metre: over any stretch of ℓ metres the trajectory's heading error changes by at most this · √ℓ.
    pub drift_rad_per_sqrt_m: f64,
    /// Error of the length of each step, a share of it, on top of the range of scales.
    pub length_error: f64,
}

impl Tolerance {
    /// Whether the trajectory is taken as perfect.
    pub fn is_none(&self) -> bool {
        self.drift_rad_per_sqrt_m == 0.0 && self.length_error == 0.0
    }
}

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
    /// Ratio between the scales that are tried. A perfect trajectory at a scale between two of them may be missed; with a
    /// [`Tolerance`] of any size it is not.
    pub scale_ratio: f64,
    /// How sure a start must be inside the building, 0..=1; 0 admits all free cells.
    pub inside: f64,
    /// Whether the walk may pass over cells that the plan does not know.
    pub through_unknown: bool,
    /// What the trajectory may be off; none by default.
    pub tolerance: Tolerance,
}

impl Default for PlaceOptions {
    /// All headings, metres as they are, a perfect trajectory.
    fn default() -> Self {
        Self {
            heading_rad: None,
            heading_step_rad: 2f64.to_radians(),
            scales: (1.0, 1.0),
            scale_ratio: 1.05,
            inside: 0.5,
            through_unknown: false,
            tolerance: Tolerance::default(),
        }
    }
}

/// A cluster of placements: neighbours in place and heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacementMode {
    /// Mean pose, at the walk's start or end.
    pub pose: PlanPose,
    /// Mean scale, metres per unit of the path.
    pub scale: f64,
    /// Share of all placements (cell, heading, scale) found, 0..=1.
    pub share: f64,
    /// A placement that was found, where many are.
    pub example: PlanPose,
    /// Its scale.
    pub example_scale: f64,
}

/// Every placement of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Cells from which some heading and scale hit no wall; row 0 at the bottom, as the plan's.
    pub start_region: Vec<bool>,
    /// Area of the possible starts, m².
    pub area_m2: f64,
    /// Clusters of starts, most placements first.
    pub modes: Vec<PlacementMode>,
    /// Cells in which it can end.
    pub end_region: Vec<bool>,
    /// Area of the possible ends, m².
    pub end_area_m2: f64,
    /// Clusters of ends, most placements first.
    pub end_modes: Vec<PlacementMode>,
    /// Headings and scales tried.
    pub tried: usize,
}

/// Cells around the plan that are kept empty: windows and steps reach over its edge.
const MARGIN: usize = 8;
/// Most points that a path is sampled at: 100 km at 2.5 cm. Beyond, samples lie farther apart.
const MOST_POINTS: f64 = 4e6;

/// Every start on the plan from which the path hits no wall, and every end. Deterministic; `progress` is told the share done.
///
/// Without [`PlaceOptions::tolerance`] the path is taken to be perfect: starts are cell centres, the path is sampled at half a cell
/// and its points are rounded to cells. With a tolerance no walk within it is missed; more than those walks may be in the regions,
/// the more the larger the tolerance is.
///
/// # Errors
/// [`LocateError`] when the path is empty or not finite, the range of scales holds nothing, or the tolerance is none. No placement
/// is an answer.
pub fn place(path: &Path, plan: &FloorPlan, options: &PlaceOptions, progress: &mut dyn FnMut(f64)) -> Result<Placement, LocateError> {
    let corners = points_of(path)?;
    let Some(scales) = possible_scales(options, &corners, plan)? else { return Ok(Placement::nowhere(plan)) };
    if !options.tolerance.is_none() {
        return drift::place(&corners, plan, options, scales, turn_of(path), progress);
    }
    let candidates = candidates(options, &corners, scales, plan.cell_m());
    let starts = Bitmap::of(plan.width(), plan.height(), MARGIN, |c, r| may_start(plan, options, r * plan.width() + c));
    let free = Bitmap::of(plan.width(), plan.height(), MARGIN, |c, r| may_pass(plan, options, r * plan.width() + c));
    let found = search::all(&candidates, plan, (&starts, free), turn_of(path), progress);
    let tried = candidates.headings.len() * candidates.scales.len();
    Ok(Placement::of(plan, [region(&found.starts, plan), region(&found.ends, plan)], [found.start_heaps, found.end_heaps], tried))
}

impl Placement {
    fn nowhere(plan: &FloorPlan) -> Self {
        let none = vec![false; plan.cells().len()];
        Self::of(plan, [none.clone(), none], [Heaps::new(plan), Heaps::new(plan)], 0)
    }

    fn of(plan: &FloorPlan, [starts, ends]: [Vec<bool>; 2], [start_heaps, end_heaps]: [Heaps; 2], tried: usize) -> Self {
        let area = |region: &[bool]| region.iter().filter(|r| **r).count() as f64 * plan.cell_m() * plan.cell_m();
        Self {
            area_m2: area(&starts),
            modes: start_heaps.modes(plan),
            start_region: starts,
            end_area_m2: area(&ends),
            end_modes: end_heaps.modes(plan),
            end_region: ends,
            tried,
        }
    }
}

fn may_pass(plan: &FloorPlan, options: &PlaceOptions, index: usize) -> bool {
    match plan.cells()[index] {
        Cell::Free | Cell::Door => true,
        Cell::Wall | Cell::Window => false,
        Cell::Unknown => options.through_unknown,
    }
}

fn may_start(plan: &FloorPlan, options: &PlaceOptions, index: usize) -> bool {
    plan.cells()[index].is_floor() && f64::from(plan.inside()[index]) >= options.inside
}

fn region(cells: &Bitmap, plan: &FloorPlan) -> Vec<bool> {
    let mut region = vec![false; plan.cells().len()];
    for (column, row) in cells.cells() {
        region[row * plan.width() + column] = true;
    }
    region
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

/// How much the heading has turned from the path's start to its end, radians.
fn turn_of(path: &Path) -> f64 {
    path.poses().last().map_or(0.0, |pose| pose.heading_rad)
}

/// The scales that are asked for, without those at which the path is wider than the plan; `None` when none are left.
fn possible_scales(options: &PlaceOptions, points: &[(f64, f64)], plan: &FloorPlan) -> Result<Option<(f64, f64)>, LocateError> {
    let (low, high) = options.scales;
    if !(low > 0.0 && high >= low && high.is_finite() && options.scale_ratio.is_finite()) {
        return Err(LocateError::BadScaleRange { low, high });
    }
    let (width, height) = plan.size_m();
    // Drift bends the path: it may then be wider than it is.
    let widest = if options.tolerance.is_none() { reach_of(points) } else { 0.0 };
    let high = if widest > 0.0 { high.min(width.hypot(height) / widest) } else { high };
    Ok((high >= low).then_some((low, high)))
}

/// Distance from the start to the farthest point, in the path's unit.
fn reach_of(points: &[(f64, f64)]) -> f64 {
    points.iter().map(|p| p.0.hypot(p.1)).fold(0.0, f64::max)
}

/// The headings and scales to try, and the points to test.
fn candidates(options: &PlaceOptions, corners: &[(f64, f64)], (low, high): (f64, f64), cell_m: f64) -> Candidates {
    // The farthest point moves by two cells at most from one heading to the next.
    let two_cells = 2.0 * cell_m / (high * reach_of(corners)).max(cell_m);
    // Bounded: 0.1° and 0.1 % are finer than any cell.
    let ratio = options.scale_ratio.max(1.001);
    let steps = (libm::log(high / low) / libm::log(ratio)).ceil().min(10_000.0) as usize;
    let scales = (0..=steps).map(|i| low * libm::pow(high / low, if steps > 0 { i as f64 / steps as f64 } else { 0.0 })).collect();
    let headings = match options.heading_rad {
        Some(heading) => vec![if heading.is_finite() { heading } else { 0.0 }],
        None => {
            let step = options.heading_step_rad.min(two_cells).max(0.1f64.to_radians());
            let count = (std::f64::consts::TAU / step).ceil().max(1.0) as usize;
            (0..count).map(|i| i as f64 * std::f64::consts::TAU / count as f64).collect()
        }
    };
    Candidates { points: samples(corners, 0.5 * cell_m / high), headings, scales }
}

/// Points along the path, at most `spacing` apart, from its start to its end.
fn samples(corners: &[(f64, f64)], spacing: f64) -> Vec<(f64, f64)> {
    let length: f64 = corners.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum();
    let spacing = spacing.max(length / MOST_POINTS);
    let mut points: Vec<(f64, f64)> = corners.first().copied().into_iter().collect();
    for pair in corners.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let count = ((to.0 - from.0).hypot(to.1 - from.1) / spacing).ceil().max(1.0) as usize;
        points.extend((1..=count).map(|i| i as f64 / count as f64).map(|t| (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1))));
    }
    points
}

#[cfg(test)]
mod tests;

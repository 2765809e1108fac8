//! What would be seen from everywhere? The distance to the walls in all directions, for each place of a grid.
//!
//! Distances are kept as the logarithm in a byte: a scale is then a shift, and 16 or 32 places are compared by one instruction.

use planwalk_types::FloorPlan;
use rayon::prelude::*;

use super::{AmbiguityOptions, SCALES};
use crate::walls::Walls;

/// Directions in which distances are kept: 5.6° each.
pub(super) const DIRECTIONS: usize = 64;
/// Rays of a view, to each side of the middle one: ±34°, a phone's usual field of view.
const SIDE_RAYS: usize = 6;
const RAYS: usize = 2 * SIDE_RAYS + 1;
/// Rays that must agree: two may meet what a neighbouring place does not show, such as a door's edge.
const NEEDED: u8 = RAYS as u8 - 2;
/// Rays in the order in which they tell most: far apart first.
const ORDER: [usize; RAYS] = [0, 12, 6, 3, 9, 1, 11, 4, 8, 2, 10, 5, 7];
/// Standard deviations by which a distance may be off.
const SIGMAS: f64 = 2.5;
/// Finest grid of places, metres.
const FINEST_M: f64 = 0.25;
/// Most places of the grid: on larger floors they lie farther apart.
const MOST_PLACES: f64 = 30_000.0;
/// Shortest distance that is told from none, metres.
const NEAR_M: f64 = 0.15;
/// Places compared together.
const BLOCK: usize = 256;
/// No place.
const NONE: u32 = u32::MAX;

/// Distances to the walls from a grid of places inside.
#[derive(Debug)]
pub(super) struct Profiles {
    pitch_m: f64,
    columns: usize,
    rows: usize,
    /// Number of the place at each grid cell, or [`NONE`].
    numbers: Vec<u32>,
    /// Middles of the places, metres from the plan's corner.
    middles: Vec<(f32, f32)>,
    /// Distances by place, then direction.
    by_place: Vec<u8>,
    /// The nearer and the farther of the distances in each direction and the next, by direction, then place.
    nearer: Vec<u8>,
    farther: Vec<u8>,
    steps_per_log: f64,
    options: AmbiguityOptions,
}

/// Rays that do not agree when so many do.
pub(super) fn missed(matched: u8) -> u16 {
    (RAYS as u16).saturating_sub(matched.into())
}

/// What is seen from a pose: distances along the rays, from the right to the left, metres; infinite where no wall is within reach.
#[derive(Debug)]
pub(super) struct View([f64; RAYS]);

/// Lowest and highest distance that agree with a view's rays at some scale.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayBounds([(u8, u8); RAYS]);

fn direction(i: f64) -> f64 {
    i * std::f64::consts::TAU / DIRECTIONS as f64
}

impl View {
    /// What is seen within `reach_m`.
    pub(super) fn from(walls: &Walls, x: f64, y: f64, heading: f64, reach_m: f64) -> Self {
        Self(std::array::from_fn(|ray| {
            let (s, c) = libm::sincos(heading + direction(ray as f64 - SIDE_RAYS as f64));
            let range = f64::from(walls.cast(x as f32, y as f32, c as f32, s as f32, reach_m as f32));
            if range < reach_m { range } else { f64::INFINITY }
        }))
    }
}

impl Profiles {
    /// Looks in all directions from all places.
    pub(super) fn new(plan: &FloorPlan, walls: &Walls, options: &AmbiguityOptions) -> Self {
        let pitch_m = (plan.inside_area_m2() / MOST_PLACES).sqrt().max(FINEST_M).max(plan.cell_m());
        let (width, height) = plan.size_m();
        let (columns, rows) = ((width / pitch_m).ceil() as usize, (height / pitch_m).ceil() as usize);
        let mut numbers = vec![NONE; columns * rows];
        let mut middles = Vec::new();
        for (i, number) in numbers.iter_mut().enumerate() {
            let (x, y) = (((i % columns) as f64 + 0.5) * pitch_m, ((i / columns) as f64 + 0.5) * pitch_m);
            let (column, row) = ((x / plan.cell_m()) as usize, (y / plan.cell_m()) as usize);
            if column < plan.width() && row < plan.height() && plan.inside()[row * plan.width() + column] > 0.5 {
                *number = middles.len() as u32;
                middles.push((x as f32, y as f32));
            }
        }
        // Seen at the largest scale, what is just out of reach is farther away.
        let far_m = options.reach_m * (1.0 + options.scale_spread);
        let steps_per_log = 250.0 / libm::log(far_m / NEAR_M);
        let mut profiles = Self {
            pitch_m,
            columns,
            rows,
            numbers,
            by_place: Vec::new(),
            nearer: Vec::new(),
            farther: Vec::new(),
            middles,
            steps_per_log,
            options: options.clone(),
        };
        profiles.by_place = profiles.middles.par_iter().flat_map_iter(|(x, y)| profiles.looks(walls, (*x, *y), far_m)).collect();
        profiles.by_direction();
        profiles
    }

    fn looks(&self, walls: &Walls, (x, y): (f32, f32), far_m: f64) -> [u8; DIRECTIONS] {
        std::array::from_fn(|i| {
            let (s, c) = libm::sincos(direction(i as f64));
            self.byte(f64::from(walls.cast(x, y, c as f32, s as f32, far_m as f32)))
        })
    }

    fn by_direction(&mut self) {
        let n = self.places();
        let at = |place: usize, i: usize| self.by_place[place * DIRECTIONS + i % DIRECTIONS];
        let pick = |of: fn(u8, u8) -> u8| -> Vec<u8> {
            (0..DIRECTIONS).flat_map(|i| (0..n).map(move |place| of(at(place, i), at(place, i + 1)))).collect()
        };
        (self.nearer, self.farther) = (pick(u8::min), pick(u8::max));
    }

    /// Distance as a byte.
    fn byte(&self, range_m: f64) -> u8 {
        (libm::log(range_m.max(NEAR_M) / NEAR_M) * self.steps_per_log).clamp(0.0, 255.0) as u8
    }

    /// Number of places.
    pub(super) fn places(&self) -> usize {
        self.middles.len()
    }

    /// Distance between neighbouring places, metres.
    pub(super) fn pitch_m(&self) -> f64 {
        self.pitch_m
    }

    /// Scales to try, from 1 − spread to 1 + spread.
    pub(super) fn scales(&self) -> impl Iterator<Item = f64> {
        let (low, whole) = (1.0 - self.options.scale_spread, self.log_spread());
        (0..SCALES).map(move |i| low * libm::exp(whole * (i as f64 + 0.5) / SCALES as f64))
    }

    fn log_spread(&self) -> f64 {
        libm::log((1.0 + self.options.scale_spread) / (1.0 - self.options.scale_spread))
    }

    /// Which distances agree with a view at this scale: within the noise, half the grid's pitch and half a step of scale.
    pub(super) fn bounds(&self, view: &View, scale: f64) -> RayBounds {
        let half_step = 0.5 * self.log_spread() / SCALES as f64;
        RayBounds(view.0.map(|range| {
            let seen = scale * range.min(self.options.reach_m);
            let sigma = self.options.range_sigma_m.hypot(self.options.range_sigma_share * seen);
            let off = SIGMAS * sigma + 0.5 * self.pitch_m + half_step * seen;
            (self.byte(seen - off), if range.is_finite() { self.byte(seen + off).saturating_add(1) } else { u8::MAX })
        }))
    }

    /// Direction just right of the rightmost ray.
    fn first_direction(heading: f64) -> usize {
        let i = (heading / std::f64::consts::TAU * DIRECTIONS as f64).floor() as i64 - SIDE_RAYS as i64;
        i.rem_euclid(DIRECTIONS as i64) as usize
    }

    /// Tells of each place that shows the same when facing `heading`: where it is, and how many rays agree.
    pub(super) fn all_that_show(&self, bounds: &RayBounds, heading: f64, tell: &mut dyn FnMut(f32, f32, u8)) {
        let (n, first) = (self.places(), Self::first_direction(heading));
        let mut counts = [0u8; BLOCK];
        for start in (0..n).step_by(BLOCK) {
            let block = start..(start + BLOCK).min(n);
            let counts = &mut counts[..block.len()];
            counts.fill(0);
            for (k, &ray) in ORDER.iter().enumerate() {
                let line = (first + ray) % DIRECTIONS * n;
                let (low, high) = bounds.0[ray];
                let nearer = &self.nearer[line + block.start..line + block.end];
                let farther = &self.farther[line + block.start..line + block.end];
                for ((count, near), far) in counts.iter_mut().zip(nearer).zip(farther) {
                    *count += u8::from(*near <= high) & u8::from(*far >= low);
                }
                // Nobody here can make up for what disagreed so far.
                if k == 4 && counts.iter().all(|c| usize::from(*c) + RAYS - 5 < usize::from(NEEDED)) {
                    break;
                }
            }
            for (i, count) in counts.iter().enumerate().filter(|(_, count)| **count >= NEEDED) {
                let (x, y) = self.middles[block.start + i];
                tell(x, y, *count);
            }
        }
    }

    /// The place at (x, y), or the best next to it, if it shows the same: where it is, and how many rays agree.
    pub(super) fn best_near(&self, bounds: &RayBounds, x: f32, y: f32, heading: f32) -> Option<(f32, f32, u8)> {
        let (column, row) = ((f64::from(x) / self.pitch_m).floor() as i64, (f64::from(y) / self.pitch_m).floor() as i64);
        let first = Self::first_direction(heading.into());
        if let Some((_, matched)) = self.matched(bounds, column, row, first) {
            return Some((x, y, matched));
        }
        let mut best: Option<(usize, u8)> = None;
        for (dc, dr) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            if let Some(found) = self.matched(bounds, column + dc, row + dr, first)
                && best.is_none_or(|b| found.1 > b.1)
            {
                best = Some(found);
            }
        }
        best.map(|(place, matched)| (self.middles[place].0, self.middles[place].1, matched))
    }

    /// Number of the place at a grid cell, and how many rays agree there, if enough of them do.
    fn matched(&self, bounds: &RayBounds, column: i64, row: i64, first: usize) -> Option<(usize, u8)> {
        if !(0..self.columns as i64).contains(&column) || !(0..self.rows as i64).contains(&row) {
            return None;
        }
        let number = self.numbers[row as usize * self.columns + column as usize];
        if number == NONE {
            return None;
        }
        let place = number as usize;
        let looks = &self.by_place[place * DIRECTIONS..(place + 1) * DIRECTIONS];
        let mut missed = 0;
        for ray in ORDER {
            let (low, high) = bounds.0[ray];
            let (a, b) = (looks[(first + ray) % DIRECTIONS], looks[(first + ray + 1) % DIRECTIONS]);
            missed += u8::from(a.min(b) > high || a.max(b) < low);
            if missed > RAYS as u8 - NEEDED {
                return None;
            }
        }
        Some((place, RAYS as u8 - missed))
    }
}

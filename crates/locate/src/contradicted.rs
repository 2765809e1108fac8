//! Which walls that the plan draws does the walk contradict?
//!
//! polished walk × plan ──▶ walls crossed, with how surely ┐
//! sightings from it  × plan ──▶ walls seen through, again and again ┴──▶ a list in order of the walk
//!
//! Plans lie: a wall planned and not built yet, one torn down, a door drawn as wall. Nothing here changes the answer.
//! Pitfall: a pose a hand's breadth off looks through every door post. So a look through a wall counts only if looks a little
//! beside it go through too, and a wall only if few looks end at it.

use std::collections::BTreeMap;

use planwalk_types::{Cell, Plan, Pt2};

use crate::filter::Localizer;
use crate::likelihood::Ray;
use crate::smooth::Smoothed;

/// Crossings this close to each other are of one wall, metres.
const SAME_M: f64 = 1.0;
/// A crossing is reported when it is at least so sure.
const SURE: f64 = 0.9;
/// How far the walk around a crossing is moved aside in search of a way without one, metres, and in which steps.
const ASIDE_M: f64 = 1.5;
const ASIDE_STEP_M: f64 = 0.05;
/// Side of the pieces of wall on which looks are counted, metres.
const PIECE_M: f64 = 0.5;
/// How far behind a wall a look must end, metres, besides 2.5 of its sigmas; and how far beside it looks must go through too.
const BEHIND_M: f64 = 0.3;
const BESIDE_M: f64 = 0.2;
/// From so many places along the walk, and so many times as often as looks end there, must a wall be seen through.
const PLACES: usize = 4;
const AGAINST_ENDING: usize = 3;

/// How a wall is contradicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContradictedKind {
    /// The walk goes through it.
    Crossed,
    /// What is behind it was seen.
    SeenThrough,
}

/// A drawn wall that the walk contradicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContradictedWall {
    /// How.
    pub kind: ContradictedKind,
    /// Where: the place of the crossing, or the middle of what was seen through.
    pub place: Pt2<Plan>,
    /// Extent of what was seen through, metres; 0 for a crossing.
    pub length_m: f64,
    /// How often the walk goes through.
    pub crossed: usize,
    /// How sure a crossing is, 0..=1: from how far the walk would have to lie aside to pass by, against its doubt.
    pub confidence: f64,
    /// Looks through the wall within half a metre of the place, or through all of what was seen through.
    pub through: usize,
    /// Looks that end at it.
    pub ending: usize,
}

/// The walls that this walk contradicts: `walk` at every generation, `moments` at every moment; both local metres.
pub(crate) fn find(localizer: &Localizer<'_>, walk: &[Smoothed], moments: &[Smoothed]) -> Vec<ContradictedWall> {
    let looks = Looks::gather(localizer, walk);
    let mut all = crossings(localizer, moments, &looks);
    all.extend(looks.seen_through(localizer));
    all
}

fn to_plan(localizer: &Localizer<'_>, x: f64, y: f64) -> Pt2<Plan> {
    Pt2::new(x + localizer.plan.origin().x, y + localizer.plan.origin().y)
}

fn crossings(localizer: &Localizer<'_>, moments: &[Smoothed], looks: &Looks) -> Vec<ContradictedWall> {
    let mut all: Vec<ContradictedWall> = Vec::new();
    for i in 1..moments.len() {
        let (a, b) = (&moments[i - 1].mean, &moments[i].mean);
        if localizer.walls.crossings(a.x as f32, a.y as f32, b.x as f32, b.y as f32) == 0 {
            continue;
        }
        let (x, y) = entry(localizer, (a.x, a.y), (b.x, b.y));
        let place = to_plan(localizer, x, y);
        let confidence = confidence(localizer, moments, i);
        if confidence < SURE {
            continue;
        }
        if let Some(known) = all.iter_mut().find(|w| w.place.distance(place) < SAME_M) {
            known.crossed += 1;
            known.confidence = known.confidence.max(confidence);
            continue;
        }
        let (through, ending) = looks.near(x, y);
        all.push(ContradictedWall { kind: ContradictedKind::Crossed, place, length_m: 0.0, crossed: 1, confidence, through, ending });
    }
    all
}

/// Where the way from `a` to `b` first is in a wall after not being in one; its middle if that is too fine to see.
fn entry(localizer: &Localizer<'_>, a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let length = (b.0 - a.0).hypot(b.1 - a.1);
    let steps = (4.0 * length / localizer.plan.cell_m()).ceil().clamp(1.0, 1e4) as usize;
    let at = |i: usize| {
        let t = i as f64 / steps as f64;
        (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
    };
    let wall = |i: usize| localizer.walls.is_wall(at(i).0 as f32, at(i).1 as f32);
    (1..=steps).find(|i| wall(*i) && !wall(*i - 1)).map_or_else(|| at(steps / 2), at)
}

/// How surely the walk crosses between moments `i − 1` and `i`: moved aside as a piece, by how many sigmas must it go to pass by?
fn confidence(localizer: &Localizer<'_>, moments: &[Smoothed], i: usize) -> f64 {
    let here = &moments[i].mean;
    let near = |s: &Smoothed| (s.mean.x - here.x).hypot(s.mean.y - here.y) < SAME_M;
    let first = (0..i).rev().find(|k| !near(&moments[*k])).unwrap_or(0);
    let last = (i..moments.len()).find(|k| !near(&moments[*k])).unwrap_or(moments.len() - 1);
    let piece = &moments[first..=last];
    let passes = |dx: f64, dy: f64| {
        piece.windows(2).all(|w| {
            let [x0, y0, x1, y1] = [w[0].mean.x + dx, w[0].mean.y + dy, w[1].mean.x + dx, w[1].mean.y + dy].map(|v| v as f32);
            localizer.walls.crossings(x0, y0, x1, y1) == 0
        })
    };
    let covariance = &moments[i].covariance;
    let mut sure: f64 = 1.0;
    for direction in 0..16 {
        let (s, c) = libm::sincos(f64::from(direction) * std::f64::consts::TAU / 16.0);
        let variance = c * c * covariance[(0, 0)] + 2.0 * s * c * covariance[(0, 1)] + s * s * covariance[(1, 1)];
        let sigma = variance.max(1e-6).sqrt();
        let steps = (ASIDE_M / ASIDE_STEP_M) as usize;
        if let Some(k) = (1..=steps).find(|k| passes(ASIDE_STEP_M * *k as f64 * c, ASIDE_STEP_M * *k as f64 * s)) {
            sure = sure.min(libm::erf(ASIDE_STEP_M * k as f64 / sigma / std::f64::consts::SQRT_2));
        }
    }
    sure
}

/// What became of the looks at a piece of wall.
#[derive(Debug, Clone, Copy)]
struct Piece {
    through: usize,
    ending: usize,
    /// Places along the walk from which it was seen through, and the last of them.
    places: usize,
    last: usize,
    sum: (f64, f64),
    low: (f64, f64),
    high: (f64, f64),
}

impl Default for Piece {
    fn default() -> Self {
        let inf = f64::INFINITY;
        Self { through: 0, ending: 0, places: 0, last: usize::MAX, sum: (0.0, 0.0), low: (inf, inf), high: (-inf, -inf) }
    }
}

/// Looks, counted by pieces of wall.
#[derive(Debug, Default)]
struct Looks {
    pieces: BTreeMap<(i64, i64), Piece>,
}

impl Looks {
    fn key(x: f64, y: f64) -> (i64, i64) {
        ((x / PIECE_M).floor() as i64, (y / PIECE_M).floor() as i64)
    }

    fn gather(localizer: &Localizer<'_>, walk: &[Smoothed]) -> Self {
        let mut looks = Self::default();
        for (g, (generation, at)) in localizer.history.generations.iter().zip(walk).enumerate() {
            for ray in &generation.rays {
                looks.add(localizer, g, ray, at);
            }
        }
        looks
    }

    fn add(&mut self, localizer: &Localizer<'_>, generation: usize, ray: &Ray, at: &Smoothed) {
        let scale = libm::exp(at.log_scale);
        let (s, c) = libm::sincos(at.mean.z);
        let turned = |(x, y): (f64, f64)| (at.mean.x + scale * (c * x - s * y), at.mean.y + scale * (s * x + c * y));
        let (eye, end) = (turned(ray.from), turned(ray.to));
        let range = (end.0 - eye.0).hypot(end.1 - eye.1).max(1e-9);
        let (dx, dy) = ((end.0 - eye.0) / range, (end.1 - eye.1) / range);
        let sigma = localizer.options.sightings.wall_sigma_m.hypot(scale * ray.sigma);
        let cast = |aside: f64, limit: f64| {
            let (x, y) = (eye.0 - aside * dy, eye.1 + aside * dx);
            f64::from(localizer.walls.cast(x as f32, y as f32, dx as f32, dy as f32, limit as f32))
        };
        let limit = range + 2.0 * sigma + localizer.plan.cell_m();
        let met = cast(0.0, limit);
        let air = range - 2.5 * sigma - BEHIND_M;
        if met >= air {
            if met < limit && met > range - 2.5 * sigma {
                self.pieces.entry(Self::key(eye.0 + met * dx, eye.1 + met * dy)).or_default().ending += 1;
            }
            return;
        }
        let beside = [BESIDE_M, -BESIDE_M].iter().all(|aside| cast(*aside, air) < air);
        // Into the wall by half a cell: on its face a hair decides which piece it is.
        let (x, y) = (eye.0 + (met + 0.5 * localizer.plan.cell_m()) * dx, eye.1 + (met + 0.5 * localizer.plan.cell_m()) * dy);
        if !beside || localizer.plan.at(to_plan(localizer, x, y)) == Cell::Window {
            return;
        }
        let piece = self.pieces.entry(Self::key(x, y)).or_default();
        piece.through += 1;
        piece.places += usize::from(piece.last != generation);
        piece.last = generation;
        piece.sum = (piece.sum.0 + x, piece.sum.1 + y);
        piece.low = (piece.low.0.min(x), piece.low.1.min(y));
        piece.high = (piece.high.0.max(x), piece.high.1.max(y));
    }

    /// Looks through and ending within about half a metre.
    fn near(&self, x: f64, y: f64) -> (usize, usize) {
        let (column, row) = Self::key(x, y);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (column + i, row + j)));
        around.filter_map(|key| self.pieces.get(&key)).fold((0, 0), |sum, p| (sum.0 + p.through, sum.1 + p.ending))
    }

    /// Neighbouring pieces that are seen through and at which little ends, joined.
    fn seen_through(&self, localizer: &Localizer<'_>) -> Vec<ContradictedWall> {
        let mut open: BTreeMap<(i64, i64), Piece> =
            self.pieces.iter().filter(|(_, p)| p.through > AGAINST_ENDING * p.ending && p.places > 0).map(|(k, p)| (*k, *p)).collect();
        let mut all = Vec::new();
        while let Some((key, piece)) = open.pop_first() {
            let (mut whole, mut edge) = (piece, vec![key]);
            let mut most_places = piece.places;
            while let Some((column, row)) = edge.pop() {
                for next in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (column + i, row + j))) {
                    let Some(p) = open.remove(&next) else { continue };
                    whole.through += p.through;
                    whole.ending += p.ending;
                    most_places = most_places.max(p.places);
                    whole.sum = (whole.sum.0 + p.sum.0, whole.sum.1 + p.sum.1);
                    whole.low = (whole.low.0.min(p.low.0), whole.low.1.min(p.low.1));
                    whole.high = (whole.high.0.max(p.high.0), whole.high.1.max(p.high.1));
                    edge.push(next);
                }
            }
            if most_places < PLACES {
                continue;
            }
            let place = to_plan(localizer, whole.sum.0 / whole.through as f64, whole.sum.1 / whole.through as f64);
            let length_m = (whole.high.0 - whole.low.0).hypot(whole.high.1 - whole.low.1);
            let (through, ending) = (whole.through, whole.ending);
            all.push(ContradictedWall {
                kind: ContradictedKind::SeenThrough,
                place,
                length_m,
                crossed: 0,
                confidence: 1.0,
                through,
                ending,
            });
        }
        // Most seen through first; among equals the order of the grid.
        all.sort_by_key(|w| std::cmp::Reverse(w.through));
        all
    }
}

//! Which of the ink are doors that stand open? A leaf, straight from its hinge, and the quarter of a circle that its end draws.
//!
//! ink ─▶ grid of a few centimetres ─▶ leaves: straight runs that end at a door's width ─▶ those with a quarter circle to one side
//!
//! The opening lies a quarter turn from the leaf, on the side of the circle. Angles are in the picture's sense, y down.
//! Pitfall: a leaf that lies on a wall ends nowhere, and a circle alone is a round room's wall: both are left as they are.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::blobs::for_runs;

/// Leaves are this wide, metres.
const LEAF_M: std::ops::RangeInclusive<f64> = 0.5..=1.4;
/// Cells of the grid that doors are looked for on, metres: a leaf has 15 or more.
const GRID_M: f64 = 0.035;
/// A leaf has at least this many cells: a quarter circle of fewer is a corner cut off.
const LEAST_CELLS: f64 = 11.0;
/// Leaves and their circles are lines no thicker than this, metres, or this many cells; walls and pillars are.
const THICKEST: (f64, f64) = (0.15, 3.0);
/// Pixels larger than this show no quarter circle, metres.
const COARSEST_M: f64 = 0.1;
/// Directions that leaves are looked for in: at a leaf's end, the nearest is within a cell and a half.
const DIRECTIONS: usize = 64;
/// Share of the quarter circle that must be drawn, and drawn as a line whose middle keeps to it.
const ARC_DRAWN: (f64, f64) = (0.9, 0.7);
/// The middle of the circle's line is no farther off it than this, cells.
const OFF_CIRCLE: f64 = 1.0;
/// Share of the ground between leaf and circle that may be ink: a number on the door.
const GROUND_DRAWN: f64 = 0.12;
/// What is drawn across the opening is no thicker than this, metres: a sill, or the face of the wall.
const SILL_M: f64 = 0.16;
/// Most ink cells that are looked at; sheets with more are hatched all over.
const CELL_LIMIT: usize = 3_000_000;

/// A door that stands open, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Swing {
    /// About which it turns.
    pub hinge: [f64; 2],
    /// Length of the leaf.
    pub radius: f64,
    /// Direction of the leaf, radians, y down.
    pub leaf_rad: f64,
    /// A quarter turn from the leaf towards the opening: +1 or −1.
    pub side: f64,
    /// Half the thickness of what is drawn.
    pub half_stroke: f64,
}

impl Swing {
    /// Direction of the opening from the hinge.
    fn opening_rad(&self) -> f64 {
        self.leaf_rad + self.side * FRAC_PI_2
    }

    /// What a pixel is: the leaf or the circle (`true`), the opening (`false`), or neither.
    fn part(&self, at: [f64; 2], sill_px: f64) -> Option<bool> {
        let to = [at[0] - self.hinge[0], at[1] - self.hinge[1]];
        let in_frame = |rad: f64| {
            let (s, c) = libm::sincos(rad);
            [c * to[0] + s * to[1], c * to[1] - s * to[0]]
        };
        let reach = self.half_stroke + 1.0;
        let [along, across] = in_frame(self.opening_rad());
        if (0.08 * self.radius..0.95 * self.radius).contains(&along) && across.abs() <= sill_px {
            return Some(false);
        }
        let [along, across] = in_frame(self.leaf_rad);
        let is_leaf = (sill_px.max(reach)..self.radius + reach).contains(&along) && across.abs() <= reach;
        let from_leaf = libm::atan2(self.side * across, along);
        let off = (libm::hypot(to[0], to[1]) - self.radius).abs();
        // The last degrees of the circle touch the jamb.
        let is_arc = off <= reach + 0.02 * self.radius && from_leaf > -0.1 && from_leaf * self.radius < FRAC_PI_2 * self.radius - sill_px;
        (is_leaf || is_arc).then_some(true)
    }

    /// Calls `found` with each pixel of it, and whether it is drawn (leaf and circle) or open.
    pub fn for_pixels(&self, size: [usize; 2], metres_per_pixel: f64, mut found: impl FnMut(usize, bool)) {
        let sill_px = (0.5 * SILL_M / metres_per_pixel).max(1.0);
        let reach = self.radius + self.half_stroke + 2.0;
        let span = |k: usize| {
            let low = (self.hinge[k] - reach).max(0.0) as usize;
            low..((self.hinge[k] + reach).max(0.0) as usize + 1).min(size[k])
        };
        for v in span(1) {
            for u in span(0) {
                if let Some(drawn) = self.part([u as f64 + 0.5, v as f64 + 0.5], sill_px) {
                    found(v * size[0] + u, drawn);
                }
            }
        }
    }
}

/// All doors that stand open.
pub(super) fn swings(is_ink: &[bool], width: usize, metres_per_pixel: f64) -> Vec<Swing> {
    if metres_per_pixel > COARSEST_M || width == 0 {
        return Vec::new();
    }
    let grid = Grid::of(is_ink, width, (GRID_M / metres_per_pixel).floor().max(1.0) as usize);
    let cell_m = metres_per_pixel * grid.block as f64;
    if grid.places.len() > CELL_LIMIT {
        return Vec::new();
    }
    let (least, most) = ((LEAF_M.start() / cell_m).max(LEAST_CELLS), LEAF_M.end() / cell_m);
    let thickest = THICKEST.1.max(THICKEST.0 / cell_m);
    let is_thin = grid.thin(thickest as usize);
    let ways: Vec<[f64; 2]> = (0..DIRECTIONS).map(|i| TAU * i as f64 / DIRECTIONS as f64).map(|a| [libm::cos(a), libm::sin(a)]).collect();
    let mut found: Vec<(f64, Swing)> = Vec::new();
    for place in grid.places.iter().filter(|place| grid.is_at_border(**place, thickest as usize)) {
        let hinge = [(place % grid.width) as f64 + 0.5, (place / grid.width) as f64 + 0.5];
        for (i, way) in ways.iter().enumerate() {
            let Some(length) = grid.leaf(hinge, *way, &is_thin, least..most) else { continue };
            if !grid.is_free_beside(hinge, *way, length, thickest) {
                continue;
            }
            for side in [1.0, -1.0] {
                found.extend(grid.quarter(hinge, *way, side, length).map(|(drawn, radius)| {
                    let leaf_rad = TAU * i as f64 / DIRECTIONS as f64;
                    (drawn, Swing { hinge, radius, leaf_rad, side, half_stroke: 1.0 })
                }));
            }
        }
    }
    best(found).into_iter().map(|swing| grid.in_pixels(swing)).collect()
}

/// The best of those that overlap.
fn best(mut found: Vec<(f64, Swing)>) -> Vec<Swing> {
    let key = |s: &Swing| (s.hinge[1], s.hinge[0], s.leaf_rad, s.side);
    found.sort_by(|(a, one), (b, other)| {
        let order = |x: &Swing, y: &Swing| key(x).partial_cmp(&key(y)).unwrap_or(std::cmp::Ordering::Equal);
        b.total_cmp(a).then_with(|| order(one, other))
    });
    let mut kept: Vec<Swing> = Vec::new();
    for (_, swing) in found {
        let middle = |s: &Swing| {
            let way = s.leaf_rad + 0.5 * s.side * FRAC_PI_2;
            [s.hinge[0] + 0.6 * s.radius * libm::cos(way), s.hinge[1] + 0.6 * s.radius * libm::sin(way)]
        };
        let [x, y] = middle(&swing);
        if kept.iter().all(|other| libm::hypot(middle(other)[0] - x, middle(other)[1] - y) > 0.5 * swing.radius) {
            kept.push(swing);
        }
    }
    kept
}

/// Ink on cells of some pixels.
struct Grid {
    width: usize,
    height: usize,
    block: usize,
    is_ink: Vec<bool>,
    /// Cells that are ink.
    places: Vec<usize>,
}

impl Grid {
    /// A cell is ink if a pixel of it is: thin lines stay whole.
    fn of(pixels: &[bool], width_px: usize, block: usize) -> Self {
        let (width, height) = (width_px.div_ceil(block), (pixels.len() / width_px).div_ceil(block));
        let mut is_ink = vec![false; width * height];
        for (v, row) in pixels.chunks(width_px).enumerate() {
            for (cell, pixels) in is_ink[v / block * width..].iter_mut().zip(row.chunks(block)) {
                *cell |= pixels.contains(&true);
            }
        }
        let places = (0..is_ink.len()).filter(|i| is_ink[*i]).collect();
        Self { width, height, block, is_ink, places }
    }

    fn has_ink(&self, x: f64, y: f64) -> bool {
        x >= 0.0 && y >= 0.0 && (x as usize) < self.width && (y as usize) < self.height && self.is_ink[y as usize * self.width + x as usize]
    }

    /// Ink that is no thicker than this along rows or columns.
    fn thin(&self, thickest: usize) -> Vec<bool> {
        let mut is_thin = vec![false; self.is_ink.len()];
        for row in 0..self.height {
            let start = row * self.width;
            for_runs(self.width, |u| self.is_ink[start + u], |run| is_thin[start + run.start..start + run.end].fill(run.len() <= thickest));
        }
        for column in 0..self.width {
            let place = |v: usize| v * self.width + column;
            let fill = |run: std::ops::Range<usize>| {
                if run.len() <= thickest {
                    run.for_each(|v| is_thin[place(v)] = true);
                }
            };
            for_runs(self.height, |v| self.is_ink[place(v)], fill);
        }
        is_thin
    }

    /// Whether paper is within some cells: hinges are not deep in a wall.
    fn is_at_border(&self, place: usize, reach: usize) -> bool {
        let (u, v) = (place % self.width, place / self.width);
        let span = |at: usize, end: usize| [at.saturating_sub(reach), at, (at + reach).min(end - 1)];
        span(v, self.height).iter().any(|v| span(u, self.width).iter().any(|u| !self.is_ink[v * self.width + u]))
    }

    /// Whether the leaf is a line by itself: paper on both sides of its outer half.
    fn is_free_beside(&self, hinge: [f64; 2], way: [f64; 2], length: f64, thickest: f64) -> bool {
        let off = (0.15 * length).max(thickest);
        let is_paper =
            |along: f64, aside: f64| !self.has_ink(hinge[0] + along * way[0] - aside * way[1], hinge[1] + along * way[1] + aside * way[0]);
        let sides = [0.4, 0.55, 0.7].map(|part| [is_paper(part * length, off), is_paper(part * length, -off)]);
        (0..2).all(|side| sides.iter().filter(|s| s[side]).count() >= 2)
    }

    /// Whether the circle is a line by itself: paper outside it.
    fn is_line(&self, at: &impl Fn(f64, f64) -> bool, radius: f64) -> bool {
        let outside = 1.15 * radius + 2.0;
        [0.3, 0.45, 0.6, 0.75].iter().filter(|part| !at(outside, **part * FRAC_PI_2)).count() >= 3
    }

    /// Length of the straight run of thin ink from here, if it ends within these lengths.
    fn leaf(&self, from: [f64; 2], way: [f64; 2], is_thin: &[bool], lengths: std::ops::Range<f64>) -> Option<f64> {
        let (least, most) = (lengths.start, lengths.end);
        let at = |d: f64| self.has_ink(from[0] + d * way[0], from[1] + d * way[1]);
        let thin_at = |d: f64| {
            let (x, y) = (from[0] + d * way[0], from[1] + d * way[1]);
            self.has_ink(x, y) && is_thin[y as usize * self.width + x as usize]
        };
        // Most places fail here.
        if !thin_at(0.5 * least) || !thin_at(0.8 * least) || !at(0.25 * least) {
            return None;
        }
        let (mut length, mut missed) = (0.0, 0);
        while missed < 2 {
            if at(length + 1.0) {
                missed = 0
            } else {
                missed += 1
            }
            length += 1.0;
            if length > most + 3.0 {
                return None;
            }
        }
        let length = length - 2.0;
        (length >= least && length <= most + 2.0).then_some(length)
    }

    /// Share of the quarter circle that is drawn, and its radius, if it is a door's.
    fn quarter(&self, hinge: [f64; 2], way: [f64; 2], side: f64, length: f64) -> Option<(f64, f64)> {
        // A quarter turn to the side.
        let aside = [-side * way[1], side * way[0]];
        let at = |radius: f64, rad: f64| {
            let (s, c) = libm::sincos(rad);
            self.has_ink(hinge[0] + radius * (c * way[0] + s * aside[0]), hinge[1] + radius * (c * way[1] + s * aside[1]))
        };
        let is_drawn = |radius: f64, rad: f64| at(radius, rad) || at(radius - 1.0, rad) || at(radius + 1.0, rad);
        let mut found: Option<(f64, f64)> = None;
        for radius in [length, length - 1.0, length - 2.0] {
            if ![0.5, 0.25, 0.75].iter().all(|part| is_drawn(radius, part * FRAC_PI_2)) {
                continue;
            }
            let count = (radius * FRAC_PI_2).ceil();
            let share = |of: &dyn Fn(f64) -> bool| {
                (0..=count as usize).filter(|i| of(*i as f64 / count * FRAC_PI_2)).count() as f64 / (count + 1.0)
            };
            let drawn = share(&|rad| is_drawn(radius, rad));
            // A straight wall aslant is a chord, off the circle by more than a fifth of its radius: the line's middle must keep to it.
            let exact = share(&|rad| self.middle(&at, radius, rad).is_some_and(|off| off.abs() <= OFF_CIRCLE));
            if drawn >= ARC_DRAWN.0
                && exact >= ARC_DRAWN.1
                && self.is_line(&at, radius)
                && self.is_in_wall(hinge, way, aside, radius)
                && self.ground_is_empty(&at, radius)
                && found.is_none_or(|(best, _)| exact > best)
            {
                found = Some((exact, radius));
            }
        }
        found
    }

    /// How far from the circle the middle of the line is that crosses it here; `None` where it is no line.
    fn middle(&self, at: &impl Fn(f64, f64) -> bool, radius: f64, rad: f64) -> Option<f64> {
        let nearest = [0.0, 1.0, -1.0].into_iter().find(|off| at(radius + off, rad))?;
        let end = |way: f64| (1..=6).map(|i| nearest + way * f64::from(i)).find(|off| !at(radius + off, rad));
        Some(0.5 * (end(1.0)? + end(-1.0)?))
    }

    /// Whether walls go on from both ends of the opening: behind the hinge, and beyond the jamb.
    fn is_in_wall(&self, hinge: [f64; 2], way: [f64; 2], aside: [f64; 2], radius: f64) -> bool {
        let wall_at = |along: f64| {
            (-3..=3).any(|off| {
                self.has_ink(hinge[0] + along * aside[0] + f64::from(off) * way[0], hinge[1] + along * aside[1] + f64::from(off) * way[1])
            })
        };
        let goes_on = |from: f64, step: f64| (0..2).all(|i| wall_at(from + step * f64::from(i)));
        goes_on(-2.0, -1.0) && goes_on(radius + 2.0, 1.0)
    }

    /// Whether little is drawn between leaf, circle and opening.
    fn ground_is_empty(&self, at: &impl Fn(f64, f64) -> bool, radius: f64) -> bool {
        let (mut ink, mut all) = (0.0, 0.0);
        for part in [0.3, 0.45, 0.6, 0.75] {
            for step in 1..=9 {
                all += 1.0;
                ink += f64::from(u8::from(at(part * radius, (0.15 + 0.07 * f64::from(step)) * FRAC_PI_2)));
            }
        }
        ink <= GROUND_DRAWN * all
    }

    fn in_pixels(&self, swing: Swing) -> Swing {
        let block = self.block as f64;
        Swing { hinge: swing.hinge.map(|v| v * block), radius: swing.radius * block, half_stroke: swing.half_stroke * block, ..swing }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 200;

    /// A wall with an opening of `gap` px, a leaf that stands open upwards, turned by `rad` about the middle; a pixel is 4 cm.
    fn drawn(gap: f64, rad: f64, has_arc: bool) -> Vec<bool> {
        let (s, c) = rad.sin_cos();
        let is = |i: usize| {
            let (u, v) = ((i % W) as f64 + 0.5 - 100.0, (i / W) as f64 + 0.5 - 100.0);
            let (x, y) = (c * u + s * v, c * v - s * u);
            let is_wall = y.abs() <= 2.0 && x.abs() < 80.0 && !(0.0..gap).contains(&x);
            let is_leaf = (x + 0.5).abs() <= 1.0 && (-gap..0.0).contains(&y);
            let is_arc = has_arc && (x.hypot(y) - gap).abs() <= 0.8 && x >= 0.0 && y <= 0.0;
            is_wall || is_leaf || is_arc
        };
        (0..W * W).map(is).collect()
    }

    #[test]
    fn a_door_that_stands_open_is_found_at_any_angle_and_opened() {
        for rad in [0.0, 0.3, 1.0, 2.0, 4.5] {
            let mut ink = drawn(22.0, rad, true);
            let found = swings(&ink, W, 0.04);
            assert_eq!(found.len(), 1, "turned by {rad}: {found:?}");
            let swing = found[0];
            assert!((swing.hinge[0] - 100.0).hypot(swing.hinge[1] - 100.0) < 3.5 && (swing.radius - 22.0).abs() < 3.0, "{swing:?}");
            // The way through is free: from one side of the wall to the other through the opening's middle.
            let mut is_open = vec![false; ink.len()];
            swing.for_pixels([W, W], 0.04, |place, is_drawn| {
                ink[place] = false;
                is_open[place] |= !is_drawn;
            });
            let (s, c) = rad.sin_cos();
            let place = |x: f64, y: f64| (100.0 + s * x + c * y) as usize * W + (100.0 + c * x - s * y) as usize;
            for y in -30..30 {
                assert!(!ink[place(11.0, f64::from(y))], "turned by {rad}: ink at {y}");
            }
            assert!((-4..4).any(|y| is_open[place(11.0, f64::from(y))]), "turned by {rad}: the opening is told");
            assert!(ink[place(-20.0, 0.0)] && ink[place(50.0, 0.0)], "turned by {rad}: the wall stays");
        }
    }

    #[test]
    fn a_leaf_without_its_circle_is_a_wall_and_so_is_a_gate_of_three_metres() {
        assert!(swings(&drawn(22.0, 0.0, false), W, 0.04).is_empty());
        assert!(swings(&drawn(70.0, 0.0, true), W, 0.04).is_empty());
        assert!(swings(&drawn(22.0, 0.0, true), W, 0.3).is_empty(), "too coarse");
    }
}

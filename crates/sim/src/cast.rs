//! How far is the first wall in this direction? Lines by squares of a grid, so that a floor of thousands of them costs no more
//! than a room.
//!
//! A ray walks from square to square (Amanatides & Woo 1987) and meets the lines of each; it ends in the first square that holds
//! a hit.

use planwalk_types::{Plan, Pt2, Wall};

/// Side of a square, metres: a ray of an ordinary room passes a handful, and each holds a handful of lines.
const SQUARE_M: f64 = 1.0;
/// Most squares; sides grow on sites where it takes more.
const SQUARES_MAX: f64 = 1e6;

/// Lines that rays meet.
#[derive(Debug, Clone)]
pub(crate) struct Caster {
    walls: Vec<Wall>,
    low: [f64; 2],
    side_m: f64,
    size: [usize; 2],
    /// Lines that touch each square.
    squares: Vec<Vec<u32>>,
}

impl Caster {
    pub fn new(walls: &[Wall]) -> Self {
        let walls: Vec<Wall> =
            walls.iter().copied().filter(|w| [w.from.x, w.from.y, w.to.x, w.to.y].iter().all(|v| v.is_finite())).collect();
        let ends = || walls.iter().flat_map(|w| [[w.from.x, w.from.y], [w.to.x, w.to.y]]);
        let low = ends().fold([f64::INFINITY; 2], |l, p| [l[0].min(p[0]), l[1].min(p[1])]);
        let high = ends().fold([f64::NEG_INFINITY; 2], |h, p| [h[0].max(p[0]), h[1].max(p[1])]);
        if walls.is_empty() {
            return Self { walls, low: [0.0; 2], side_m: SQUARE_M, size: [0; 2], squares: Vec::new() };
        }
        // A hair of slack, so that lines on the border have a square.
        let low = [low[0] - 1e-3, low[1] - 1e-3];
        let span = [high[0] - low[0] + 1e-3, high[1] - low[1] + 1e-3];
        let side_m = SQUARE_M.max((span[0] * span[1] / SQUARES_MAX).sqrt());
        let size = [(span[0] / side_m) as usize + 1, (span[1] / side_m) as usize + 1];
        let mut caster = Self { walls, low, side_m, size, squares: vec![Vec::new(); size[0] * size[1]] };
        for index in 0..caster.walls.len() {
            caster.enter(index);
        }
        caster
    }

    /// Writes a line into every square that it may touch: those of its bounding box whose middle is near it.
    fn enter(&mut self, index: usize) {
        let Wall { from, to } = self.walls[index];
        let square = |v: f64, axis: usize| (((v - self.low[axis]) / self.side_m) as usize).min(self.size[axis] - 1);
        // Half of a square's diagonal, and round-off.
        let reach_m = 0.5 * self.side_m * std::f64::consts::SQRT_2 + 1e-6;
        for row in square(from.y.min(to.y), 1)..=square(from.y.max(to.y), 1) {
            for column in square(from.x.min(to.x), 0)..=square(from.x.max(to.x), 0) {
                let middle = Pt2::new(self.low[0] + (column as f64 + 0.5) * self.side_m, self.low[1] + (row as f64 + 0.5) * self.side_m);
                if crate::building::distance_to_wall(middle, &Wall { from, to }) <= reach_m {
                    self.squares[row * self.size[0] + column].push(index as u32);
                }
            }
        }
    }

    /// Metres to the first line; infinite where none is nearer than `limit_m`.
    pub fn range_m(&self, from: Pt2<Plan>, heading_rad: f64, limit_m: f64) -> f64 {
        let (s, c) = libm::sincos(heading_rad);
        let direction = [c, s];
        let start = [from.x - self.low[0], from.y - self.low[1]];
        // Where the ray is within the grid.
        let (mut enter, mut leave) = (0.0, limit_m);
        for axis in 0..2 {
            let span = self.size[axis] as f64 * self.side_m;
            if direction[axis].abs() < 1e-12 {
                if !(start[axis] >= 0.0 && start[axis] < span) {
                    return f64::INFINITY;
                }
                continue;
            }
            let (one, other) = (-start[axis] / direction[axis], (span - start[axis]) / direction[axis]);
            enter = f64::max(enter, one.min(other));
            leave = f64::min(leave, one.max(other));
        }
        // Also false where anything is not a number.
        if !(enter < leave) {
            return f64::INFINITY;
        }
        self.walk(from, direction, start, enter, leave).filter(|range| *range <= limit_m).unwrap_or(f64::INFINITY)
    }

    fn walk(&self, from: Pt2<Plan>, direction: [f64; 2], start: [f64; 2], enter: f64, leave: f64) -> Option<f64> {
        let place = [0, 1].map(|axis| start[axis] + enter * direction[axis]);
        let mut square = [0, 1].map(|axis| ((place[axis] / self.side_m).max(0.0) as usize).min(self.size[axis] - 1));
        // Distance along the ray to the next border on each axis, and between borders.
        let every = direction.map(|d| self.side_m / d.abs().max(1e-300));
        let mut next = [0, 1].map(|axis| {
            let border = if direction[axis] > 0.0 { (square[axis] + 1) as f64 } else { square[axis] as f64 } * self.side_m;
            if direction[axis].abs() < 1e-12 { f64::INFINITY } else { (border - start[axis]) / direction[axis] }
        });
        loop {
            let end = next[0].min(next[1]);
            let lines = &self.squares[square[1] * self.size[0] + square[0]];
            let hit = lines.iter().map(|i| meet(from, direction, &self.walls[*i as usize])).fold(f64::INFINITY, f64::min);
            // A hit beyond this square may be beaten by one in a square before it.
            if hit <= end + 1e-9 {
                return Some(hit);
            }
            if end > leave {
                return None;
            }
            let axis = usize::from(next[1] < next[0]);
            square[axis] = square[axis].checked_add_signed(if direction[axis] > 0.0 { 1 } else { -1 })?;
            if square[axis] >= self.size[axis] {
                return None;
            }
            next[axis] += every[axis];
        }
    }
}

/// Distance along a ray to a line; infinite where they do not meet.
fn meet(from: Pt2<Plan>, [c, s]: [f64; 2], wall: &Wall) -> f64 {
    let (ex, ey) = (wall.to.x - wall.from.x, wall.to.y - wall.from.y);
    let (ax, ay) = (wall.from.x - from.x, wall.from.y - from.y);
    let det = ex * s - ey * c;
    let (range, along) = ((ex * ay - ey * ax) / det, (c * ay - s * ax) / det);
    // A ray along the wall gives NaN, and NaN is in no range.
    if range > 0.0 && (0.0..=1.0).contains(&along) { range } else { f64::INFINITY }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use planwalk_types::Seed;
    use rand::RngExt;

    /// A room of 4 m × 2 m around the origin.
    pub(crate) fn room() -> Vec<Wall> {
        let corners = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)].map(|(x, y)| Pt2::new(x, y));
        (0..4).map(|i| Wall { from: corners[i], to: corners[(i + 1) % 4] }).collect()
    }

    #[test]
    fn a_ray_ends_at_the_first_wall() {
        let walls = Caster::new(&room());
        let from = Pt2::new(0.5, 0.0);
        for (heading, range) in
            [(0.0, 1.5), (std::f64::consts::FRAC_PI_2, 1.0), (std::f64::consts::PI, 2.5), (-0.5 * std::f64::consts::PI, 1.0)]
        {
            assert!((walls.range_m(from, heading, 100.0) - range).abs() < 1e-12);
        }
        assert_eq!(walls.range_m(from, 0.0, 1.0), f64::INFINITY, "farther than asked for");
        assert_eq!(Caster::new(&[]).range_m(from, 0.3, 9.0), f64::INFINITY);
    }

    #[test]
    fn the_grid_agrees_with_trying_every_line() {
        let mut rng = Seed(6).derive("test", 0);
        let walls: Vec<Wall> = (0..300)
            .map(|_| {
                let from = Pt2::new(rng.random_range(-20.0..20.0), rng.random_range(0.0..30.0));
                let to = Pt2::new(from.x + rng.random_range(-4.0..4.0), from.y + rng.random_range(-4.0..4.0));
                Wall { from, to }
            })
            .collect();
        let caster = Caster::new(&walls);
        for _ in 0..5000 {
            let from = Pt2::new(rng.random_range(-30.0..30.0), rng.random_range(-10.0..40.0));
            let heading: f64 = rng.random_range(-4.0..4.0);
            let (s, c) = libm::sincos(heading);
            let slow = walls.iter().map(|w| meet(from, [c, s], w)).fold(f64::INFINITY, f64::min);
            let slow = if slow <= 25.0 { slow } else { f64::INFINITY };
            // The same arithmetic on the same line: equal to the bit.
            assert_eq!(caster.range_m(from, heading, 25.0), slow, "from {from:?} towards {heading}");
        }
    }

    #[test]
    fn a_degenerate_wall_is_not_seen_and_a_broken_one_not_kept() {
        let point = Pt2::new(1.0, 0.0);
        let broken = Wall { from: point, to: Pt2::new(f64::NAN, 0.0) };
        assert_eq!(Caster::new(&[Wall { from: point, to: point }, broken]).range_m(Pt2::new(0.0, 0.0), 0.0, 9.0), f64::INFINITY);
    }
}

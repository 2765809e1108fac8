//! How far does a ray go before it meets a wall? Sphere tracing (Hart 1996) on the distance field, one ray or many at once.
//!
//! Many rays take turns: the looks into memory of one overlap with those of the others, and their arithmetic is SIMD.
//! Doors and windows are surfaces; a ray that meets one may look on through it.

use crate::approx::ROUND;
use crate::walls::{Class, Walls};

/// Rays end here: at 5 cm a cell, 50 km. Beyond, f32 no longer resolves a stride.
const FARTHEST_CELLS: f32 = 1e6;
/// Rays that are cast together.
pub(crate) const BLOCK: usize = 128;
/// Strides between two looks at which rays have arrived.
const STRIDES: usize = 4;

/// What a look along a ray finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Metres to the first wall; the limit where none is nearer.
    pub wall_m: f32,
    /// Doorways and windows that it passes before.
    pub passed: u32,
}

/// A ray on its way, in cells; its start is half a cell less, so that rounding names the cell.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ray {
    x: f32,
    y: f32,
    dx: f32,
    dy: f32,
    pub along: f32,
    /// Where it ends, or leaves the grid for good.
    end: f32,
}

impl Ray {
    /// Whether there is a surface where it stopped.
    #[inline(always)]
    pub(crate) fn has_met(&self) -> bool {
        self.along < self.end
    }
}

/// A block of rays, one array an attribute.
pub(crate) struct Rays {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    dx: [f32; BLOCK],
    dy: [f32; BLOCK],
    along: [f32; BLOCK],
    end: [f32; BLOCK],
    /// Which of the caller's rays this is.
    name: [u8; BLOCK],
    cell: [u32; BLOCK],
    stride: [f32; BLOCK],
}

impl Rays {
    pub(crate) fn new() -> Self {
        let zeros = [0.0; BLOCK];
        Self { x: zeros, y: zeros, dx: zeros, dy: zeros, along: zeros, end: zeros, name: [0; BLOCK], cell: [0; BLOCK], stride: zeros }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, ray: Ray) {
        (self.x[i], self.y[i], self.dx[i], self.dy[i]) = (ray.x, ray.y, ray.dx, ray.dy);
        (self.along[i], self.end[i]) = (ray.along, ray.end);
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Ray {
        Ray { x: self.x[i], y: self.y[i], dx: self.dx[i], dy: self.dy[i], along: self.along[i], end: self.end[i] }
    }
}

impl Walls {
    /// Metres from (x, y) in direction (dx, dy), unit, to the first wall; `limit_m` where none is nearer. Doors are open to it,
    /// and windows clear.
    pub fn cast(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> f32 {
        self.look(x, y, dx, dy, limit_m).wall_m
    }

    /// Looks from (x, y) in direction (dx, dy), unit, through doorways and windows to the first wall, `limit_m` far.
    /// A start within a surface leaves it first.
    pub fn look(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> Look {
        let mut ray = self.ray(x, y, dx, dy, limit_m);
        self.run(&mut ray);
        let passed = self.see_through(&mut ray, f32::INFINITY);
        Look { wall_m: if ray.has_met() { ray.along * self.cell_m } else { limit_m }, passed }
    }

    /// A ray that stands where it enters the grid.
    #[inline(always)]
    pub(crate) fn ray(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> Ray {
        // In cells: one multiplication less a stride.
        let (x, y, limit) = (x * self.per_m, y * self.per_m, limit_m * self.per_m);
        let limit = if limit < FARTHEST_CELLS { limit } else { FARTHEST_CELLS };
        // The slabs of columns and of rows that hold the grid; along a slab nothing cuts, beside it all is cut.
        let slab = |from: f32, d: f32, size: f32| {
            let per = 1.0 / d;
            let (a, b) = (-from * per, (size - from) * per);
            if a < b { (a, b) } else { (b, a) }
        };
        let (x_slab, y_slab) = (slab(x, dx, self.width as f32), slab(y, dy, self.height as f32));
        let enter = if x_slab.0 > y_slab.0 { x_slab.0 } else { y_slab.0 };
        let leave = if x_slab.1 < y_slab.1 { x_slab.1 } else { y_slab.1 };
        let end = if leave < limit { leave } else { limit };
        Ray { x: x - 0.5, y: y - 0.5, dx, dy, along: if enter > 0.0 { enter } else { 0.0 }, end }
    }

    /// Where a ray stands.
    #[inline(always)]
    fn cell_at(&self, x: f32, y: f32, dx: f32, dy: f32, along: f32) -> u32 {
        let whole = |at: f32| (at + ROUND).to_bits().wrapping_sub(ROUND.to_bits());
        let (column, row) = (whole(x + dx * along), whole(y + dy * along));
        // Negative ones, and what is not a number, are huge as unsigned. All bits or none: see [`Walls::cell_or_beyond`].
        let all = |yes: bool| u32::from(yes).wrapping_neg();
        let held = all(column < self.width as u32) & all(row < self.height as u32);
        (row.wrapping_mul(self.width as u32).wrapping_add(column) & held) | (self.beyond() & !held)
    }

    #[inline(always)]
    fn stride_from(&self, cell: u32) -> f32 {
        self.strides[usize::from(self.key(cell))]
    }

    /// Moves a ray out of the surface that it starts in.
    #[cold]
    fn leave_surface(&self, ray: &mut Ray) {
        while ray.has_met() && self.stride_from(self.cell_at(ray.x, ray.y, ray.dx, ray.dy, ray.along)) == 0.0 {
            ray.along += 0.7;
        }
    }

    /// Moves a ray to the first surface, or its end.
    pub(crate) fn run(&self, ray: &mut Ray) {
        self.leave_surface(ray);
        while ray.has_met() {
            let stride = self.stride_from(self.cell_at(ray.x, ray.y, ray.dx, ray.dy, ray.along));
            if stride == 0.0 {
                break;
            }
            ray.along += stride;
        }
    }

    /// Moves the first `count` rays as [`Walls::run`] does, to the last bit, and says how far each got.
    #[inline(always)]
    pub(crate) fn run_all(&self, rays: &mut Rays, count: usize, along: &mut [f32; BLOCK]) {
        let mut left = count.min(BLOCK);
        for i in 0..left {
            rays.name[i] = i as u8;
            rays.cell[i] = self.cell_at(rays.x[i], rays.y[i], rays.dx[i], rays.dy[i], rays.along[i]);
        }
        for i in 0..left {
            if self.key(rays.cell[i]) == 0 {
                let mut ray = rays.get(i);
                self.leave_surface(&mut ray);
                rays.along[i] = ray.along;
            }
        }
        while left > 0 {
            for _ in 0..STRIDES {
                self.stride_all(rays, left);
            }
            let mut still = 0;
            for i in 0..left {
                let ray = rays.get(i);
                let name = rays.name[i];
                along[usize::from(name) % BLOCK] = ray.along;
                rays.set(still, ray);
                rays.name[still] = name;
                still += usize::from((rays.stride[i] > 0.0) & (ray.along < ray.end));
            }
            left = still;
        }
    }

    /// One stride of each ray. Those that stand on a surface stay; those beyond their end may go on, and are not asked again.
    #[inline(always)]
    fn stride_all(&self, rays: &mut Rays, count: usize) {
        let count = count.min(BLOCK);
        for i in 0..count {
            rays.cell[i] = self.cell_at(rays.x[i], rays.y[i], rays.dx[i], rays.dy[i], rays.along[i]);
        }
        for i in 0..count {
            rays.stride[i] = self.stride_from(rays.cell[i]);
        }
        for i in 0..count {
            rays.along[i] += if rays.along[i] < rays.end[i] { rays.stride[i] } else { 0.0 };
        }
    }

    /// Lets a ray that has met a doorway or a window look on to what is behind, up to the first wall, and says through how many
    /// it saw. An opening that is met at `sure` cells or later may be what the ray ends on: it then counts as nothing met.
    #[inline(always)]
    pub(crate) fn see_through(&self, ray: &mut Ray, sure: f32) -> u32 {
        if self.openings && ray.has_met() { self.through_openings(ray, sure) } else { 0 }
    }

    fn through_openings(&self, ray: &mut Ray, sure: f32) -> u32 {
        let in_opening = |ray: &Ray| {
            let cell = self.cell_at(ray.x, ray.y, ray.dx, ray.dy, ray.along);
            ray.has_met() && self.key(cell) == 0 && self.class(cell as usize) != Class::WALL
        };
        let mut passed = 0;
        while in_opening(ray) {
            if ray.along >= sure {
                ray.along = ray.end;
                break;
            }
            passed += 1;
            // Through the glass or the doorway; a wall that it is set in may end the ray there.
            while in_opening(ray) {
                ray.along += 0.7;
            }
            while ray.has_met() {
                let stride = self.stride_from(self.cell_at(ray.x, ray.y, ray.dx, ray.dy, ray.along));
                if stride == 0.0 {
                    break;
                }
                ray.along += stride;
            }
        }
        passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::GroundCosts;
    use planwalk_types::{Cell, FloorPlan, Pt2};

    /// 8 m × 4 m at 10 cm: a wall at x = 4, with a doorway at y 1..2 and a window at y 2.5..3.5; a wall at x = 7.5.
    fn plan() -> FloorPlan {
        let cell = |index: usize| match (index % 80, index / 80) {
            (40, 10..20) => Cell::Door,
            (40, 25..35) => Cell::Window,
            (40 | 75, _) => Cell::Wall,
            _ => Cell::Free,
        };
        FloorPlan::new(Pt2::new(0.0, 0.0), 0.1, 80, 40, (0..3200).map(cell).collect()).unwrap()
    }

    #[test]
    fn a_look_goes_through_doors_and_windows_to_the_wall_behind() {
        let walls = Walls::new(&plan(), GroundCosts::default());
        for (y, wall_m, passed) in [(1.5, 6.5, 1), (3.0, 6.5, 1), (2.25, 3.0, 0)] {
            let look = walls.look(1.0, y, 1.0, 0.0, 20.0);
            assert!((look.wall_m - wall_m).abs() < 0.1 && look.passed == passed, "from y = {y}: {look:?}");
        }
        assert_eq!(walls.look(1.0, 1.5, -1.0, 0.0, 20.0), Look { wall_m: 20.0, passed: 0 });
        // From a doorway, and from a wall, one looks out.
        assert!((walls.look(4.05, 1.5, 1.0, 0.0, 20.0).wall_m - 3.45).abs() < 0.1);
        assert!((walls.look(4.05, 0.5, 1.0, 0.0, 20.0).wall_m - 3.45).abs() < 0.1);
    }

    #[test]
    fn looks_from_anywhere_end() {
        let walls = Walls::new(&plan(), GroundCosts::default());
        assert!((walls.look(-50.0, 0.5, 1.0, 0.0, 90.0).wall_m - 54.0).abs() < 0.1, "onto the plan from outside");
        assert_eq!(walls.cast(-50.0, 0.5, 0.0, 1.0, 90.0), 90.0, "past it");
        assert_eq!(walls.cast(1.0, 1.0, -0.6, 0.8, 1e30), 1e30, "away from it");
        for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            let _ =
                [walls.cast(broken, 1.0, 1.0, 0.0, 9.0), walls.cast(1.0, 1.0, broken, 0.0, 9.0), walls.cast(1.0, 1.0, 1.0, 0.0, broken)];
        }
    }

    #[test]
    fn many_rays_at_once_are_each_ray_alone() {
        let walls = Walls::new(&plan(), GroundCosts::default());
        let mut rays = Rays::new();
        let mut along = [0.0; BLOCK];
        for round in 0..50 {
            let ray = |i: usize| {
                let (dy, dx) = libm::sincosf((i * 50 + round) as f32);
                walls.ray(-0.5 + 0.07 * i as f32, 0.08 * round as f32, dx, dy, 0.1 + 0.05 * i as f32)
            };
            let count = BLOCK - round;
            (0..count).for_each(|i| rays.set(i, ray(i)));
            walls.run_all(&mut rays, count, &mut along);
            for (i, along) in along.iter().enumerate().take(count) {
                let mut alone = ray(i);
                walls.run(&mut alone);
                assert_eq!(*along, alone.along, "ray {i} of round {round}");
            }
        }
    }
}

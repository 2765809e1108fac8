//! How far is the nearest wall's face, to a fraction of a cell, and which way does it lie?
//!
//! FloorPlan, part of it ──▶ distances to the nearest wall and out of it (exact, in cells) ──▶ signed distance, interpolated
//!
//! Positive before a wall, negative within it, 0 at its face. Coordinates are metres from the grid's bottom-left corner.
//! The filter's own field knows half cells only, which is enough to tell places apart; least squares needs a slope.

use planwalk_types::{Cell, FloorPlan, distance};

/// Distances are kept up to this, metres: a point farther off no wall explains.
const REACH_M: f64 = 2.0;
/// Where there is no wall, or nothing else.
const FAR_CELLS: f64 = 1e6;

/// Signed distances to walls over a part of the plan.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    cell_m: f64,
    /// First column and row of the part.
    low: (usize, usize),
    width: usize,
    height: usize,
    /// Metres at the cells' centres.
    signed_m: Vec<f32>,
}

/// The nearest face of a wall: distance (negative within) and the direction in which it grows, unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Face {
    pub signed_m: f64,
    pub normal: (f64, f64),
}

impl Field {
    /// The field around what lies between `low` and `high` (local metres): walls up to [`REACH_M`] around count.
    pub(crate) fn new(plan: &FloorPlan, low: (f64, f64), high: (f64, f64)) -> Self {
        let cell_m = plan.cell_m();
        // Casts clamp what is negative or not a number to 0.
        let first = |v: f64| ((v - REACH_M) / cell_m) as usize;
        let past = |v: f64, size: usize| ((((v + REACH_M) / cell_m) as usize).saturating_add(2)).min(size);
        let low = (first(low.0).min(plan.width()), first(low.1).min(plan.height()));
        let (width, height) = (past(high.0, plan.width()).saturating_sub(low.0), past(high.1, plan.height()).saturating_sub(low.1));
        let wall: Vec<bool> = (0..height)
            .flat_map(|row| {
                let start = (low.1 + row) * plan.width() + low.0;
                plan.cells()[start..start + width].iter().map(|cell: &Cell| cell.blocks())
            })
            .collect();
        let to_nearest = |of: bool| distance::to_nearest(wall.iter().map(|wall| *wall == of), width, FAR_CELLS, |cells| cells);
        let (to_wall, out_of_it) = (to_nearest(true), to_nearest(false));
        let signed = |i: usize| {
            // From a cell's centre to the face of its neighbour is half a cell less than to that one's centre.
            let cells = if wall[i] { 0.5 - out_of_it[i] } else { to_wall[i] - 0.5 };
            (cells * cell_m).clamp(-REACH_M, REACH_M) as f32
        };
        let signed_m = (0..wall.len()).map(signed).collect();
        Self { cell_m, low, width, height, signed_m }
    }

    fn at(&self, column: isize, row: isize) -> f64 {
        let clamp = |v: isize, size: usize| v.clamp(0, size as isize - 1) as usize;
        f64::from(self.signed_m[clamp(row, self.height) * self.width + clamp(column, self.width)])
    }

    /// The nearest face from (x, y), interpolated between the centres of cells; `None` where no wall is near, beyond the part,
    /// and in the middle between two walls, where no direction is the nearest.
    pub(crate) fn face(&self, x: f64, y: f64) -> Option<Face> {
        let (u, v) = (x / self.cell_m - 0.5 - self.low.0 as f64, y / self.cell_m - 0.5 - self.low.1 as f64);
        if !(u > -0.5 && v > -0.5 && u < self.width as f64 - 0.5 && v < self.height as f64 - 0.5) {
            return None;
        }
        let signed_m = self.bilinear(u, v);
        if signed_m >= 0.95 * REACH_M {
            return None;
        }
        // Over two cells, so that the steps of a drawn oblique wall even out.
        let slope = (self.bilinear(u + 1.0, v) - self.bilinear(u - 1.0, v), self.bilinear(u, v + 1.0) - self.bilinear(u, v - 1.0));
        let steep = slope.0.hypot(slope.1);
        // A unit slope gives 2 cells; ridges between walls, and the middle of thin ones, give next to nothing.
        (steep > 0.8 * self.cell_m).then(|| Face { signed_m, normal: (slope.0 / steep, slope.1 / steep) })
    }

    fn bilinear(&self, u: f64, v: f64) -> f64 {
        let (column, row) = (u.floor(), v.floor());
        let (a, b) = (u - column, v - row);
        let (column, row) = (column as isize, row as isize);
        let below = self.at(column, row) * (1.0 - a) + self.at(column + 1, row) * a;
        let above = self.at(column, row + 1) * (1.0 - a) + self.at(column + 1, row + 1) * a;
        below * (1.0 - b) + above * b
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Pt2;

    /// A wall from x = 2.0 to 2.3 m in a plan of 6 m × 4 m.
    fn field() -> Field {
        let (width, height) = (60, 40);
        let cells = (0..width * height).map(|i| if (20..23).contains(&(i % width)) { Cell::Wall } else { Cell::Free }).collect();
        let plan = FloorPlan::new(Pt2::new(7.0, -3.0), 0.1, width, height, cells).unwrap();
        Field::new(&plan, (0.0, 0.0), (6.0, 4.0))
    }

    #[test]
    fn distance_is_to_the_face_and_to_a_fraction_of_a_cell() {
        let field = field();
        for (x, expected, normal) in [(1.5, 0.5, -1.0), (1.537, 0.463, -1.0), (2.05, -0.05, -1.0), (2.28, -0.02, 1.0), (2.83, 0.53, 1.0)] {
            let face = field.face(x, 2.03).unwrap();
            // Interpolation is exact before a straight wall; across its face, where the slope breaks by nothing, too.
            assert!((face.signed_m - expected).abs() < 1e-6, "at {x}: {face:?}");
            assert!((face.normal.0 - normal).abs() < 1e-6 && face.normal.1.abs() < 1e-6, "at {x}: {face:?}");
        }
    }

    #[test]
    fn nothing_is_near_far_off_beyond_the_plan_and_at_what_is_no_place() {
        let field = field();
        for (x, y) in [(5.5, 2.0), (-1.0, 2.0), (1.5, 9.0), (f64::NAN, 2.0)] {
            assert_eq!(field.face(x, y), None, "({x}, {y})");
        }
        assert_eq!(field.face(2.15, 2.0), None, "the middle of a wall faces nowhere");
    }
}

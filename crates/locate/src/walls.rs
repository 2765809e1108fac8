//! What stands between two points of the plan, how far is the nearest wall, and how welcome is the ground?
//!
//! FloorPlan ──▶ distance field (exact, in cells) ──▶ ray casts and crossing counts
//!
//! Coordinates here are metres from the grid's bottom-left corner, as f32: 1 km is then still resolved to 0.1 mm,
//! wherever on earth the plan's own origin lies.
//! Pitfall: a move that is shorter than a wall is thick may start and end inside it; crossings count *entries*.

use planwalk_types::{Cell, FloorPlan};
use rayon::prelude::*;

/// Distances are kept to this many cells: one byte in half cells, so that the field of a floor stays in the cache.
const FAR_CELLS: u8 = 127;

/// What a metre costs (nats) away from what is surely the building's floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundCosts {
    /// On ground that is surely outside. Little: outlines are open, and walks begin where the plan ends.
    pub outside_nats_per_m: f64,
    /// On ground that the plan says it does not know: a robot looked around, and this was never floor.
    pub unknown_nats_per_m: f64,
    /// Within a wall: as an axis along which to walk, a wall is no place.
    pub in_wall_nats_per_m: f64,
    /// Beyond the grid, within [`GroundCosts::margin_m`].
    pub beyond_nats_per_m: f64,
    /// How far beyond the grid one may walk at that cost; ten times as much farther out.
    pub margin_m: f64,
}

impl Default for GroundCosts {
    /// 20 m outside cost a factor of e, 3 m on unknown ground too; a wall's thickness costs a few per cent on top of the crossing.
    fn default() -> Self {
        Self { outside_nats_per_m: 0.05, unknown_nats_per_m: 0.3, in_wall_nats_per_m: 1.0, beyond_nats_per_m: 0.3, margin_m: 5.0 }
    }
}

/// The plan as the filter's inner loop wants it.
#[derive(Debug, Clone)]
pub struct Walls {
    cell_m: f32,
    per_m: f32,
    width: i32,
    height: i32,
    /// Half cells between this cell's centre and the nearest wall cell's; 0 in a wall.
    half_cells: Vec<u8>,
    /// Nats that a metre costs in each cell.
    nats_per_m: Vec<f32>,
    costs: GroundCosts,
}

impl Walls {
    /// The walls of this plan. Takes a few passes over the grid.
    pub fn new(plan: &FloorPlan, costs: GroundCosts) -> Self {
        let cost = |(cell, inside): (&Cell, &f32)| match cell {
            Cell::Wall | Cell::Window => costs.in_wall_nats_per_m as f32,
            Cell::Unknown => costs.unknown_nats_per_m as f32,
            Cell::Free | Cell::Door => costs.outside_nats_per_m as f32 * (1.0 - inside),
        };
        let nats_per_m = plan.cells().iter().zip(plan.inside()).map(cost).collect();
        Self {
            cell_m: plan.cell_m() as f32,
            per_m: (1.0 / plan.cell_m()) as f32,
            width: plan.width() as i32,
            height: plan.height() as i32,
            half_cells: distance_field(plan),
            nats_per_m,
            costs,
        }
    }

    /// Side of a cell, metres.
    pub fn cell_m(&self) -> f32 {
        self.cell_m
    }

    /// Width and height of the grid, metres.
    pub fn size_m(&self) -> (f32, f32) {
        (self.width as f32 * self.cell_m, self.height as f32 * self.cell_m)
    }

    /// Which cell holds (x, y); `None` beyond the grid, and for what is not a number.
    #[inline]
    fn index(&self, x: f32, y: f32) -> Option<usize> {
        let (column, row) = (x * self.per_m, y * self.per_m);
        let held = column >= 0.0 && row >= 0.0 && column < self.width as f32 && row < self.height as f32;
        held.then(|| row as i32 as usize * self.width as usize + column as i32 as usize)
    }

    /// Distance from the cell at (x, y) to the nearest wall cell, in half cells, at most 254; `None` beyond the grid.
    #[inline]
    fn half_cells_at(&self, x: f32, y: f32) -> Option<u8> {
        self.index(x, y).map(|index| self.half_cells[index])
    }

    /// Distance from (x, y) to the nearest wall in half cells, as a key for tables; beyond the grid 255.
    #[inline]
    pub fn wall_distance_key(&self, x: f32, y: f32) -> u8 {
        self.half_cells_at(x, y).unwrap_or(u8::MAX)
    }

    /// Is there a wall at (x, y)?
    pub fn is_wall(&self, x: f32, y: f32) -> bool {
        self.half_cells_at(x, y) == Some(0)
    }

    /// Metres from (x, y) in direction (dx, dy), unit, to the first wall; `limit_m` where none is nearer.
    ///
    /// Walks the distance field ("sphere tracing", Hart 1996). A start within a wall leaves it first.
    #[inline]
    pub fn cast(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> f32 {
        // In cells: one multiplication less a step.
        let (x, y, limit) = (x * self.per_m, y * self.per_m, limit_m * self.per_m);
        let (width, height) = (self.width as f32, self.height as f32);
        let mut along = 0.0f32;
        let mut left_the_wall = false;
        while along < limit {
            let (column, row) = (x + dx * along, y + dy * along);
            // Also false where a coordinate is not a number.
            let held = column >= 0.0 && row >= 0.0 && column < width && row < height;
            if !held {
                left_the_wall = true;
                along += 1.0;
                continue;
            }
            let half_cells = self.half_cells[row as i32 as usize * self.width as usize + column as i32 as usize];
            if half_cells == 0 {
                if left_the_wall {
                    return along * self.cell_m;
                }
                along += 0.7;
            } else {
                left_the_wall = true;
                // From anywhere in this cell the nearest wall's face is at least d − 1 cells off, and a wall is at least one
                // cell thick: d − 0.7 lands at most 0.3 cells into it, never behind it.
                along += (0.5 * f32::from(half_cells) - 0.7).max(0.7);
            }
        }
        limit_m
    }

    /// How often the straight way from one point to another enters a wall: every cell that it touches is looked at
    /// (Amanatides & Woo 1987).
    pub fn crossings(&self, x0: f32, y0: f32, x1: f32, y1: f32) -> u32 {
        let length = ((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)).sqrt();
        if let Some(half_cells) = self.half_cells_at(x0, y0)
            && 0.5 * f32::from(half_cells) > length * self.per_m + 1.5
        {
            return 0;
        }
        // A way of a kilometre in one step is no walk; the bound keeps broken input from spinning here.
        if !(length.is_finite() && length < 1000.0) {
            return 0;
        }
        let mut entries = 0;
        let mut in_wall = true; // a start within a wall is not an entry
        self.visit(x0, y0, x1, y1, |wall| {
            entries += u32::from(wall && !in_wall);
            in_wall = wall;
        });
        entries
    }

    fn visit(&self, x0: f32, y0: f32, x1: f32, y1: f32, mut see: impl FnMut(bool)) {
        let (fx, fy) = (x0 * self.per_m, y0 * self.per_m);
        let (dx, dy) = ((x1 - x0) * self.per_m, (y1 - y0) * self.per_m);
        let (mut column, mut row) = (fx.floor() as i32, fy.floor() as i32);
        let (last_column, last_row) = ((x1 * self.per_m).floor() as i32, (y1 * self.per_m).floor() as i32);
        let (step_x, step_y) = (if dx > 0.0 { 1 } else { -1 }, if dy > 0.0 { 1 } else { -1 });
        let first = |f: f32, d: f32| if d > 0.0 { (f.floor() + 1.0 - f) / d } else { (f.floor() - f) / d };
        let (mut next_x, mut next_y) =
            (if dx == 0.0 { f32::INFINITY } else { first(fx, dx) }, if dy == 0.0 { f32::INFINITY } else { first(fy, dy) });
        let (every_x, every_y) = ((1.0 / dx).abs(), (1.0 / dy).abs());
        see(self.cell_is_wall(column, row));
        for _ in 0..column.abs_diff(last_column) + row.abs_diff(last_row) {
            if next_x < next_y {
                column += step_x;
                next_x += every_x;
            } else {
                row += step_y;
                next_y += every_y;
            }
            see(self.cell_is_wall(column, row));
        }
    }

    fn cell_is_wall(&self, column: i32, row: i32) -> bool {
        let held = column >= 0 && row >= 0 && column < self.width && row < self.height;
        held && self.half_cells[row as usize * self.width as usize + column as usize] == 0
    }

    /// What `length_m` of walking costs where it ends, in nats.
    #[inline]
    pub fn ground_cost(&self, x: f32, y: f32, length_m: f32) -> f32 {
        let per_m = if let Some(index) = self.index(x, y) {
            self.nats_per_m[index]
        } else {
            let (size_x, size_y) = self.size_m();
            let off = (-x).max(x - size_x).max(-y).max(y - size_y);
            let within = off <= self.costs.margin_m as f32;
            self.costs.beyond_nats_per_m as f32 * if within { 1.0 } else { 10.0 }
        };
        per_m * length_m
    }
}

/// Exact Euclidean distance of every cell to the nearest wall cell, in half cells, capped (Felzenszwalb & Huttenlocher 2012:
/// columns first, then the lower envelope of parabolas along each row).
fn distance_field(plan: &FloorPlan) -> Vec<u8> {
    let (width, height) = (plan.width(), plan.height());
    let mut down = vec![FAR_CELLS; width * height];
    for row in 0..height {
        for column in 0..width {
            let below = if row > 0 { down[(row - 1) * width + column].saturating_add(1) } else { FAR_CELLS };
            let wall = plan.cells()[row * width + column].blocks();
            down[row * width + column] = if wall { 0 } else { below.min(FAR_CELLS) };
        }
    }
    for row in (0..height.saturating_sub(1)).rev() {
        for column in 0..width {
            let above = down[(row + 1) * width + column].saturating_add(1);
            let here = &mut down[row * width + column];
            *here = above.min(*here);
        }
    }
    down.par_chunks_mut(width).for_each(envelope);
    down
}

/// From distances within columns (cells) to distances in the plane (half cells), for one row.
fn envelope(row: &mut [u8]) {
    let square = |d: u8| if d >= FAR_CELLS { 1e9 } else { f64::from(d) * f64::from(d) };
    let columns: Vec<f64> = row.iter().map(|d| square(*d)).collect();
    // Parabolas of the lower envelope, each with where it begins to be the lowest.
    let mut lowest: Vec<(usize, f64)> = Vec::with_capacity(columns.len());
    for (i, height) in columns.iter().enumerate() {
        loop {
            let Some(&(j, from)) = lowest.last() else {
                lowest.push((i, f64::NEG_INFINITY));
                break;
            };
            let (a, b) = (i as f64, j as f64);
            let meet = ((height + a * a) - (columns[j] + b * b)) / (2.0 * (a - b));
            if meet > from {
                lowest.push((i, meet));
                break;
            }
            lowest.pop();
        }
    }
    let mut k = 0;
    for (i, out) in row.iter_mut().enumerate() {
        while k + 1 < lowest.len() && lowest[k + 1].1 <= i as f64 {
            k += 1;
        }
        let (j, _) = lowest[k];
        let cells = (columns[j] + (i as f64 - j as f64).powi(2)).sqrt();
        *out = (2.0 * cells).round().min(2.0 * f64::from(FAR_CELLS)) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Pt2, Wall};
    use proptest::prelude::*;

    fn room() -> (FloorPlan, Walls) {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
        let walls = [
            wall(0.0, 0.0, 4.0, 0.0),
            wall(4.0, 0.0, 4.0, 3.0),
            wall(4.0, 3.0, 0.0, 3.0),
            wall(0.0, 3.0, 0.0, 0.0),
            wall(1.0, 1.0, 2.0, 2.0),
        ];
        let plan = FloorPlan::from_walls(&walls, 0.05, 1.0).unwrap();
        let walls = Walls::new(&plan, GroundCosts::default());
        (plan, walls)
    }

    #[test]
    fn the_distance_field_agrees_with_brute_force() {
        let (plan, walls) = room();
        let (width, height) = (plan.width(), plan.height());
        for index in (0..width * height).step_by(37) {
            let (column, row) = ((index % width) as f64, (index / width) as f64);
            let mut nearest = f64::INFINITY;
            for (other, cell) in plan.cells().iter().enumerate() {
                if *cell == Cell::Wall {
                    nearest = nearest.min((column - (other % width) as f64).hypot(row - (other / width) as f64));
                }
            }
            assert_eq!(walls.half_cells[index], (2.0 * nearest).round() as u8, "cell {column}, {row}");
        }
    }

    proptest! {
        #[test]
        fn casts_agree_with_small_steps(x in 1.2..4.8f32, y in 1.2..3.8f32, angle in 0.0..6.2f32) {
            let (_, walls) = room();
            prop_assume!(!walls.is_wall(x, y));
            let (dy, dx) = libm::sincosf(angle);
            let mut slow = 0.0f32;
            while slow < 9.0 && !walls.is_wall(x + dx * slow, y + dy * slow) {
                slow += 0.002;
            }
            let fast = walls.cast(x, y, dx, dy, 9.0);
            // A ray may clip a cell's corner, which the slow walk sees and the fast one passes; else they agree to a cell.
            let clipped = fast > slow && walls.wall_distance_key(x + dx * (slow + 0.04), y + dy * (slow + 0.04)) > 0;
            prop_assert!((fast - slow).abs() < 0.051 || clipped, "{fast} m against {slow} m");
        }

        #[test]
        fn nobody_slips_through_a_diagonal_wall(t in 0.1..0.9f32, off in 0.2..0.5f32) {
            let (_, walls) = room();
            let (x, y) = (2.0 + t, 2.0 + t);
            prop_assert_eq!(walls.crossings(x - off, y + off, x + off, y - off), 1);
        }
    }

    #[test]
    fn crossings_are_counted_by_entry() {
        let (_, walls) = room();
        assert_eq!(walls.crossings(2.5, 1.5, 2.5, 1.7), 0, "within the room");
        assert_eq!(walls.crossings(2.5, 1.5, 2.5, 0.5), 1, "out of it");
        assert_eq!(walls.crossings(0.5, 2.5, 5.5, 2.5), 3, "past both sides and the diagonal");
        assert_eq!(walls.crossings(f32::NAN, 1.5, 5.5, 1.5), 0, "what is no way crosses nothing");
    }

    #[test]
    fn ground_is_dearer_outside_and_dearest_far_beyond() {
        let (_, walls) = room();
        let [inside, outside, beyond, far] = [(3.5, 2.0), (0.3, 0.3), (-1.0, 2.0), (-9.0, 2.0)].map(|(x, y)| walls.ground_cost(x, y, 1.0));
        assert!(inside < outside && outside < beyond && beyond < far, "{inside} {outside} {beyond} {far}");
    }
}

//! What stands between two points of the plan, how far is the nearest wall, and how welcome is the ground?
//!
//! FloorPlan ──▶ distance field (exact, in cells) and class of every cell ──▶ ray casts and crossing counts
//!
//! *Surfaces* are what a ray may end on: walls, windows (glass), doors (shut). *Walls* are what stops who walks: walls and windows.
//! Distances are to surfaces, so that one field serves walkers and rays; what kind it is, is looked up where a surface is met.
//! Coordinates here are metres from the grid's bottom-left corner, as f32: 1 km is then still resolved to 0.1 mm,
//! wherever on earth the plan's own origin lies.
//! Pitfall: a move that is shorter than a wall is thick may start and end inside it; crossings count *entries*.

use planwalk_types::{Cell, FloorPlan};

use crate::approx;
use crate::field::{distance_field, widen};

/// What a metre costs (nats) away from what is surely the building's floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundCosts {
    /// On ground that is surely outside. Not much: outlines are open, and walks begin where the plan ends.
    pub outside_nats_per_m: f64,
    /// On ground that the plan says it does not know: a robot looked around, and this was never floor.
    pub unknown_nats_per_m: f64,
    /// Each doorway walked through, in nats. Little: it may be shut now and then, and to walk through many is a longer story
    /// than to walk through few.
    pub door_nats: f64,
    /// Within a wall: as an axis along which to walk, a wall is no place.
    pub in_wall_nats_per_m: f64,
    /// Beyond the grid, within [`GroundCosts::margin_m`].
    pub beyond_nats_per_m: f64,
    /// How far beyond the grid one may walk at that cost; ten times as much farther out.
    pub margin_m: f64,
}

impl Default for GroundCosts {
    /// 4 m outside cost a factor of e, 1 m on unknown ground too; a wall's thickness costs a few per cent on top of the crossing.
    /// Where nothing is seen, ground without walls has nothing else to speak against it: at a fifth of these costs the Intel
    /// robot's half kilometre of wheel odometry was put beside its map.
    fn default() -> Self {
        Self {
            outside_nats_per_m: 0.25,
            unknown_nats_per_m: 1.0,
            door_nats: 0.02,
            in_wall_nats_per_m: 1.0,
            beyond_nats_per_m: 1.0,
            margin_m: 5.0,
        }
    }
}

/// From anywhere in a cell at distance d (half cells, by index) the nearest surface's face is at least d − 1 cells off, and a
/// surface is at least one cell thick: d − 0.7 lands at most 0.3 cells into it, never behind it.
fn strides() -> [f32; 256] {
    let mut strides = [0.0; 256];
    for (half_cells, stride) in (0u8..).zip(&mut strides).skip(1) {
        *stride = (0.5 * f32::from(half_cells) - 0.7).max(0.7);
    }
    // Rays are cut at the grid's edge; round-off may leave one just beyond.
    strides[255] = 1.0;
    strides
}

/// What kind of ground a cell is: its kind and, for floor, how surely it is inside, in hundredths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Class(u8);

impl Class {
    pub(crate) const WALL: Self = Self(0);
    const WINDOW: Self = Self(1);
    const BEYOND: Self = Self(2);
    const UNKNOWN: Self = Self(3);
    const FREE: u8 = 4;
    const DOOR: u8 = Self::FREE + 101;

    fn of(cell: Cell, inside: f32) -> Self {
        let hundredths = (100.0 * inside).round().clamp(0.0, 100.0) as u8;
        match cell {
            Cell::Wall => Self::WALL,
            Cell::Window => Self::WINDOW,
            Cell::Unknown => Self::UNKNOWN,
            Cell::Free => Self(Self::FREE + hundredths),
            Cell::Door => Self(Self::DOOR + hundredths),
        }
    }

    #[inline]
    fn blocks(self) -> bool {
        self.0 <= Self::WINDOW.0
    }

    #[inline]
    fn is_door(self) -> bool {
        self.0 >= Self::DOOR
    }

    /// Nats a metre.
    fn cost(self, costs: &GroundCosts) -> f32 {
        let outside = |hundredths: u8| costs.outside_nats_per_m as f32 * (1.0 - 0.01 * f32::from(hundredths));
        match self {
            Self::WALL | Self::WINDOW => costs.in_wall_nats_per_m as f32,
            Self::BEYOND => costs.beyond_nats_per_m as f32,
            Self::UNKNOWN => costs.unknown_nats_per_m as f32,
            Self(class) if self.is_door() => outside((class - Self::DOOR).min(100)),
            Self(class) => outside(class - Self::FREE),
        }
    }
}

/// What a straight way meets.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Met {
    /// How often it enters walls or windows.
    pub walls: u32,
    /// How often it enters doorways.
    pub doors: u32,
}

/// The plan as the filter's inner loop wants it.
#[derive(Debug, Clone)]
pub struct Walls {
    pub(crate) cell_m: f32,
    pub(crate) per_m: f32,
    pub(crate) width: i32,
    pub(crate) height: i32,
    /// Half cells between this cell's centre and the nearest surface cell's; 0 in a surface. One byte a cell, for rays, which
    /// look at many cells; one more at the end: beyond the grid. And …
    pub(crate) half_cells: Vec<u8>,
    /// How far a ray may go from a cell with such a distance, in cells; 0 from a surface.
    pub(crate) strides: [f32; 256],
    /// … and for walkers, who look at one or two: half cells around the cell in which surely no surface is, and in the upper byte
    /// the class of the cell. One more at the end: beyond the grid.
    ground: Vec<u16>,
    /// Nats that a metre costs on each class of ground.
    nats_per_m: Vec<f32>,
    costs: GroundCosts,
    /// Whether there is a door or a window at all.
    pub(crate) openings: bool,
}

impl Walls {
    /// The walls of this plan. Takes a few passes over the grid.
    pub fn new(plan: &FloorPlan, costs: GroundCosts) -> Self {
        let surface = |cell: &Cell| cell.blocks() || *cell == Cell::Door;
        let mut surfaces: Vec<bool> = plan.cells().iter().map(surface).collect();
        let mut half_cells = distance_field(&surfaces, plan.width(), f64::round);
        // Two cells are as far apart as one's centre is from the nearest of the nine around the other.
        widen(&mut surfaces, plan.width());
        let clear = distance_field(&surfaces, plan.width(), f64::floor);
        let classes = plan.cells().iter().zip(plan.inside()).map(|(cell, inside)| Class::of(*cell, *inside));
        let record = |(clear, class): (&u8, Class)| u16::from(*clear) | u16::from(class.0) << 8;
        let ground = clear.iter().zip(classes).map(record).chain([u16::from(Class::BEYOND.0) << 8]).collect();
        half_cells.push(u8::MAX);
        Self {
            cell_m: plan.cell_m() as f32,
            per_m: (1.0 / plan.cell_m()) as f32,
            width: plan.width() as i32,
            height: plan.height() as i32,
            half_cells,
            strides: strides(),
            ground,
            nats_per_m: (0..=u8::MAX).map(|class| Class(class).cost(&costs)).collect(),
            costs,
            openings: plan.cells().iter().any(|c| matches!(c, Cell::Door | Cell::Window)),
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

    /// Nats that each doorway costs who walks through it.
    pub(crate) fn door_nats(&self) -> f32 {
        self.costs.door_nats as f32
    }

    /// Which cell holds (x, y); one past the last beyond the grid, and for what is not a number.
    #[inline(always)]
    pub(crate) fn cell_or_beyond(&self, x: f32, y: f32) -> u32 {
        let (column, row) = (x * self.per_m, y * self.per_m);
        // All bits or none: written as a choice, it becomes branches, which no loop can take eight at a time.
        let all = |yes: bool| u32::from(yes).wrapping_neg();
        let held = all(column >= 0.0) & all(row >= 0.0) & all(column < self.width as f32) & all(row < self.height as f32);
        // Right up to 4 million columns, which are 200 km.
        let index = approx::floor(row).wrapping_mul(self.width).wrapping_add(approx::floor(column)) as u32;
        (index & held) | (self.beyond() & !held)
    }

    /// The name of all that is beyond the grid.
    #[inline(always)]
    pub(crate) fn beyond(&self) -> u32 {
        self.half_cells.len() as u32 - 1
    }

    /// Which cell holds (x, y); `None` beyond the grid, and for what is not a number.
    #[inline]
    fn index(&self, x: f32, y: f32) -> Option<usize> {
        let cell = self.cell_or_beyond(x, y);
        self.is_held(cell).then_some(cell as usize)
    }

    pub(crate) fn class(&self, index: usize) -> Class {
        Class((self.ground[index] >> 8) as u8)
    }

    /// Distance from (x, y) to the nearest wall, window or door in half cells, as a key for tables; beyond the grid 255.
    #[inline]
    pub fn wall_distance_key(&self, x: f32, y: f32) -> u8 {
        self.key(self.cell_or_beyond(x, y))
    }

    /// As [`Walls::wall_distance_key`], of a cell that [`Walls::cell_or_beyond`] named.
    #[inline(always)]
    pub(crate) fn key(&self, cell: u32) -> u8 {
        self.half_cells.get(cell as usize).copied().unwrap_or(u8::MAX)
    }

    /// Whether a cell that [`Walls::cell_or_beyond`] named is on the grid.
    #[inline(always)]
    pub(crate) fn is_held(&self, cell: u32) -> bool {
        cell < self.beyond()
    }

    /// Is there a wall or a window at (x, y)?
    pub fn is_wall(&self, x: f32, y: f32) -> bool {
        self.index(x, y).is_some_and(|index| self.class(index).blocks())
    }

    /// What a walk of `length_m` to this cell costs on its ground, in nats, and whether it surely met no surface on the way.
    ///
    /// Where it may have, and beyond the grid, `false`: the whole way is to be looked at, and [`Walls::ground_cost`] be asked.
    #[inline(always)]
    pub(crate) fn arrival(&self, cell: u32, length_m: f32) -> (f32, bool) {
        let record = self.ground.get(cell as usize).copied().unwrap_or(u16::from(Class::BEYOND.0) << 8);
        let cost = self.nats_per_m[usize::from(record >> 8)] * length_m;
        (cost, clear_cells(record) > length_m * self.per_m)
    }

    /// How often the straight way from one point to another enters a wall or a window.
    pub fn crossings(&self, x0: f32, y0: f32, x1: f32, y1: f32) -> u32 {
        self.met(x0, y0, x1, y1).walls
    }

    /// What the straight way from one point to another enters: every cell that it touches is looked at (Amanatides & Woo 1987),
    /// but those that are surely away from any surface, seen from either end and from between.
    pub fn met(&self, x0: f32, y0: f32, x1: f32, y1: f32) -> Met {
        let length = ((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)).sqrt();
        // A way of a kilometre in one step is no walk; the bound keeps broken input from spinning here.
        if !(length.is_finite() && length < 1000.0) {
            return Met::default();
        }
        self.met_on((x0, y0), (x1, y1), [self.cell_or_beyond(x0, y0), self.cell_or_beyond(x1, y1)], length)
    }

    /// As [`Walls::met`], of a way between these cells of this length, metres, under a kilometre.
    #[inline(always)]
    pub(crate) fn met_on(&self, (x0, y0): (f32, f32), (x1, y1): (f32, f32), cells: [u32; 2], length_m: f32) -> Met {
        let clear = |cell: u32| clear_cells(self.ground.get(cell as usize).copied().unwrap_or(0));
        let length = length_m * self.per_m;
        let (from, to) = (clear(cells[0]), clear(cells[1]));
        let gap = length - from - to;
        if gap <= 0.0 {
            return Met::default();
        }
        let per_cell = 1.0 / length;
        let (start, end) = (from * per_cell, 1.0 - to * per_cell);
        let (dx, dy) = (x1 - x0, y1 - y0);
        let middle = 0.5 * (start + end);
        if clear(self.cell_or_beyond(x0 + dx * middle, y0 + dy * middle)) >= 0.5 * gap {
            return Met::default();
        }
        self.met_between(x0 + dx * start, y0 + dy * start, x0 + dx * end, y0 + dy * end)
    }

    /// What the cells of a way hold, one after the other: an index that moves through the grid.
    fn met_between(&self, x0: f32, y0: f32, x1: f32, y1: f32) -> Met {
        let (Some(mut index), Some(_)) = (self.index(x0, y0), self.index(x1, y1)) else {
            return self.met_cell_by_cell(x0, y0, x1, y1);
        };
        let (fx, fy) = (x0 * self.per_m, y0 * self.per_m);
        let (dx, dy) = ((x1 - x0) * self.per_m, (y1 - y0) * self.per_m);
        let (every_x, every_y) = ((1.0 / dx).abs(), (1.0 / dy).abs());
        let (column, row) = (approx::floor(fx), approx::floor(fy));
        let first = |f: f32, whole: i32, d: f32, every: f32| {
            let part = f - whole as f32;
            if d == 0.0 { f32::INFINITY } else { every * if d > 0.0 { 1.0 - part } else { part } }
        };
        // Whether the next border is one between rows (positive) or between columns.
        let mut lead = first(fx, column, dx, every_x) - first(fy, row, dy, every_y);
        let (last_column, last_row) = (approx::floor(x1 * self.per_m), approx::floor(y1 * self.per_m));
        let step_x = if dx > 0.0 { 1 } else { usize::MAX };
        let step_y = if dy > 0.0 { self.width as usize } else { (self.width as usize).wrapping_neg() };
        let mut met = Met::default();
        // A start within a wall or a door is not an entry.
        let mut before = if self.half_cells[index] == 0 { Some(self.class(index)) } else { None };
        for _ in 0..column.abs_diff(last_column) + row.abs_diff(last_row) {
            let sideways = lead < 0.0;
            index = index.wrapping_add(if sideways { step_x } else { step_y });
            lead += if sideways { every_x } else { -every_y };
            // Round-off at the grid's very edge may leave it for a cell.
            if self.half_cells.get(index).is_none_or(|half_cells| *half_cells > 0) {
                before = None;
                continue;
            }
            let class = self.class(index);
            met.walls += u32::from(class.blocks() && !before.is_some_and(Class::blocks));
            met.doors += u32::from(class.is_door() && !before.is_some_and(Class::is_door));
            before = Some(class);
        }
        met
    }

    /// As [`Walls::crossings`], without any short cut.
    #[cfg(test)]
    pub(crate) fn crossings_cell_by_cell(&self, x0: f32, y0: f32, x1: f32, y1: f32) -> u32 {
        self.met_cell_by_cell(x0, y0, x1, y1).walls
    }

    /// As [`Walls::met`], without any short cut.
    fn met_cell_by_cell(&self, x0: f32, y0: f32, x1: f32, y1: f32) -> Met {
        let mut met = Met::default();
        let (mut in_wall, mut in_door) = (true, true);
        self.visit(x0, y0, x1, y1, |class| {
            let (wall, door) = class.map_or((false, false), |c| (c.blocks(), c.is_door()));
            met.walls += u32::from(wall && !in_wall);
            met.doors += u32::from(door && !in_door);
            (in_wall, in_door) = (wall, door);
        });
        met
    }

    /// Shows `see` the class of every surface cell on the way, and `None` for every other cell.
    #[inline(always)]
    fn visit(&self, x0: f32, y0: f32, x1: f32, y1: f32, mut see: impl FnMut(Option<Class>)) {
        let (fx, fy) = (x0 * self.per_m, y0 * self.per_m);
        let (dx, dy) = ((x1 - x0) * self.per_m, (y1 - y0) * self.per_m);
        let (mut column, mut row) = (approx::floor(fx), approx::floor(fy));
        let (last_column, last_row) = (approx::floor(x1 * self.per_m), approx::floor(y1 * self.per_m));
        let (step_x, step_y) = (if dx > 0.0 { 1 } else { -1 }, if dy > 0.0 { 1 } else { -1 });
        let first = |f: f32, d: f32| if d > 0.0 { (approx::floor(f) as f32 + 1.0 - f) / d } else { (approx::floor(f) as f32 - f) / d };
        let (mut next_x, mut next_y) =
            (if dx == 0.0 { f32::INFINITY } else { first(fx, dx) }, if dy == 0.0 { f32::INFINITY } else { first(fy, dy) });
        let (every_x, every_y) = ((1.0 / dx).abs(), (1.0 / dy).abs());
        see(self.surface(column, row));
        for _ in 0..column.abs_diff(last_column) + row.abs_diff(last_row) {
            let sideways = next_x < next_y;
            column += if sideways { step_x } else { 0 };
            row += if sideways { 0 } else { step_y };
            next_x += if sideways { every_x } else { 0.0 };
            next_y += if sideways { 0.0 } else { every_y };
            see(self.surface(column, row));
        }
    }

    #[inline(always)]
    fn surface(&self, column: i32, row: i32) -> Option<Class> {
        // Negative ones are huge as unsigned.
        let held = (column as u32) < self.width as u32 && (row as u32) < self.height as u32;
        let index = row as usize * self.width as usize + column as usize;
        (held && self.half_cells[index] == 0).then(|| self.class(index))
    }

    /// What `length_m` of walking costs where it ends, in nats.
    #[inline]
    pub fn ground_cost(&self, x: f32, y: f32, length_m: f32) -> f32 {
        let per_m = if let Some(index) = self.index(x, y) {
            self.nats_per_m[usize::from(self.ground[index] >> 8)]
        } else {
            let (size_x, size_y) = self.size_m();
            let off = (-x).max(x - size_x).max(-y).max(y - size_y);
            let within = off <= self.costs.margin_m as f32;
            self.costs.beyond_nats_per_m as f32 * if within { 1.0 } else { 10.0 }
        };
        per_m * length_m
    }
}

/// How many cells around any point of a cell are no surface.
#[inline(always)]
fn clear_cells(ground: u16) -> f32 {
    0.5 * f32::from(ground as u8)
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

    /// Where a ray first touches a cell of a wall, or passes it within a millimetre, m: all cells tried.
    fn touched_m(walls: &Walls, from: (f32, f32), ahead: (f32, f32)) -> f32 {
        let (size_x, size_y) = walls.size_m();
        let cells = |size: f32| (0..libm::roundf(size / 0.05) as i32).map(|i| 0.05 * i as f32);
        let between = |low: f32, from: f32, ahead: f32| {
            let (a, b) = ((low - 1e-3 - from) / ahead, (low + 0.051 - from) / ahead);
            (a.min(b), a.max(b))
        };
        let entry = |(low_x, low_y): (f32, f32)| {
            let (x, y) = (between(low_x, from.0, ahead.0), between(low_y, from.1, ahead.1));
            let (first, last) = (x.0.max(y.0), x.1.min(y.1));
            (walls.is_wall(low_x + 0.025, low_y + 0.025) && first <= last && last > 0.0).then_some(first.max(0.0))
        };
        let all = cells(size_x).flat_map(|x| cells(size_y).map(move |y| (x, y)));
        all.filter_map(entry).fold(f32::INFINITY, f32::min)
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
            let clipped = walls.wall_distance_key(x + dx * (slow + 0.04), y + dy * (slow + 0.04)) > 0;
            prop_assert!(fast < slow + 0.051 || clipped, "{fast} m against {slow} m");
            // The slow walk may leap over a corner. No ray ends before the first cell that it touches at all.
            let touched = touched_m(&walls, (x, y), (dx, dy)).min(9.0);
            prop_assert!(fast > touched - 0.051, "{fast} m against {touched} m");
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

    proptest! {
        #[test]
        fn short_cuts_meet_what_a_walk_cell_by_cell_meets(
            x0 in -0.5..6.5f32, y0 in -0.5..5.5f32, angle in 0.0..6.2f32, length in 0.0..2.0f32
        ) {
            let (_, walls) = room();
            let (dy, dx) = libm::sincosf(angle);
            let (x1, y1) = (x0 + length * dx, y0 + length * dy);
            let nudged = |by: f32| walls.met_cell_by_cell(x0 + by * dy, y0 - by * dx, x1 + by * dy, y1 - by * dx);
            let met = walls.met(x0, y0, x1, y1);
            // A way that grazes a corner by a hundredth of a millimetre may be on either side of it.
            prop_assert!([0.0, 1e-5, -1e-5].into_iter().any(|by| met == nudged(by)), "{met:?} for {:?}", nudged(0.0));
        }
    }

    /// A wall at x = 2 with a doorway at y 1..2 and a window at y 2..3, 10 cm cells.
    fn with_openings(door_nats: f64) -> Walls {
        let cell = |index: usize| match (index % 40, index / 40) {
            (20..22, 10..20) => Cell::Door,
            (20..22, 20..30) => Cell::Window,
            (20..22, _) => Cell::Wall,
            _ => Cell::Free,
        };
        let plan = FloorPlan::new(Pt2::new(0.0, 0.0), 0.1, 40, 40, (0..1600).map(cell).collect()).unwrap();
        Walls::new(&plan, GroundCosts { door_nats, ..GroundCosts::default() })
    }

    #[test]
    fn doors_are_walked_through_and_windows_are_not() {
        let walls = with_openings(0.02);
        assert_eq!(walls.met(1.5, 1.5, 2.7, 1.5), Met { walls: 0, doors: 1 });
        assert_eq!(walls.met(1.5, 2.5, 2.7, 2.5), Met { walls: 1, doors: 0 });
        assert_eq!(walls.met(1.5, 0.5, 2.7, 0.5), Met { walls: 1, doors: 0 });
        assert_eq!(walls.met(2.1, 1.5, 2.7, 1.5), Met::default(), "who starts in a doorway has paid for it");
        assert_eq!(walls.met(2.1, 1.5, 2.1, 2.5), Met { walls: 1, doors: 0 }, "from the doorway into the window beside it");
        assert!(!walls.is_wall(2.1, 1.5) && walls.is_wall(2.1, 2.5) && walls.wall_distance_key(2.1, 1.5) == 0);
        assert!(with_openings(0.5).door_nats() > walls.door_nats());
    }
}

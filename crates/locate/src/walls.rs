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
use rayon::prelude::*;

use crate::approx;

/// Distances are kept to this many cells: one byte in half cells, so that the field of a floor stays in the cache.
const FAR_CELLS: u8 = 127;

/// Rays end here: at 5 cm a cell, 50 km.
const FARTHEST_CELLS: f32 = 1e6;

/// What a metre costs (nats) away from what is surely the building's floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundCosts {
    /// On ground that is surely outside. Little: outlines are open, and walks begin where the plan ends.
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
    /// 20 m outside cost a factor of e, 3 m on unknown ground too; a wall's thickness costs a few per cent on top of the crossing.
    fn default() -> Self {
        Self {
            outside_nats_per_m: 0.05,
            unknown_nats_per_m: 0.3,
            door_nats: 0.02,
            in_wall_nats_per_m: 1.0,
            beyond_nats_per_m: 0.3,
            margin_m: 5.0,
        }
    }
}

/// What kind of ground a cell is: its kind and, for floor, how surely it is inside, in hundredths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Class(u8);

impl Class {
    const WALL: Self = Self(0);
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

/// What a look along a ray finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Metres to the first wall; the limit where none is nearer.
    pub wall_m: f32,
    /// Doorways and windows that it passes before.
    pub passed: u32,
}

/// The plan as the filter's inner loop wants it.
#[derive(Debug, Clone)]
pub struct Walls {
    cell_m: f32,
    per_m: f32,
    width: i32,
    height: i32,
    /// Half cells between this cell's centre and the nearest surface cell's; 0 in a surface. One byte a cell, for rays, which
    /// look at many cells …
    half_cells: Vec<u8>,
    /// … and for walkers, who look at one or two: half cells around the cell in which surely no surface is, and in the upper byte
    /// the class of the cell. One more at the end: beyond the grid.
    ground: Vec<u16>,
    /// Nats that a metre costs on each class of ground.
    nats_per_m: Vec<f32>,
    costs: GroundCosts,
    /// Whether there is a door or a window at all.
    openings: bool,
}

impl Walls {
    /// The walls of this plan. Takes a few passes over the grid.
    pub fn new(plan: &FloorPlan, costs: GroundCosts) -> Self {
        let surface = |cell: &Cell| cell.blocks() || *cell == Cell::Door;
        let mut surfaces: Vec<bool> = plan.cells().iter().map(surface).collect();
        let half_cells = distance_field(&surfaces, plan.width(), f64::round);
        // Two cells are as far apart as one's centre is from the nearest of the nine around the other.
        widen(&mut surfaces, plan.width());
        let clear = distance_field(&surfaces, plan.width(), f64::floor);
        let classes = plan.cells().iter().zip(plan.inside()).map(|(cell, inside)| Class::of(*cell, *inside));
        let record = |(clear, class): (&u8, Class)| u16::from(*clear) | u16::from(class.0) << 8;
        let ground = clear.iter().zip(classes).map(record).chain([u16::from(Class::BEYOND.0) << 8]).collect();
        Self {
            cell_m: plan.cell_m() as f32,
            per_m: (1.0 / plan.cell_m()) as f32,
            width: plan.width() as i32,
            height: plan.height() as i32,
            half_cells,
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
        (index & held) | (self.half_cells.len() as u32 & !held)
    }

    /// Which cell holds (x, y); `None` beyond the grid, and for what is not a number.
    #[inline]
    fn index(&self, x: f32, y: f32) -> Option<usize> {
        let index = self.cell_or_beyond(x, y) as usize;
        (index < self.half_cells.len()).then_some(index)
    }

    /// Distance from the cell at (x, y) to the nearest surface cell, in half cells, at most 254; `None` beyond the grid.
    #[inline]
    fn half_cells_at(&self, x: f32, y: f32) -> Option<u8> {
        self.index(x, y).map(|index| self.half_cells[index])
    }

    fn class(&self, index: usize) -> Class {
        Class((self.ground[index] >> 8) as u8)
    }

    /// Distance from (x, y) to the nearest wall, window or door in half cells, as a key for tables; beyond the grid 255.
    #[inline]
    pub fn wall_distance_key(&self, x: f32, y: f32) -> u8 {
        self.half_cells_at(x, y).unwrap_or(u8::MAX)
    }

    /// As [`Walls::wall_distance_key`], of a cell that [`Walls::cell_or_beyond`] named.
    #[inline(always)]
    pub(crate) fn key(&self, cell: u32) -> u8 {
        self.half_cells.get(cell as usize).copied().unwrap_or(u8::MAX)
    }

    /// Whether a cell that [`Walls::cell_or_beyond`] named is on the grid.
    #[inline(always)]
    pub(crate) fn is_held(&self, cell: u32) -> bool {
        (cell as usize) < self.half_cells.len()
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

    /// Metres from (x, y) in direction (dx, dy), unit, to the first wall; `limit_m` where none is nearer. Doors are open to it,
    /// and windows clear.
    pub fn cast(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> f32 {
        self.look(x, y, dx, dy, limit_m).wall_m
    }

    /// Looks from (x, y) in direction (dx, dy), unit, through doorways and windows to the first wall, `limit_m` far.
    ///
    /// Walks the distance field ("sphere tracing", Hart 1996). A start within a surface leaves it first.
    pub fn look(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> Look {
        let mut ray = self.ray(x, y, dx, dy, limit_m);
        while self.advance(&mut ray) {}
        let passed = self.see_through(&mut ray, f32::INFINITY);
        Look { wall_m: if ray.has_met() { ray.along * self.cell_m } else { limit_m }, passed }
    }

    /// A ray that stands at its start; to be moved by [`Walls::advance`].
    #[inline(always)]
    pub(crate) fn ray(&self, x: f32, y: f32, dx: f32, dy: f32, limit_m: f32) -> CastRay {
        // In cells: one multiplication less a step. Beyond the farthest, f32 no longer resolves a step.
        let limit = limit_m * self.per_m;
        let limit = if limit < FARTHEST_CELLS { limit } else { FARTHEST_CELLS };
        CastRay { x: x * self.per_m, y: y * self.per_m, dx, dy, along: 0.0, limit, left: false }
    }

    /// One step along the ray; `false` when it has met a surface or reached its end.
    #[inline(always)]
    pub(crate) fn advance(&self, ray: &mut CastRay) -> bool {
        let (column, row) = (ray.x + ray.dx * ray.along, ray.y + ray.dy * ray.along);
        // Also false where a coordinate is not a number.
        let held = (column >= 0.0) & (row >= 0.0) & (column < self.width as f32) & (row < self.height as f32);
        if !held {
            return self.advance_off_grid(ray, column, row);
        }
        let half_cells = self.half_cells[row as i32 as usize * self.width as usize + column as i32 as usize];
        // From anywhere in this cell the nearest surface's face is at least d − 1 cells off, and a surface is at least one cell
        // thick: d − 0.7 lands at most 0.3 cells into it, never behind it.
        let step = 0.5 * f32::from(half_cells) - 0.7;
        let step = if step > 0.7 { step } else { 0.7 };
        let met = (half_cells == 0) & ray.left;
        ray.left |= half_cells > 0;
        ray.along += if met { 0.0 } else { step };
        !met & (ray.along < ray.limit)
    }

    #[cold]
    fn advance_off_grid(&self, ray: &mut CastRay, column: f32, row: f32) -> bool {
        let (off_x, off_y) = ((-column).max(column - self.width as f32), (-row).max(row - self.height as f32));
        let back_x = off_x < 0.0 || (column < 0.0 && ray.dx > 0.0) || (column > 0.0 && ray.dx < 0.0);
        let back_y = off_y < 0.0 || (row < 0.0 && ray.dy > 0.0) || (row > 0.0 && ray.dy < 0.0);
        ray.left = true;
        // The grid is convex: who moves away from it does not come back, and nothing is nearer than its edge.
        ray.along = if back_x && back_y { ray.along + off_x.max(off_y).max(1.0) } else { ray.limit };
        ray.along < ray.limit
    }

    /// Lets a ray that has met a doorway or a window look on to what is behind, up to the first wall, and says through how many
    /// it saw. An opening that is met at `sure` cells or later may be what the ray ends on: it then counts as nothing met.
    #[inline]
    pub(crate) fn see_through(&self, ray: &mut CastRay, sure: f32) -> u32 {
        if self.openings && ray.has_met() { self.through_openings(ray, sure) } else { 0 }
    }

    fn through_openings(&self, ray: &mut CastRay, sure: f32) -> u32 {
        let cell = |ray: &CastRay| (ray.x + ray.dx * ray.along, ray.y + ray.dy * ray.along);
        let class = |(column, row): (f32, f32)| self.surface(floor(column), floor(row));
        let mut passed = 0;
        while ray.has_met() && class(cell(ray)).is_some_and(|c| c != Class::WALL) {
            if ray.along >= sure {
                ray.along = ray.limit;
                break;
            }
            passed += 1;
            // Through the glass or the doorway; a wall that it is set in may end the ray there.
            while ray.has_met() && class(cell(ray)).is_some_and(|c| c != Class::WALL) {
                ray.along += 0.7;
            }
            ray.left = true;
            if ray.has_met() {
                while self.advance(ray) {}
            }
        }
        passed
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
        let (mut column, mut row) = (floor(fx), floor(fy));
        let (last_column, last_row) = (floor(x1 * self.per_m), floor(y1 * self.per_m));
        let (step_x, step_y) = (if dx > 0.0 { 1 } else { -1 }, if dy > 0.0 { 1 } else { -1 });
        let first = |f: f32, d: f32| if d > 0.0 { (floor(f) as f32 + 1.0 - f) / d } else { (floor(f) as f32 - f) / d };
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
            let (size_x, size_y) = (self.width as f32 * self.cell_m, self.height as f32 * self.cell_m);
            let off = (-x).max(x - size_x).max(-y).max(y - size_y);
            let within = off <= self.costs.margin_m as f32;
            self.costs.beyond_nats_per_m as f32 * if within { 1.0 } else { 10.0 }
        };
        per_m * length_m
    }
}

/// A ray on its way, in cells.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CastRay {
    x: f32,
    y: f32,
    dx: f32,
    dy: f32,
    pub along: f32,
    pub limit: f32,
    /// Whether it has been anywhere but in the surface that it started in.
    pub left: bool,
}

impl CastRay {
    /// Whether there is a surface where it stopped.
    #[inline(always)]
    pub(crate) fn has_met(&self) -> bool {
        self.along < self.limit
    }
}

/// How many cells around any point of a cell are no surface.
#[inline(always)]
fn clear_cells(ground: u16) -> f32 {
    0.5 * f32::from(ground as u8)
}

/// The integer at or below; without a call into a library, which `f32::floor` is on older processors.
#[inline(always)]
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole.saturating_sub(i32::from(whole as f32 > value))
}

/// Exact Euclidean distance of every cell to the nearest surface cell, in half cells, capped (Felzenszwalb & Huttenlocher 2012:
/// columns first, then the lower envelope of parabolas along each row).
fn distance_field(surfaces: &[bool], width: usize, rounded: fn(f64) -> f64) -> Vec<u8> {
    let height = surfaces.len() / width.max(1);
    let mut down = vec![FAR_CELLS; surfaces.len()];
    for row in 0..height {
        for column in 0..width {
            let below = if row > 0 { down[(row - 1) * width + column].saturating_add(1) } else { FAR_CELLS };
            down[row * width + column] = if surfaces[row * width + column] { 0 } else { below.min(FAR_CELLS) };
        }
    }
    for row in (0..height.saturating_sub(1)).rev() {
        for column in 0..width {
            let above = down[(row + 1) * width + column].saturating_add(1);
            let here = &mut down[row * width + column];
            *here = above.min(*here);
        }
    }
    down.par_chunks_mut(width.max(1)).for_each(|row| envelope(row, rounded));
    down
}

/// Lets surfaces grow by a cell to all eight sides.
fn widen(surfaces: &mut [bool], width: usize) {
    let height = surfaces.len() / width.max(1);
    for row in surfaces.chunks_mut(width.max(1)) {
        let mut before = false;
        for column in 0..width {
            let here = row[column];
            row[column] |= before || row.get(column + 1).copied().unwrap_or(false);
            before = here;
        }
    }
    let narrow = surfaces.to_vec();
    for row in 0..height {
        for column in 0..width {
            let below = row > 0 && narrow[(row - 1) * width + column];
            surfaces[row * width + column] |= below || narrow.get((row + 1) * width + column).copied().unwrap_or(false);
        }
    }
}

/// From distances within columns (cells) to distances in the plane (half cells), for one row.
fn envelope(row: &mut [u8], rounded: fn(f64) -> f64) {
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
        *out = rounded(2.0 * cells).min(2.0 * f64::from(FAR_CELLS)) as u8;
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

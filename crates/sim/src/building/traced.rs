//! What world does a given plan describe? Its walls traced, its floor split into rooms, and lies told by changing cells.

use std::sync::Arc;

use planwalk_types::{Cell, FloorPlan, Plan, PlanError, Pt2, Seed, StreamRng, Wall};
use rand::RngExt;

use super::regions::{self, distance_to};
use super::tracing::Mask;
use super::{Building, Lies, PlanWorldOptions, Room, RoomKind};
use crate::error::SimError;

/// Cells finer than this are put together, metres.
const CELL_M: f64 = 0.05;
/// A cell is a wall where at least one in so many of the cells under it is: a line of 1 cm survives at 5 cm.
const WALL_SHARE: usize = 5;
/// A plan with less floor inside has no room to turn round in, m².
const LEAST_INSIDE_M2: f64 = 4.0;
/// A wall with nothing outdoors within this distance is an inner one, metres.
const INNER_M: f64 = 0.8;
/// Radius of a piece of wall that was never built, metres.
const GAP_M: f64 = 1.2;
/// Free way around a wall that nobody drew, metres.
const WAY_M: f64 = 1.3;
/// How far floors reach under walls, cells.
const FLOOR_CELLS: usize = 3;
/// Half of its thickness, metres.
const SCREEN_HALF_M: f64 = 0.075;

/// A plan and what was built after it, on one grid.
#[derive(Debug, PartialEq)]
pub(super) struct Traced {
    origin: Pt2<Plan>,
    cell_m: f64,
    width: usize,
    height: usize,
    /// The plan as given.
    pub drawn: Vec<Cell>,
    /// The walls that are there.
    pub built: Vec<Cell>,
    /// Room of each cell.
    rooms: Vec<u16>,
    /// The same, and a little into the walls.
    floor: Vec<u16>,
}

/// The world of a plan.
pub(super) fn build(plan: &FloorPlan, options: &PlanWorldOptions, seed: Seed) -> Result<Building, SimError> {
    let (mut traced, mut inside) = resample(plan);
    traced.lie(&options.lies, &mut inside, &mut seed.derive("lies", 0));
    let floor: Vec<bool> = (0..inside.len()).map(|i| inside[i] && traced.built[i] == Cell::Free).collect();
    let inside_count = floor.iter().filter(|f| **f).count();
    let area_m2 = |count: usize| count as f64 * traced.cell_m * traced.cell_m;
    if area_m2(inside_count) < LEAST_INSIDE_M2 {
        let free = traced.built.iter().filter(|c| **c == Cell::Free).count();
        return Err(SimError::NoInside { free_m2: area_m2(free), inside_m2: area_m2(inside_count) });
    }
    let clear = distance_to(|i| !floor[i], traced.width, traced.height);
    let (rooms, count) = regions::split(&floor, &clear, traced.width, traced.cell_m);
    traced.rooms = rooms;
    traced.floor = traced.floor_under_walls();
    let rooms = traced.describe_rooms(count, &clear);
    let walls = traced.walls();
    Ok(Building {
        drawn: walls.clone(),
        walls,
        rooms,
        thickness_m: 0.0,
        height_m: options.height_m,
        traced: Some(Arc::new(traced)),
        ..Building::empty()
    })
}

/// The plan with cells of at least [`CELL_M`], and which of them are inside.
fn resample(plan: &FloorPlan) -> (Traced, Vec<bool>) {
    let block = ((CELL_M / plan.cell_m() + 1e-6).floor() as usize).max(1);
    let (width, height) = (plan.width().div_ceil(block), plan.height().div_ceil(block));
    let (mut drawn, mut inside) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
    for y in 0..height {
        let rows = y * block..((y + 1) * block).min(plan.height());
        for x in 0..width {
            let columns = x * block..((x + 1) * block).min(plan.width());
            let (mut walls, mut unknown, mut free, mut within) = (0, 0, 0, 0.0);
            for row in rows.clone() {
                let line = row * plan.width();
                for i in line + columns.start..line + columns.end {
                    match plan.cells()[i] {
                        Cell::Wall | Cell::Window => walls += 1,
                        Cell::Unknown => unknown += 1,
                        Cell::Free | Cell::Door => {
                            free += 1;
                            within += plan.inside()[i];
                        }
                    }
                }
            }
            let all = walls + unknown + free;
            let is_wall = WALL_SHARE * walls >= all;
            drawn.push(if is_wall {
                Cell::Wall
            } else if unknown > free {
                Cell::Unknown
            } else {
                Cell::Free
            });
            inside.push(free > 0 && within > 0.5 * free as f32);
        }
    }
    let traced = Traced {
        origin: plan.origin(),
        cell_m: plan.cell_m() * block as f64,
        width,
        height,
        built: drawn.clone(),
        drawn,
        rooms: Vec::new(),
        floor: Vec::new(),
    };
    (traced, inside)
}

impl Traced {
    fn cell(&self, point: Pt2<Plan>) -> Option<usize> {
        let (u, v) = ((point.x - self.origin.x) / self.cell_m, (point.y - self.origin.y) / self.cell_m);
        let held = u >= 0.0 && v >= 0.0 && u < self.width as f64 && v < self.height as f64;
        held.then(|| v as usize * self.width + u as usize)
    }

    pub fn room_at(&self, point: Pt2<Plan>) -> Option<usize> {
        let room = self.rooms[self.cell(point)?];
        (room != regions::NONE).then_some(usize::from(room))
    }

    /// The room whose floor is seen at a place, [`regions::NONE`] where there is none.
    pub fn floor_at(&self, point: Pt2<Plan>) -> u16 {
        self.cell(point).map_or(regions::NONE, |i| self.floor[i])
    }

    /// The rooms, grown into the walls: surfaces were straightened, and no gap may show at their feet.
    fn floor_under_walls(&self) -> Vec<u16> {
        let mut floor = self.rooms.clone();
        for _ in 0..FLOOR_CELLS {
            let last = floor.clone();
            for i in (0..floor.len()).filter(|i| last[*i] == regions::NONE && self.built[*i] == Cell::Wall) {
                let near = regions::neighbours(i, self.width, floor.len()).map(|k| last[k]).find(|room| *room != regions::NONE);
                floor[i] = near.unwrap_or(regions::NONE);
            }
        }
        floor
    }

    pub fn is_wall(&self, point: Pt2<Plan>) -> bool {
        self.cell(point).is_some_and(|i| self.built[i] == Cell::Wall)
    }

    /// Whether the first place behind a wall that is no wall is no room; `behind` gives the place so many metres behind.
    pub fn outdoors_behind(&self, behind: impl Fn(f64) -> Pt2<Plan>) -> bool {
        let first = (1..=16).map(|k| behind(0.05 * f64::from(k))).find(|p| !self.is_wall(*p));
        first.is_some_and(|p| self.room_at(p).is_none())
    }

    /// A grid of these cells around the drawn walls and a margin.
    ///
    /// # Errors
    /// As [`FloorPlan::new`].
    pub fn plan(&self, cells: &[Cell], cell_m: f64, margin_m: f64) -> Result<FloorPlan, PlanError> {
        let walls = || (0..self.drawn.len()).filter(|i| self.drawn[*i] == Cell::Wall).map(|i| (i % self.width, i / self.width));
        let low = walls().fold((usize::MAX, usize::MAX), |l, p| (l.0.min(p.0), l.1.min(p.1)));
        let high = walls().fold((0, 0), |h, p| (h.0.max(p.0 + 1), h.1.max(p.1 + 1)));
        if low.0 == usize::MAX {
            return Err(PlanError::NoWalls);
        }
        let corner =
            |c: (usize, usize)| Pt2::<Plan>::new(self.origin.x + c.0 as f64 * self.cell_m, self.origin.y + c.1 as f64 * self.cell_m);
        let grid = FloorPlan::from_walls(&[Wall { from: corner(low), to: corner(high) }], cell_m, margin_m)?;
        let mut result = vec![Cell::Free; grid.cells().len()];
        if cell_m <= self.cell_m {
            for (i, cell) in result.iter_mut().enumerate() {
                let centre = grid.centre(i % grid.width(), i / grid.width());
                *cell = self.cell(centre).map_or(Cell::Free, |k| cells[k]);
            }
        } else {
            // Walls count before the unknown, and that before free floor.
            for (k, cell) in cells.iter().enumerate().filter(|(_, cell)| **cell != Cell::Free) {
                let centre = corner((k % self.width, k / self.width));
                let half_m = 0.5 * self.cell_m;
                if let Some((column, row)) = grid.cell_at(Pt2::new(centre.x + half_m, centre.y + half_m)) {
                    let target = &mut result[row * grid.width() + column];
                    *target = if *target == Cell::Wall { Cell::Wall } else { *cell };
                }
            }
        }
        FloorPlan::new(grid.origin(), cell_m, grid.width(), grid.height(), result)
    }

    /// The surfaces of what is built.
    fn walls(&self) -> Vec<Wall> {
        let cells: Vec<bool> = self.built.iter().map(|c| *c == Cell::Wall).collect();
        let mask = Mask { cells: &cells, width: self.width, height: self.height };
        let point = |p: &[f64; 2]| Pt2::<Plan>::new(self.origin.x + p[0] * self.cell_m, self.origin.y + p[1] * self.cell_m);
        let mut walls = Vec::new();
        for outline in mask.outlines() {
            for (i, p) in outline.iter().enumerate() {
                walls.push(Wall { from: point(p), to: point(&outline[(i + 1) % outline.len()]) });
            }
        }
        walls
    }

    /// What each region is for, by its size and shape, and its outline.
    fn describe_rooms(&self, count: usize, clear: &[f32]) -> Vec<Room> {
        let mut areas = vec![0usize; count];
        let mut widest = vec![0.0f32; count];
        let mut boxes = vec![[usize::MAX, usize::MAX, 0, 0]; count];
        for (i, room) in self.rooms.iter().enumerate().filter(|(_, room)| **room != regions::NONE) {
            let room = usize::from(*room);
            let (x, y) = (i % self.width, i / self.width);
            areas[room] += 1;
            widest[room] = widest[room].max(clear[i]);
            let b = &mut boxes[room];
            *b = [b[0].min(x), b[1].min(y), b[2].max(x + 1), b[3].max(y + 1)];
        }
        (0..count)
            .map(|room| {
                let area_m2 = areas[room] as f64 * self.cell_m * self.cell_m;
                let width_m = 2.0 * f64::from(widest[room]) * self.cell_m;
                Room { kind: kind_of(area_m2, width_m), outline: self.outline(room as u16, boxes[room]) }
            })
            .collect()
    }

    /// The longest outline of a region; columns that stand in it are not taken out.
    fn outline(&self, room: u16, [x0, y0, x1, y1]: [usize; 4]) -> Vec<Pt2<Plan>> {
        let (width, height) = (x1 - x0, y1 - y0);
        let cells: Vec<bool> = (0..width * height).map(|i| self.rooms[(y0 + i / width) * self.width + x0 + i % width] == room).collect();
        let outlines = Mask { cells: &cells, width, height }.outlines();
        let area = |line: &Vec<[f64; 2]>| -> f64 {
            (0..line.len()).map(|i| (line[i], line[(i + 1) % line.len()])).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
        };
        let outer = outlines.into_iter().max_by(|a, b| area(a).total_cmp(&area(b))).unwrap_or_default();
        let at = |p: [f64; 2]| {
            Pt2::<Plan>::new(self.origin.x + (x0 as f64 + p[0]) * self.cell_m, self.origin.y + (y0 as f64 + p[1]) * self.cell_m)
        };
        outer.into_iter().map(at).collect()
    }

    /// Takes out pieces of inner walls, and puts up walls that nobody drew.
    fn lie(&mut self, lies: &Lies, inside: &mut [bool], rng: &mut StreamRng) {
        if lies.missing_share > 0.0 {
            let to_outdoors = distance_to(|i| self.drawn[i] != Cell::Wall && !inside[i], self.width, self.height);
            let inner_cells = (INNER_M / self.cell_m) as f32;
            let is_inner = |i: usize| self.drawn[i] == Cell::Wall && to_outdoors[i] > inner_cells;
            let inner: Vec<usize> = (0..self.drawn.len()).filter(|i| is_inner(*i)).collect();
            let wanted = (lies.missing_share * inner.len() as f64).round() as usize;
            let mut removed = 0;
            // Most draws hit a wall that still stands; the bound is for shares near 1.
            for _ in 0..20 * inner.len() {
                if removed >= wanted {
                    break;
                }
                let centre = inner[rng.random_range(0..inner.len())];
                if self.built[centre] != Cell::Wall {
                    continue;
                }
                for i in self.disc(centre, GAP_M) {
                    if is_inner(i) && self.built[i] == Cell::Wall {
                        self.built[i] = Cell::Free;
                        inside[i] = true;
                        removed += 1;
                    }
                }
            }
        }
        for _ in 0..lies.extra_count {
            self.put_up_screen(inside, rng);
        }
    }

    /// A wall of 1 m to 2.5 m that one can walk around; none where there is no room for it.
    fn put_up_screen(&mut self, inside: &[bool], rng: &mut StreamRng) {
        let blocked = distance_to(|i| self.built[i] != Cell::Free || !inside[i], self.width, self.height);
        let least = ((WAY_M + SCREEN_HALF_M) / self.cell_m) as f32;
        let roomy: Vec<usize> = (0..blocked.len()).filter(|i| blocked[*i] >= least).collect();
        if roomy.is_empty() {
            return;
        }
        for _ in 0..60 {
            let start = roomy[rng.random_range(0..roomy.len())];
            let (level, length_m) = (rng.random_range(0.0..1.0) < 0.5, rng.random_range(1.0..2.5));
            let count = (length_m / self.cell_m).round() as usize;
            let (x, y) = (start % self.width, start / self.width);
            let along = |k: usize| if level { (x + k, y) } else { (x, y + k) };
            let end = along(count);
            let fits = end.0 < self.width && end.1 < self.height;
            if !fits || !(0..=count).all(|k| blocked[along(k).1 * self.width + along(k).0] >= least) {
                continue;
            }
            let half = (SCREEN_HALF_M / self.cell_m).round() as usize;
            for k in 0..=count {
                for t in 0..=2 * half {
                    // In range: the free way around is wider than half of the wall.
                    let (cx, cy) = if level { (x + k, y + t - half) } else { (x + t - half, y + k) };
                    self.built[cy * self.width + cx] = Cell::Wall;
                }
            }
            return;
        }
    }

    /// The cells within a radius of a cell.
    fn disc(&self, centre: usize, radius_m: f64) -> Vec<usize> {
        let reach = (radius_m / self.cell_m) as usize;
        let (x, y) = (centre % self.width, centre / self.width);
        let near = |cx: usize, cy: usize| cx.abs_diff(x).pow(2) + cy.abs_diff(y).pow(2) <= reach * reach;
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(self.width);
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(self.height);
        rows.flat_map(|cy| columns.clone().map(move |cx| (cx, cy)))
            .filter(|(cx, cy)| near(*cx, *cy))
            .map(|(cx, cy)| cy * self.width + cx)
            .collect()
    }
}

/// What a piece of floor is likely to be for.
fn kind_of(area_m2: f64, width_m: f64) -> RoomKind {
    // A square has a ratio of 1, a room twice as long as wide 2.
    let long = area_m2 / (width_m * width_m).max(0.01) > 4.0;
    match area_m2 {
        a if a > 80.0 => RoomKind::Open,
        _ if long => RoomKind::Corridor,
        a if a > 30.0 => RoomKind::Hall,
        a if a < 7.0 => RoomKind::Store,
        _ => RoomKind::Office,
    }
}

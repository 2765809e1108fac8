//! What does the building look like from above? Walls on a metric grid, with inside told from outside.
//!
//! Row 0 is the **bottom** row (y up), unlike an image. A plan is finite and metric; whether it is plausible is another question.

use serde::{Deserialize, Serialize};

use crate::space::{Plan, Pt2};

/// What a piece of floor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// Nothing drawn: one may walk here.
    Free,
    /// A wall.
    Wall,
    /// The plan says that it does not know (a robot's map). One may walk here, but nobody was seen to.
    Unknown,
    /// A doorway: one may walk here; open, one sees through it, shut, the leaf is seen.
    Door,
    /// Glass: nobody walks through it, and one may see it or what is behind.
    Window,
}

impl Cell {
    /// Whether it stops who walks: walls and windows.
    pub fn blocks(self) -> bool {
        matches!(self, Self::Wall | Self::Window)
    }

    /// Whether it is floor for sure: free ground and doorways.
    pub fn is_floor(self) -> bool {
        matches!(self, Self::Free | Self::Door)
    }
}

/// A straight piece of wall, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// One end.
    pub from: Pt2<Plan>,
    /// The other end.
    pub to: Pt2<Plan>,
}

/// Why something is no floor plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error, Serialize, Deserialize)]
pub enum PlanError {
    /// The size of the data and the stated size differ.
    #[error("{got} cells given for a plan of {width}×{height}")]
    SizeMismatch {
        /// Cells given.
        got: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The metres are no metres.
    #[error("a cell of {cell_m} m is not a scale: it must be finite, positive and at most 10 m")]
    BadScale {
        /// Side of a cell.
        cell_m: f64,
    },
    /// Nothing to bump into or to see.
    #[error(
        "the plan has no walls: with nothing to see or to bump into, every place is as good as any other; is it inverted, or drawn too faintly?"
    )]
    NoWalls,
    /// Nowhere to walk.
    #[error("the plan is all wall: there is nowhere to walk; is it inverted?")]
    NoFreeSpace,
    /// Too many cells.
    #[error("a plan of {width}×{height} cells of {cell_m} m is over the limit of {limit} cells: is the scale right?")]
    TooLarge {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Side of a cell.
        cell_m: f64,
        /// Most cells that a plan may have.
        limit: usize,
    },
}

/// Walls and free space on a square grid, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct FloorPlan {
    origin: Pt2<Plan>,
    cell_m: f64,
    width: usize,
    height: usize,
    cells: Vec<Cell>,
    inside: Vec<f32>,
}

/// Most cells of a plan: a 1 km × 1 km site at 10 cm.
const CELL_LIMIT: usize = 100_000_000;

impl FloorPlan {
    /// The plan of these cells, row 0 at the bottom, whose bottom-left corner is `origin`.
    ///
    /// # Errors
    /// [`PlanError`]: a wrong size, a scale that is none, no walls, nowhere to walk.
    pub fn new(origin: Pt2<Plan>, cell_m: f64, width: usize, height: usize, cells: Vec<Cell>) -> Result<Self, PlanError> {
        if width.checked_mul(height) != Some(cells.len()) {
            return Err(PlanError::SizeMismatch { got: cells.len(), width, height });
        }
        if !(cell_m > 0.0 && cell_m <= 10.0 && origin.x.is_finite() && origin.y.is_finite()) {
            return Err(PlanError::BadScale { cell_m });
        }
        if cells.len() > CELL_LIMIT {
            return Err(PlanError::TooLarge { width, height, cell_m, limit: CELL_LIMIT });
        }
        if !cells.iter().any(|c| c.blocks()) {
            return Err(PlanError::NoWalls);
        }
        if cells.iter().all(|c| c.blocks()) {
            return Err(PlanError::NoFreeSpace);
        }
        let inside = inside::probability(cell_m, width, height, &cells);
        Ok(Self { origin, cell_m, width, height, cells, inside })
    }

    /// The plan of these walls, drawn one cell thick on a grid with `margin_m` of free space around them.
    ///
    /// # Errors
    /// As [`FloorPlan::new`]; walls that are not finite count as [`PlanError::BadScale`].
    pub fn from_walls(walls: &[Wall], cell_m: f64, margin_m: f64) -> Result<Self, PlanError> {
        let ends = || walls.iter().flat_map(|w| [w.from, w.to]);
        if walls.is_empty() {
            return Err(PlanError::NoWalls);
        }
        let low = ends().fold((f64::INFINITY, f64::INFINITY), |l, p| (l.0.min(p.x), l.1.min(p.y)));
        let high = ends().fold((f64::NEG_INFINITY, f64::NEG_INFINITY), |h, p| (h.0.max(p.x), h.1.max(p.y)));
        let finite = ends().all(|p| p.x.is_finite() && p.y.is_finite()) && margin_m.is_finite();
        if !(finite && cell_m > 0.0 && cell_m <= 10.0) {
            return Err(PlanError::BadScale { cell_m });
        }
        let origin = Pt2::new(low.0 - margin_m, low.1 - margin_m);
        let size = |low: f64, high: f64| ((high - low + 2.0 * margin_m) / cell_m).ceil().max(1.0) as usize + 1;
        let (width, height) = (size(low.0, high.0), size(low.1, high.1));
        if width.saturating_mul(height) > CELL_LIMIT {
            return Err(PlanError::TooLarge { width, height, cell_m, limit: CELL_LIMIT });
        }
        let mut cells = vec![Cell::Free; width * height];
        for wall in walls {
            let length = wall.from.distance(wall.to);
            // Half-cell steps leave no gap, not even diagonally.
            let count = (2.0 * length / cell_m).ceil().max(1.0) as usize;
            for i in 0..=count {
                let t = i as f64 / count as f64;
                let column = ((wall.from.x + t * (wall.to.x - wall.from.x) - origin.x) / cell_m) as usize;
                let row = ((wall.from.y + t * (wall.to.y - wall.from.y) - origin.y) / cell_m) as usize;
                cells[row.min(height - 1) * width + column.min(width - 1)] = Cell::Wall;
            }
        }
        Self::new(origin, cell_m, width, height, cells)
    }

    /// Bottom-left corner, metres.
    pub fn origin(&self) -> Pt2<Plan> {
        self.origin
    }

    /// Side of a cell, metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All cells, row by row from the bottom.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// How surely each cell is inside the building, 0..=1, row by row from the bottom; walls and unknown cells are 0.
    ///
    /// A matter of degree, because outlines are open: it is the share of directions in which a wall is met, scaled so that
    /// half of the horizon or less is outside and 85 % or more is inside.
    pub fn inside(&self) -> &[f32] {
        &self.inside
    }

    /// Column and row of the cell that holds this point; `None` outside the grid.
    pub fn cell_at(&self, point: Pt2<Plan>) -> Option<(usize, usize)> {
        let column = ((point.x - self.origin.x) / self.cell_m).floor();
        let row = ((point.y - self.origin.y) / self.cell_m).floor();
        let held = column >= 0.0 && row >= 0.0 && column < self.width as f64 && row < self.height as f64;
        held.then_some((column as usize, row as usize))
    }

    /// What is at this point; beyond the grid is [`Cell::Unknown`].
    pub fn at(&self, point: Pt2<Plan>) -> Cell {
        self.cell_at(point).map_or(Cell::Unknown, |(column, row)| self.cells[row * self.width + column])
    }

    /// Centre of a cell.
    pub fn centre(&self, column: usize, row: usize) -> Pt2<Plan> {
        Pt2::new(self.origin.x + (column as f64 + 0.5) * self.cell_m, self.origin.y + (row as f64 + 0.5) * self.cell_m)
    }

    /// Width and height in metres.
    pub fn size_m(&self) -> (f64, f64) {
        (self.width as f64 * self.cell_m, self.height as f64 * self.cell_m)
    }

    /// Floor that is likelier inside than outside, m².
    pub fn inside_area_m2(&self) -> f64 {
        self.inside.iter().filter(|p| **p > 0.5).count() as f64 * self.cell_m * self.cell_m
    }
}

mod inside {
    //! Which free cells are inside? Those that see walls nearly all around.

    use super::Cell;

    /// Directions looked in. 64 tell a 2 m opening (at 5 m: 4 directions) from a missing side.
    const DIRECTIONS: usize = 64;
    /// Coarse cell of the map of enclosure, metres: the measure changes over the width of a corridor, not of a wall.
    const COARSE_M: f64 = 0.25;
    /// Most coarse cells: what the largest plan of 5 cm has. A map of roads, whose own cells are coarse, would have five times as many,
    /// and take a minute.
    const MOST_COARSE: f64 = 4e6;

    pub(super) fn probability(cell_m: f64, width: usize, height: usize, cells: &[Cell]) -> Vec<f32> {
        let fewest = (cells.len() as f64 / MOST_COARSE).sqrt().ceil();
        let block = (COARSE_M / cell_m).round().max(fewest).max(1.0) as usize;
        let (columns, rows) = (width.div_ceil(block), height.div_ceil(block));
        let mut wall = vec![false; columns * rows];
        for (i, cell) in cells.iter().enumerate() {
            // Doors enclose as walls do: a room with an open door is a room.
            if *cell == Cell::Door || cell.blocks() {
                wall[i / width / block * columns + i % width / block] = true;
            }
        }
        let enclosed = enclosure(&wall, columns, rows);
        let graded = |e: f32| ((e - 0.5) / 0.35).clamp(0.0, 1.0);
        let at = |i: usize| if cells[i].is_floor() { graded(enclosed[i / width / block * columns + i % width / block]) } else { 0.0 };
        (0..cells.len()).map(at).collect()
    }

    /// Share of directions in which a wall is met before the grid ends, for each cell.
    ///
    /// Each direction is swept along the grid's digital lines, every cell lying on just one of them, so the cost is linear in the
    /// cells, whatever the distance to the walls.
    fn enclosure(wall: &[bool], columns: usize, rows: usize) -> Vec<f32> {
        let mut hits = vec![0u16; wall.len()];
        for i in 0..DIRECTIONS {
            let (s, c) = libm::sincos((i as f64 + 0.5) * std::f64::consts::TAU / DIRECTIONS as f64);
            // The longer axis is walked cell by cell; the other follows by the slope.
            let steep = s.abs() > c.abs();
            let (long, short) = if steep { (rows, columns) } else { (columns, rows) };
            let (ahead, slope) = if steep { (s > 0.0, c / s) } else { (c > 0.0, s / c) };
            let shift = |k: usize| libm::floor(slope * k as f64) as isize;
            let reach = shift(long.saturating_sub(1));
            for line in -reach.max(0)..short as isize - reach.min(0) {
                let mut met = false;
                for step in 0..long {
                    // Against the direction of the look: what was met so far lies ahead of the cell.
                    let k = if ahead { long - 1 - step } else { step };
                    let across = line + shift(k);
                    if across < 0 || across >= short as isize {
                        // Lines enter the grid once and leave it once, so nothing was met outside.
                        continue;
                    }
                    let cell = if steep { k * columns + across as usize } else { across as usize * columns + k };
                    met |= wall[cell];
                    hits[cell] += u16::from(met);
                }
            }
        }
        hits.into_iter().map(|h| f32::from(h) / DIRECTIONS as f32).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
        Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) }
    }

    /// A 10 m × 2 m corridor whose right end is open.
    fn open_corridor() -> FloorPlan {
        let walls = [wall(0.0, 0.0, 10.0, 0.0), wall(0.0, 2.0, 10.0, 2.0), wall(0.0, 0.0, 0.0, 2.0)];
        FloorPlan::from_walls(&walls, 0.05, 3.0).unwrap()
    }

    fn inside_at(plan: &FloorPlan, x: f64, y: f64) -> f32 {
        let (column, row) = plan.cell_at(Pt2::new(x, y)).unwrap();
        plan.inside()[row * plan.width() + column]
    }

    #[test]
    fn inside_is_told_from_outside_though_the_outline_is_open() {
        let plan = open_corridor();
        assert!(inside_at(&plan, 5.0, 1.0) > 0.9, "the middle of the corridor");
        assert!(inside_at(&plan, 5.0, 4.0) < 0.1, "in front of the building");
        assert!(inside_at(&plan, 12.5, 1.0) < 0.1, "past the open end");
    }

    #[test]
    fn inside_is_the_same_from_every_side() {
        // The corridor turned by quarters: the sweep must treat all directions alike.
        let centre = inside_at(&open_corridor(), 9.0, 1.0);
        for quarter in 1..4 {
            let turned = |x: f64, y: f64| match quarter {
                1 => (-y, x),
                2 => (-x, -y),
                _ => (y, -x),
            };
            let turned_wall = |w: [f64; 4]| {
                let (from, to) = (turned(w[0], w[1]), turned(w[2], w[3]));
                wall(from.0, from.1, to.0, to.1)
            };
            let walls = [[0.0, 0.0, 10.0, 0.0], [0.0, 2.0, 10.0, 2.0], [0.0, 0.0, 0.0, 2.0]].map(turned_wall);
            let plan = FloorPlan::from_walls(&walls, 0.05, 3.0).unwrap();
            let (x, y) = turned(9.0, 1.0);
            // Coarse cells of 25 cm fall differently on the turned walls: a few of the 64 directions.
            assert!((inside_at(&plan, x, y) - centre).abs() < 0.2, "quarter {quarter}: {} for {centre}", inside_at(&plan, x, y));
        }
    }

    #[test]
    fn walls_are_where_they_were_drawn() {
        let plan = open_corridor();
        assert_eq!(plan.at(Pt2::new(5.0, 0.01)), Cell::Wall);
        assert_eq!(plan.at(Pt2::new(5.0, 1.0)), Cell::Free);
        assert_eq!(plan.at(Pt2::new(500.0, 1.0)), Cell::Unknown);
        let (column, row) = plan.cell_at(Pt2::new(5.0, 1.0)).unwrap();
        assert!(plan.centre(column, row).distance(Pt2::new(5.0, 1.0)) < 0.05);
    }

    #[test]
    fn what_is_no_plan_is_refused() {
        let of = |cells: Vec<Cell>, cell_m: f64| FloorPlan::new(Pt2::new(0.0, 0.0), cell_m, 2, 2, cells);
        assert_eq!(of(vec![Cell::Free; 4], 0.1), Err(PlanError::NoWalls));
        assert_eq!(of(vec![Cell::Wall; 4], 0.1), Err(PlanError::NoFreeSpace));
        assert!(matches!(of(vec![Cell::Wall; 3], 0.1), Err(PlanError::SizeMismatch { got: 3, .. })));
        assert!(matches!(of(vec![Cell::Wall; 4], f64::NAN), Err(PlanError::BadScale { .. })));
        assert_eq!(FloorPlan::from_walls(&[], 0.1, 1.0), Err(PlanError::NoWalls));
        assert!(FloorPlan::from_walls(&[wall(0.0, 0.0, 1e9, 1e9)], 0.1, 1.0).is_err());
    }
}

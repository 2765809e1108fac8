//! How do pixels become the plan's cells? Coarsened, and turned upright, without losing a wall.

use planwalk_types::{Cell, Pt2};

/// Smallest side of a cell: walls and people are known no better, and the cost of everything grows with its square.
const FINEST_M: f64 = 0.05;

/// A classified picture: row 0 at the **top**.
pub(super) struct Pixels {
    pub width: usize,
    pub height: usize,
    pub cells: Vec<Cell>,
}

/// Cells of a plan: row 0 at the **bottom**.
pub(super) struct Cells {
    pub cell_m: f64,
    pub width: usize,
    pub height: usize,
    pub cells: Vec<Cell>,
}

impl Pixels {
    /// Cells of whole blocks of pixels, at least [`FINEST_M`] wide, counted from the bottom-left corner.
    ///
    /// A block with any wall is wall, else with anything free is free: thin walls stay closed.
    pub fn coarsen(&self, metres_per_pixel: f64, notes: &mut Vec<String>) -> Cells {
        // A pixel of 0.049999 m is 5 cm: a hair of tolerance keeps it from being doubled.
        let block = (FINEST_M / metres_per_pixel - 0.01).ceil().clamp(1.0, 1e9) as usize;
        let cell_m = block as f64 * metres_per_pixel;
        let (width, height) = (self.width.div_ceil(block), self.height.div_ceil(block));
        let mut cells = vec![Cell::Unknown; width * height];
        for (v, row) in self.cells.chunks_exact(self.width).enumerate() {
            let out = &mut cells[(self.height - 1 - v) / block * width..][..width];
            for (cell, pixels) in out.iter_mut().zip(row.chunks(block)) {
                for pixel in pixels {
                    *cell = strongest(*cell, *pixel);
                }
            }
        }
        if block > 1 {
            notes.push(format!("{block}×{block} pixels make one cell of {cell_m:.3} m; a cell with any wall in it is wall"));
        }
        Cells { cell_m, width, height, cells }
    }
}

fn strongest(a: Cell, b: Cell) -> Cell {
    match (a, b) {
        (Cell::Wall, _) | (_, Cell::Wall) => Cell::Wall,
        (Cell::Window, _) | (_, Cell::Window) => Cell::Window,
        (Cell::Door, _) | (_, Cell::Door) => Cell::Door,
        (Cell::Free, _) | (_, Cell::Free) => Cell::Free,
        (Cell::Unknown, Cell::Unknown) => Cell::Unknown,
    }
}

impl Cells {
    /// The same plan on a grid whose axes are the plan's, when its own are turned by `yaw_rad` about its bottom-left corner
    /// `corner`. Gives the new grid and its bottom-left corner.
    ///
    /// Free and unknown are looked up (each new cell asks what is at its centre); walls are cast forward, nine points a cell,
    /// so that none gets holes. They grow by at most one cell.
    pub fn turned<F>(self, corner: Pt2<F>, yaw_rad: f64) -> (Self, Pt2<F>) {
        let (s, c) = yaw_rad.sin_cos();
        let m = self.cell_m;
        // Plan coordinates of a point of the old grid, in cells.
        let to_plan = |x: f64, y: f64| (corner.x + m * (c * x - s * y), corner.y + m * (s * x + c * y));
        let (w, h) = (self.width as f64, self.height as f64);
        let corners = [to_plan(0.0, 0.0), to_plan(w, 0.0), to_plan(0.0, h), to_plan(w, h)];
        let low = corners.iter().fold((f64::INFINITY, f64::INFINITY), |l, p| (l.0.min(p.0), l.1.min(p.1)));
        let high = corners.iter().fold((f64::NEG_INFINITY, f64::NEG_INFINITY), |l, p| (l.0.max(p.0), l.1.max(p.1)));
        // The hair keeps a quarter turn, whose corners are off by round-off, from getting an empty row.
        let count = |low: f64, high: f64| ((high - low) / m - 1e-6).ceil().max(1.0) as usize;
        let (width, height) = (count(low.0, high.0), count(low.1, high.1));
        let mut cells = vec![Cell::Unknown; width * height];
        for (i, cell) in cells.iter_mut().enumerate() {
            let (dx, dy) = (low.0 + ((i % width) as f64 + 0.5) * m - corner.x, low.1 + ((i / width) as f64 + 0.5) * m - corner.y);
            let (x, y) = ((c * dx + s * dy) / m, (c * dy - s * dx) / m);
            if x >= 0.0 && y >= 0.0 && x < w && y < h {
                *cell = self.cells[y as usize * self.width + x as usize];
            }
        }
        for (i, _) in self.cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Wall) {
            for k in 0..9 {
                let (x, y) = to_plan((i % self.width) as f64 + THIRDS[k % 3], (i / self.width) as f64 + THIRDS[k / 3]);
                let (column, row) = (((x - low.0) / m) as usize, ((y - low.1) / m) as usize);
                cells[row.min(height - 1) * width + column.min(width - 1)] = Cell::Wall;
            }
        }
        (Self { cell_m: m, width, height, cells }, Pt2::new(low.0, low.1))
    }
}

/// Centres of the thirds of a cell's side.
const THIRDS: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Plan;

    const W: Cell = Cell::Wall;
    const F: Cell = Cell::Free;
    const U: Cell = Cell::Unknown;

    #[test]
    fn fine_pixels_are_gathered_from_the_bottom_left() {
        let pixels = Pixels { width: 3, height: 3, cells: vec![F, F, W, U, U, F, U, U, F] };
        let cells = pixels.coarsen(0.025, &mut Vec::new());
        assert_eq!((cells.width, cells.height, cells.cell_m), (2, 2, 0.05));
        assert_eq!(cells.cells, [U, F, F, W]);
    }

    #[test]
    fn coarse_pixels_stay_as_they_are_but_upside_up() {
        let pixels = Pixels { width: 2, height: 2, cells: vec![W, F, U, F] };
        let cells = pixels.coarsen(0.05, &mut Vec::new());
        assert_eq!((cells.cells, cells.cell_m), (vec![U, F, W, F], 0.05));
    }

    #[test]
    fn a_quarter_turn_is_exact() {
        // Old axes: x along the plan's y. The wall at old (1, 0) stands one cell up from the corner.
        let cells = Cells { cell_m: 1.0, width: 3, height: 1, cells: vec![F, W, U] };
        let (turned, corner) = cells.turned(Pt2::<Plan>::new(5.0, 2.0), std::f64::consts::FRAC_PI_2);
        assert_eq!((turned.width, turned.height), (1, 3));
        assert_eq!(turned.cells, [F, W, U]);
        assert!(corner.distance(Pt2::new(4.0, 2.0)) < 1e-12, "{corner:?}");
    }

    #[test]
    fn a_slanted_wall_has_no_holes() {
        let mut cells = vec![F; 60 * 21];
        cells[60 * 10..60 * 11].fill(W);
        let (turned, _) = Cells { cell_m: 0.1, width: 60, height: 21, cells }.turned(Pt2::<Plan>::new(0.0, 0.0), 0.4);
        // Walking along the wall by a tenth of a cell, every point is wall.
        for i in 5..595 {
            let (x, y) = (0.1 * f64::from(i), 10.5);
            let (s, c) = 0.4f64.sin_cos();
            let (px, py) = (c * x - s * y + 21.0 * s, s * x + c * y);
            let column = px as usize;
            assert_eq!(turned.cells[py as usize * turned.width + column], W, "at {x} cells along");
        }
    }
}

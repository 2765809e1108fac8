//! How far can one see at most from around each spot of the plan, in each direction?
//!
//! Walls ──cast from every cell, every direction──▶ the largest of the neighbours' distances to a wall, one byte each
//!
//! Each direction is an image of its own, so that one sighting reads it row by row, whatever the pose.

use rayon::prelude::*;

use crate::walls::Walls;

/// Smallest side of a cell, metres: no wider than what walls and ranges are uncertain by.
const CELL_M: f32 = 0.2;
/// Most cells: each takes a byte a direction, twice while they are made. On sites of more than four hectares sides grow.
const CELLS_MAX: f32 = 1e6;
/// Directions: 2° apart; with its neighbours each covers ± 3°.
pub(crate) const DIRECTIONS: usize = 180;
/// Metres in a unit of the images.
pub(crate) const UNIT_M: f32 = 0.06;
/// Farthest that is told apart, metres.
pub(crate) const REACH_M: f32 = 255.0 * UNIT_M;
/// Ground beyond the plan's grid that is a place too, metres: outlines are open, and walks begin where the plan ends.
const MARGIN_M: f32 = 2.0;
/// Cells are kept in lanes of so many.
pub(crate) const LANES: usize = 32;

/// Largest distance to the first wall from around each cell, for each direction: whatever is farther off is behind a wall.
#[derive(Debug, Clone)]
pub(crate) struct Horizon {
    /// Cells of a row, a multiple of [`LANES`], and rows.
    pub width: usize,
    pub height: usize,
    /// Side of a cell, metres.
    pub cell_m: f32,
    /// Of each direction an image.
    images: Vec<Vec<u8>>,
}

impl Horizon {
    /// Looks around everywhere: some fifty million casts a hectare.
    pub(crate) fn new(walls: &Walls) -> Self {
        let (size_x, size_y) = walls.size_m();
        let (size_x, size_y) = (size_x + 2.0 * MARGIN_M, size_y + 2.0 * MARGIN_M);
        let cell_m = CELL_M.max((size_x * size_y / CELLS_MAX).sqrt());
        let count = |size: f32| (size / cell_m).ceil().max(1.0) as usize;
        let (width, height) = (count(size_x).div_ceil(LANES) * LANES, count(size_y));
        let mut horizon = Self { width, height, cell_m, images: Vec::new() };
        let exact: Vec<Vec<u8>> = (0..DIRECTIONS).into_par_iter().map(|k| horizon.cast_all(walls, k)).collect();
        let around = |k: usize| [DIRECTIONS - 1, 0, 1].map(|d| exact[(k + d) % DIRECTIONS].as_slice());
        horizon.images = (0..DIRECTIONS).into_par_iter().map(|k| largest(around(k), width)).collect();
        horizon
    }

    fn cast_all(&self, walls: &Walls, direction: usize) -> Vec<u8> {
        let (s, c) = libm::sincosf(angle(direction));
        let cell = |i: usize| {
            let (x, y) = self.centre(i % self.width, i / self.width);
            (walls.cast(x, y, c, s, REACH_M) / UNIT_M) as u8
        };
        (0..self.width * self.height).map(cell).collect()
    }

    /// Centre of a cell, the grid's own metres.
    pub(crate) fn centre(&self, column: usize, row: usize) -> (f32, f32) {
        ((column as f32 + 0.5) * self.cell_m - MARGIN_M, (row as f32 + 0.5) * self.cell_m - MARGIN_M)
    }

    /// Which cell holds (x, y); `None` beyond the images.
    pub(crate) fn cell_at(&self, x: f32, y: f32) -> Option<usize> {
        let (column, row) = ((x + MARGIN_M) / self.cell_m, (y + MARGIN_M) / self.cell_m);
        let held = column >= 0.0 && row >= 0.0 && column < self.width as f32 && row < self.height as f32;
        held.then(|| row as usize * self.width + column as usize)
    }

    /// Largest distance to a wall in a direction, in units of [`UNIT_M`], row by row.
    pub(crate) fn image(&self, direction: usize) -> &[u8] {
        &self.images[direction]
    }
}

/// The angle of a direction, radians.
pub(crate) fn angle(direction: usize) -> f32 {
    direction as f32 * (std::f32::consts::TAU / DIRECTIONS as f32)
}

/// The largest of each cell's 3 × 3 neighbours in three images.
fn largest(images: [&[u8]; 3], width: usize) -> Vec<u8> {
    let mut merged: Vec<u8> = images[0].iter().zip(images[1]).zip(images[2]).map(|((a, b), c)| *a.max(b).max(c)).collect();
    for row in merged.chunks_exact_mut(width) {
        let mut before = row[0];
        for i in 0..width {
            let here = row[i];
            row[i] = before.max(here).max(if i + 1 < width { row[i + 1] } else { here });
            before = here;
        }
    }
    let height = merged.len() / width.max(1);
    let line = |row: usize| &merged[row * width..(row + 1) * width];
    let mut out = Vec::with_capacity(merged.len());
    for row in 0..height {
        let (below, above) = (line(row.saturating_sub(1)), line((row + 1).min(height - 1)));
        out.extend(line(row).iter().zip(below).zip(above).map(|((a, b), c)| *a.max(b).max(c)));
    }
    out
}

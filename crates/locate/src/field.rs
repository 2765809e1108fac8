//! How far is the nearest surface from every cell of the grid?

use planwalk_types::distance::{self, Envelope};
use rayon::prelude::*;

/// Distances are kept to this many cells: one byte in half cells, so that the field of a floor stays in the cache.
const FAR_CELLS: u8 = 127;

/// Exact Euclidean distance of every cell to the nearest surface cell, in half cells, capped.
pub(crate) fn distance_field(surfaces: &[bool], width: usize, rounded: fn(f64) -> f64) -> Vec<u8> {
    // A column's distance that is capped is never the nearest of anything within the cap.
    let mut field = distance::in_columns(surfaces.iter().copied(), width, FAR_CELLS);
    let half_cells = |square: f64| rounded(2.0 * square.sqrt()).min(2.0 * f64::from(FAR_CELLS)) as u8;
    field.par_chunks_mut(width.max(1)).for_each_init(Envelope::default, |envelope, row| envelope.sweep(row, half_cells));
    field
}

/// Lets surfaces grow by a cell to all eight sides.
pub(crate) fn widen(surfaces: &mut [bool], width: usize) {
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

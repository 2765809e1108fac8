//! How far is the nearest surface from every cell of the grid?

use rayon::prelude::*;

/// Distances are kept to this many cells: one byte in half cells, so that the field of a floor stays in the cache.
const FAR_CELLS: u8 = 127;

/// Exact Euclidean distance of every cell to the nearest surface cell, in half cells, capped (Felzenszwalb & Huttenlocher 2012:
/// columns first, then the lower envelope of parabolas along each row).
pub(crate) fn distance_field(surfaces: &[bool], width: usize, rounded: fn(f64) -> f64) -> Vec<u8> {
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

/// From distances within columns (cells) to distances in the plane (half cells), for one row.
fn envelope(row: &mut [u8], rounded: fn(f64) -> f64) {
    let square = |d: &u8| if *d >= FAR_CELLS { 1e9 } else { f64::from(*d) * f64::from(*d) };
    let squares: Vec<f64> = row.iter().map(square).collect();
    for (out, square) in row.iter_mut().zip(lower_envelope(&squares)) {
        *out = rounded(2.0 * square.sqrt()).min(2.0 * f64::from(FAR_CELLS)) as u8;
    }
}

/// For each i the least of `heights[j] + (i − j)²` over all j: the lower envelope of parabolas.
pub(crate) fn lower_envelope(heights: &[f64]) -> Vec<f64> {
    // Parabolas of the envelope, each with where it begins to be the lowest.
    let mut lowest: Vec<(usize, f64)> = Vec::with_capacity(heights.len());
    for (i, height) in heights.iter().enumerate() {
        loop {
            let Some(&(j, from)) = lowest.last() else {
                lowest.push((i, f64::NEG_INFINITY));
                break;
            };
            let (a, b) = (i as f64, j as f64);
            let meet = ((height + a * a) - (heights[j] + b * b)) / (2.0 * (a - b));
            if meet > from {
                lowest.push((i, meet));
                break;
            }
            lowest.pop();
        }
    }
    let mut k = 0;
    let least = |i: usize| {
        while k + 1 < lowest.len() && lowest[k + 1].1 <= i as f64 {
            k += 1;
        }
        let (j, _) = lowest[k];
        heights[j] + (i as f64 - j as f64).powi(2)
    };
    (0..heights.len()).map(least).collect()
}

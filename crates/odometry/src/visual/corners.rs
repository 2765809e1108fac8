//! Which pixels can be found again? Corners (Shi & Tomasi 1994), spread over the picture by a grid.

use crate::visual::image::Level;

/// Options of [`detect`].
#[derive(Debug, Clone, Copy)]
pub struct CornerOptions {
    /// Side of a grid cell in pixels; each cell gives at most one corner.
    pub cell_px: usize,
    /// Smallest corner strength: the lesser eigenvalue of the mean structure tensor, grey values² per pixel².
    /// The default, 6, is a contrast of some 10 grey values across the window; sensor noise of σ = 3 stays under it.
    pub min_strength: f32,
    /// Pixels along the border where nothing is looked for: half a tracking patch.
    pub border_px: usize,
}

impl Default for CornerOptions {
    fn default() -> Self {
        Self { cell_px: 32, min_strength: 6.0, border_px: 10 }
    }
}

/// Half side of the window over which the structure tensor is averaged.
const WINDOW: usize = 3;

/// The strongest corner of each grid cell that has none of `taken`, strongest first. Positions are pixels of `image`.
pub fn detect(image: &Level, taken: &[(f64, f64)], options: &CornerOptions) -> Vec<(f64, f64)> {
    let cell = options.cell_px.max(8);
    let (columns, rows) = (image.width.div_ceil(cell), image.height.div_ceil(cell));
    let border = options.border_px.max(WINDOW + 2);
    if image.width <= 2 * border || image.height <= 2 * border {
        return Vec::new();
    }
    let mut occupied = vec![false; columns * rows];
    for (x, y) in taken {
        let (column, row) = ((x.max(0.0) as usize / cell).min(columns - 1), (y.max(0.0) as usize / cell).min(rows - 1));
        occupied[row * columns + column] = true;
    }
    let strength = strength_map(image);
    let mut found: Vec<(f32, usize, usize)> = Vec::new();
    for row in 0..rows {
        for column in (0..columns).filter(|c| !occupied[row * columns + c]) {
            let mut best = (options.min_strength, 0, 0);
            for v in (row * cell).max(border)..((row + 1) * cell).min(image.height - border) {
                for u in (column * cell).max(border)..((column + 1) * cell).min(image.width - border) {
                    let s = strength[v * image.width + u];
                    if s > best.0 {
                        best = (s, u, v);
                    }
                }
            }
            if best.1 > 0 {
                found.push(best);
            }
        }
    }
    // Corners of neighbouring cells, or one beside a living track, may be the same corner.
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)).then(a.1.cmp(&b.1)));
    let apart = (cell as f64 / 2.5).powi(2);
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (_, u, v) in found {
        let (x, y) = (u as f64, v as f64);
        let close = |p: &(f64, f64)| (p.0 - x).powi(2) + (p.1 - y).powi(2) < apart;
        if !kept.iter().any(close) && !taken.iter().any(close) {
            kept.push((x, y));
        }
    }
    kept
}

/// The lesser eigenvalue of the structure tensor, averaged over the window, per pixel.
fn strength_map(image: &Level) -> Vec<f32> {
    let (w, h) = (image.width, image.height);
    let mut tensor = [vec![0.0f32; w * h], vec![0.0f32; w * h], vec![0.0f32; w * h]];
    for v in 1..h - 1 {
        for u in 1..w - 1 {
            let i = v * w + u;
            let gx = 0.5 * (image.data[i + 1] - image.data[i - 1]);
            let gy = 0.5 * (image.data[i + w] - image.data[i - w]);
            tensor[0][i] = gx * gx;
            tensor[1][i] = gx * gy;
            tensor[2][i] = gy * gy;
        }
    }
    let [xx, xy, yy] = tensor.map(|t| box_mean(&t, w, h));
    let lesser = |i: usize| {
        let (half_trace, half_gap) = (0.5 * (xx[i] + yy[i]), 0.5 * (xx[i] - yy[i]));
        half_trace - (half_gap * half_gap + xy[i] * xy[i]).sqrt()
    };
    (0..w * h).map(lesser).collect()
}

/// Mean over the window, by running sums along rows, then columns; the border is left as it falls.
fn box_mean(source: &[f32], w: usize, h: usize) -> Vec<f32> {
    let side = 2 * WINDOW + 1;
    let mut rows = vec![0.0f32; w * h];
    for v in 0..h {
        let line = &source[v * w..(v + 1) * w];
        let mut sum: f32 = line[..side.min(w)].iter().sum();
        for u in WINDOW..w.saturating_sub(WINDOW) {
            rows[v * w + u] = sum;
            if u + WINDOW + 1 < w {
                sum += line[u + WINDOW + 1] - line[u - WINDOW];
            }
        }
    }
    let mut mean = vec![0.0f32; w * h];
    let mut sums = vec![0.0f32; w];
    let scale = 1.0 / (side * side) as f32;
    for v in 0..h {
        for u in 0..w {
            sums[u] += rows[v * w + u];
            if v >= side {
                sums[u] -= rows[(v - side) * w + u];
            }
        }
        if v + 1 >= side {
            let out = &mut mean[(v - WINDOW) * w..(v - WINDOW + 1) * w];
            for (o, s) in out.iter_mut().zip(&sums) {
                *o = s * scale;
            }
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::image::Pyramid;
    use planwalk_types::GrayImage;

    fn level(value: impl FnMut(usize, usize) -> u8) -> Level {
        Pyramid::new(&GrayImage::from_fn(160, 120, value), 1).levels.remove(0)
    }

    #[test]
    fn a_squares_corner_is_found_where_it_is() {
        let image = level(|u, v| if (60..100).contains(&u) && (50..90).contains(&v) { 200 } else { 40 });
        let found = detect(&image, &[], &CornerOptions::default());
        for corner in [(60.0, 50.0), (99.0, 50.0), (60.0, 89.0), (99.0, 89.0)] {
            let nearest = found.iter().map(|p| (p.0 - corner.0).hypot(p.1 - corner.1)).fold(f64::INFINITY, f64::min);
            // The window may pull the maximum inwards by its half side.
            assert!(nearest < 1.5 * WINDOW as f64, "corner {corner:?} is {nearest} px from the nearest of {found:?}");
        }
        assert_eq!(found.len(), 4, "edges are no corners: {found:?}");
    }

    #[test]
    fn a_blank_wall_has_no_corners_and_a_taken_cell_gives_none() {
        assert!(detect(&level(|_, _| 128), &[], &CornerOptions::default()).is_empty());
        let speckled = level(|u, v| ((u / 5 + v / 5) % 2 * 120) as u8);
        let all = detect(&speckled, &[], &CornerOptions::default());
        let rest = detect(&speckled, &all, &CornerOptions::default());
        assert!(all.len() >= 8 && rest.is_empty(), "{} first, {} again", all.len(), rest.len());
    }

    #[test]
    fn a_picture_smaller_than_the_border_is_no_problem() {
        let tiny = Pyramid::new(&GrayImage::from_fn(7, 3, |_, _| 9), 4).levels.remove(0);
        assert!(detect(&tiny, &[], &CornerOptions::default()).is_empty());
    }
}

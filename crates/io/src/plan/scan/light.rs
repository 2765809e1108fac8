//! Is the paper of a picture lit evenly, and if not, how bright is it where? Photographs of plans, and scans of folded sheets.
//!
//! brightness ─▶ tiles: how bright their paper is ─▶ those that pass into each other smoothly ─▶ brightness relative to the paper
//!
//! Paper that is lit unevenly changes little from tile to tile and much over the sheet; a fill that somebody drew changes at once, or not
//! at all. So a drawing as it was drawn stays as it is, byte for byte. What is divided out is the paper, as by Wellner (1993), not a
//! window's mean and spread (Sauvola & Pietikäinen 2000), which hollows out walls that are wider than the window.
//! Pitfall: a shadow with a sharp edge is as a fill is, and stays dark.

/// Tiles along the shorter side: enough that the light of a desk lamp changes little from one to the next.
const TILES: usize = 48;
/// … and no smaller than this, pixels: the paper must show between letters and lines.
const LEAST_TILE_PX: usize = 16;
/// Fewer tiles along a side say nothing of light.
const LEAST_TILES: usize = 6;
/// The paper of a tile is as bright as this share of its pixels at most: a tenth is left for paper between dense lines.
const PAPER_QUANTILE: f64 = 0.9;
/// Pixels of a tile that are looked at, along each side: the quantile needs no more.
const SAMPLES: usize = 48;
/// Paper of neighbouring tiles differs by no more than this share where it is the light that changes.
const SMOOTH: f64 = 0.15;
/// The smooth paper is at least this share of the tiles: a sheet, not a shaded ornament.
const LEAST_SHEET: f64 = 0.6;
/// Above this share of the brightest paper, mid-grey tells ink as well as anything: the light counts as even.
const DIM: f64 = 0.67;
/// … if this share of the sheet, or more, is no brighter.
const LEAST_DIM: f64 = 0.02;
/// Where bright paper borders on dim paper, no more than this share of the tiles' borders are steps: a fill that was drawn has an edge.
const MOST_STEPS: f64 = 0.2;
/// What is darker than this share of its neighbour is ink.
const INK: f64 = 0.35;
/// Paper darker than this, of 255, is told from ink no more.
const DARKEST_PAPER: f64 = 16.0;

/// How bright the paper is, tile by tile.
struct Paper {
    columns: usize,
    tile_px: usize,
    tiles: Vec<f64>,
}

/// Makes the paper of a picture as bright everywhere, where it is lit unevenly; gives the darkest and the brightest paper, of 255, and the
/// side of a tile in pixels, or `None` where the picture was left as it is.
pub(in crate::plan) fn level(brightness: &mut [u8], width: usize) -> Option<(u8, u8, usize)> {
    let (paper, [darkest, brightest]) = Paper::of(brightness, width)?.uneven()?;
    for (v, row) in brightness.chunks_mut(width).enumerate() {
        let across = paper.between(v);
        for (u, pixel) in row.iter_mut().enumerate() {
            let local = paper.at(u, across);
            *pixel = (f64::from(*pixel) * 255.0 / local).round().clamp(0.0, 255.0) as u8;
        }
    }
    Some((darkest as u8, brightest as u8, paper.tile_px))
}

impl Paper {
    /// Looks at the tiles of a picture; `None` if it is too small to have some.
    fn of(brightness: &[u8], width: usize) -> Option<Self> {
        let height = brightness.len().checked_div(width)?;
        let tile_px = (width.min(height) / TILES).max(LEAST_TILE_PX);
        let (columns, rows) = (width / tile_px, height / tile_px);
        if columns.min(rows) < LEAST_TILES {
            return None;
        }
        let step = tile_px.div_ceil(SAMPLES);
        let paper = |tile: usize| {
            let (u, v) = (tile % columns * tile_px, tile / columns * tile_px);
            let mut counts = [0u32; 256];
            for row in (v..v + tile_px).step_by(step) {
                let pixels = &brightness[row * width + u..row * width + u + tile_px];
                pixels.iter().step_by(step).for_each(|b| counts[usize::from(*b)] += 1);
            }
            quantile(&counts)
        };
        Some(Self { columns, tile_px, tiles: (0..columns * rows).map(paper).collect() })
    }

    /// The paper with what is not paper filled in from around, and the darkest and brightest; `None` if the light is even.
    fn uneven(mut self) -> Option<(Self, [f64; 2])> {
        let is_sheet = self.sheet();
        let mut sheet: Vec<f64> = self.tiles.iter().zip(&is_sheet).filter(|(_, is)| **is).map(|(tile, _)| *tile).collect();
        sheet.sort_by(f64::total_cmp);
        if (sheet.len() as f64) < LEAST_SHEET * self.tiles.len() as f64 {
            return None;
        }
        let at = |share: f64| sheet.get((share * (sheet.len() - 1) as f64) as usize).copied();
        let (dim, darkest, brightest) = (at(LEAST_DIM)?, at(0.0)?, at(1.0 - LEAST_DIM)?);
        if dim > DIM * brightest || self.is_filled(DIM * brightest) {
            return None;
        }
        self.fill(is_sheet);
        Some((self, [darkest, brightest]))
    }

    /// Whether what is dimmer than this begins in steps.
    fn is_filled(&self, dim: f64) -> bool {
        let (mut steps, mut all) = (0usize, 0usize);
        for (tile, bright) in self.tiles.iter().enumerate().filter(|(_, paper)| **paper > dim) {
            for dark in self.around(tile).map(|next| self.tiles[next]).filter(|dark| *dark <= dim && *dark > INK * bright) {
                all += 1;
                steps += usize::from(bright - dark > SMOOTH * bright);
            }
        }
        steps as f64 > MOST_STEPS * all as f64
    }

    /// The largest set of tiles that pass into each other smoothly.
    fn sheet(&self) -> Vec<bool> {
        let mut number = vec![usize::MAX; self.tiles.len()];
        let mut sizes = Vec::new();
        for begin in 0..self.tiles.len() {
            if number[begin] != usize::MAX || self.tiles[begin] < DARKEST_PAPER {
                continue;
            }
            let piece = sizes.len();
            let (mut open, mut size) = (vec![begin], 0);
            number[begin] = piece;
            while let Some(tile) = open.pop() {
                size += 1;
                for next in self.around(tile) {
                    let [a, b] = [self.tiles[tile], self.tiles[next]];
                    if number[next] == usize::MAX && b >= DARKEST_PAPER && (a - b).abs() <= SMOOTH * a.max(b) {
                        number[next] = piece;
                        open.push(next);
                    }
                }
            }
            sizes.push(size);
        }
        // The first of the largest.
        let largest = (0..sizes.len()).rev().max_by_key(|piece| sizes[*piece]);
        number.iter().map(|piece| Some(*piece) == largest).collect()
    }

    /// Tiles without paper get the mean of their neighbours that have some, from the sheet inwards.
    fn fill(&mut self, mut is_known: Vec<bool>) {
        loop {
            let of = |tile: usize| {
                let known: Vec<f64> = self.around(tile).filter(|next| is_known[*next]).map(|next| self.tiles[next]).collect();
                (!known.is_empty()).then(|| (tile, known.iter().sum::<f64>() / known.len() as f64))
            };
            let found: Vec<(usize, f64)> = (0..self.tiles.len()).filter(|tile| !is_known[*tile]).filter_map(of).collect();
            if found.is_empty() {
                return;
            }
            for (tile, paper) in found {
                self.tiles[tile] = paper;
                is_known[tile] = true;
            }
        }
    }

    /// The four neighbours of a tile.
    fn around(&self, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let (columns, count) = (self.columns, self.tiles.len());
        let left = (!tile.is_multiple_of(columns)).then(|| tile - 1);
        let right = (!(tile + 1).is_multiple_of(columns)).then_some(tile + 1);
        let (above, below) = (tile.checked_sub(columns), Some(tile + columns).filter(|below| *below < count));
        [left, right, above, below].into_iter().flatten()
    }

    /// The two tiles along a side whose centres a pixel lies between, and how far it is from the first to the second.
    fn along(&self, pixel: usize, count: usize) -> (usize, usize, f64) {
        let at = ((pixel as f64 + 0.5) / self.tile_px as f64 - 0.5).clamp(0.0, (count - 1) as f64);
        let first = at as usize;
        (first, (first + 1).min(count - 1), at - first as f64)
    }

    /// The rows of tiles that a row of pixels lies between.
    fn between(&self, v: usize) -> (usize, usize, f64) {
        let (above, below, part) = self.along(v, self.tiles.len() / self.columns);
        (above * self.columns, below * self.columns, part)
    }

    /// Brightness of the paper at a column of pixels, between two rows of tiles.
    fn at(&self, u: usize, (above, below, part): (usize, usize, f64)) -> f64 {
        let (left, right, share) = self.along(u, self.columns);
        let mix = |row: usize| self.tiles[row + left] * (1.0 - share) + self.tiles[row + right] * share;
        mix(above) * (1.0 - part) + mix(below) * part
    }
}

/// The brightness that [`PAPER_QUANTILE`] of the counted pixels do not exceed.
fn quantile(counts: &[u32; 256]) -> f64 {
    let wanted = PAPER_QUANTILE * f64::from(counts.iter().sum::<u32>());
    let mut seen = 0.0;
    let reached = |count: &u32| {
        seen += f64::from(*count);
        seen >= wanted
    };
    counts.iter().position(reached).unwrap_or(255) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 400;

    /// A sheet with a frame and a solid wall 40 px thick.
    fn sheet(paper: impl Fn(usize, usize) -> f64) -> Vec<u8> {
        let is_solid = |u: usize, v: usize| u.abs_diff(200) < 20 && v.abs_diff(200) < 140;
        let is_ink = |u: usize, v: usize| is_solid(u, v) || [20, 21, 22, 380].contains(&u) || [20, 21, 380].contains(&v);
        (0..W * W).map(|i| (i % W, i / W)).map(|(u, v)| (paper(u, v) * if is_ink(u, v) { 0.1 } else { 1.0 }) as u8).collect()
    }

    fn dark(brightness: &[u8]) -> Vec<usize> {
        (0..brightness.len()).filter(|i| brightness[*i] < 128).collect()
    }

    #[test]
    fn ink_is_the_same_under_a_lamp_and_in_a_soft_shadow() {
        let clean = dark(&sheet(|_, _| 250.0));
        let falling = |u: usize, v: usize| 250.0 * (1.0 - 0.8 * (u + v) as f64 / (2 * W) as f64);
        let shadow = |u: usize, _: usize| 250.0 * (1.0 - 0.6 / (1.0 + ((u as f64 - 250.0) / 30.0).exp()));
        for lit in [sheet(falling), sheet(shadow)] {
            assert!(dark(&lit).len() > 2 * clean.len());
            let mut brightness = lit;
            assert!(level(&mut brightness, W).is_some());
            assert_eq!(dark(&brightness), clean);
        }
    }

    #[test]
    fn what_is_lit_evenly_and_what_somebody_filled_stays_as_it_is() {
        let even = |_: usize, _: usize| 250.0;
        let hazy = |u: usize, _: usize| 250.0 - 0.15 * u as f64;
        let filled = |u: usize, v: usize| if u < 150 && v > 100 { 110.0 } else { 250.0 };
        let striped = |u: usize, _: usize| [250.0, 190.0, 140.0, 100.0][u / 100];
        for drawn in [sheet(even), sheet(hazy), sheet(filled), sheet(striped)] {
            let mut brightness = drawn.clone();
            assert_eq!(level(&mut brightness, W), None);
            assert_eq!(brightness, drawn);
        }
    }

    #[test]
    fn what_has_no_room_for_paper_is_left_alone() {
        for (count, width) in [(0, 0), (0, 9), (9, 9), (90 * 90, 90), (W * W, W)] {
            assert_eq!(level(&mut vec![0; count], width), None, "{count} pixels");
        }
    }
}

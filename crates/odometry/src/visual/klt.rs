//! Where did this patch go? Pyramidal Lucas–Kanade, inverse compositional (Baker & Matthews 2004), checked forward and backward.
//!
//! Patches are compared less their means, so a change of exposure is no motion.

use crate::visual::image::{Level, Pyramid, to_level};

/// Options of [`follow`].
#[derive(Debug, Clone, Copy)]
pub struct KltOptions {
    /// Half side of the patch: 5 makes 11×11 pixels.
    pub half_patch: usize,
    /// Most iterations per level.
    pub iterations: usize,
    /// Pixels by which a point followed there and back may miss itself.
    pub max_return_px: f64,
    /// Largest root mean square of the grey difference at the end; above it the patch is another thing (occlusion).
    pub max_rms: f32,
}

impl Default for KltOptions {
    fn default() -> Self {
        Self { half_patch: 5, iterations: 15, max_return_px: 0.7, max_rms: 22.0 }
    }
}

/// Where the point at `from` in `source` is in `target`, looked for around `guess`; `None` when it is not found surely.
pub fn follow(source: &Pyramid, target: &Pyramid, from: (f64, f64), guess: (f64, f64), options: &KltOptions) -> Option<(f64, f64)> {
    let there = one_way(source, target, from, guess, source.levels.len(), options)?;
    // Back from beside the start, not from it: a patch that finds itself only when it starts there proves nothing.
    let back = one_way(target, source, there, (from.0 + 1.5, from.1 - 1.5), 2, options)?;
    let miss = (back.0 - from.0).hypot(back.1 - from.1);
    (miss < options.max_return_px).then_some(there)
}

/// Coarse to fine over the lowest `levels` levels.
fn one_way(
    source: &Pyramid,
    target: &Pyramid,
    from: (f64, f64),
    guess: (f64, f64),
    levels: usize,
    options: &KltOptions,
) -> Option<(f64, f64)> {
    let mut flow = (guess.0 - from.0, guess.1 - from.1);
    for level in (0..levels.min(target.levels.len())).rev() {
        let shrink = 1.0 / (1u32 << level) as f64;
        let (x, y) = to_level(from.0, from.1, level);
        let start = (x + (flow.0 * shrink) as f32, y + (flow.1 * shrink) as f32);
        match align(&source.levels[level], &target.levels[level], (x, y), start, options) {
            Some((moved, rms)) => {
                if level == 0 && rms > options.max_rms {
                    return None;
                }
                flow = (f64::from(moved.0 - x) / shrink, f64::from(moved.1 - y) / shrink);
            }
            // Near the border a coarse level cannot say anything; the finest must.
            None if level > 0 => {}
            None => return None,
        }
    }
    Some((from.0 + flow.0, from.1 + flow.1))
}

/// Most pixels of a patch (half side 10).
const MAX_PATCH: usize = 441;

/// Gauss–Newton on a translation at one level: the new position and the root mean square of what is left.
fn align(source: &Level, target: &Level, at: (f32, f32), start: (f32, f32), options: &KltOptions) -> Option<((f32, f32), f32)> {
    let half = options.half_patch.clamp(2, 10);
    let reach = half as f32 + 1.0;
    if !source.holds(at.0, at.1, reach) {
        return None;
    }
    let side = 2 * half + 1;
    let count = side * side;
    let (mut patch, mut gx, mut gy) = ([0.0f32; MAX_PATCH], [0.0f32; MAX_PATCH], [0.0f32; MAX_PATCH]);
    let (x0, y0) = (at.0 - half as f32, at.1 - half as f32);
    for j in 0..side {
        for i in 0..side {
            let (x, y) = (x0 + i as f32, y0 + j as f32);
            let k = j * side + i;
            patch[k] = source.sample(x, y);
            gx[k] = 0.5 * (source.sample(x + 1.0, y) - source.sample(x - 1.0, y));
            gy[k] = 0.5 * (source.sample(x, y + 1.0) - source.sample(x, y - 1.0));
        }
    }
    let mean_of = |values: &[f32]| values.iter().sum::<f32>() / count as f32;
    let (mean, mean_gx, mean_gy) = (mean_of(&patch[..count]), mean_of(&gx[..count]), mean_of(&gy[..count]));
    let (mut hxx, mut hxy, mut hyy) = (0.0f32, 0.0f32, 0.0f32);
    for k in 0..count {
        // The patch's own mean is taken off, and so is its gradient's: exposure is projected out of the Jacobian too.
        gx[k] -= mean_gx;
        gy[k] -= mean_gy;
        hxx += gx[k] * gx[k];
        hxy += gx[k] * gy[k];
        hyy += gy[k] * gy[k];
    }
    let determinant = hxx * hyy - hxy * hxy;
    if determinant < 1e-3 * (hxx + hyy).powi(2) || hxx + hyy < count as f32 {
        return None;
    }
    let (mut x, mut y) = start;
    let mut rms = f32::INFINITY;
    for _ in 0..options.iterations {
        if !target.holds(x, y, reach) {
            return None;
        }
        let mut now = [0.0f32; MAX_PATCH];
        let (tx, ty) = (x - half as f32, y - half as f32);
        let (u, v) = (tx as usize, ty as usize);
        let (a, b) = (tx - u as f32, ty - v as f32);
        let (w00, w10, w01, w11) = ((1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b);
        for j in 0..side {
            let top = &target.data[(v + j) * target.width + u..][..side + 1];
            let low = &target.data[(v + j + 1) * target.width + u..][..side + 1];
            for i in 0..side {
                now[j * side + i] = w00 * top[i] + w10 * top[i + 1] + w01 * low[i] + w11 * low[i + 1];
            }
        }
        let offset = mean_of(&now[..count]) - mean;
        let (mut bx, mut by, mut squares) = (0.0f32, 0.0f32, 0.0f32);
        for k in 0..count {
            let error = now[k] - patch[k] - offset;
            bx += gx[k] * error;
            by += gy[k] * error;
            squares += error * error;
        }
        rms = (squares / count as f32).sqrt();
        let dx = (hyy * bx - hxy * by) / determinant;
        let dy = (hxx * by - hxy * bx) / determinant;
        x -= dx;
        y -= dy;
        if dx.abs() + dy.abs() < 0.01 {
            break;
        }
    }
    target.holds(x, y, reach).then_some(((x, y), rms))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::GrayImage;

    /// Smooth blobs, shifted by (dx, dy) and brightened.
    fn scene(dx: f64, dy: f64, brighter: f64) -> Pyramid {
        let value = |u: usize, v: usize| {
            let (x, y) = (u as f64 - dx, v as f64 - dy);
            (110.0 + 40.0 * (x / 5.0).sin() * (y / 7.0).cos() + 30.0 * (x / 17.0 + y / 13.0).sin() + brighter) as u8
        };
        Pyramid::new(&GrayImage::from_fn(320, 240, value), 4)
    }

    #[test]
    fn a_shift_is_found_to_a_tenth_of_a_pixel_though_it_got_brighter() {
        let (source, target) = (scene(0.0, 0.0, 0.0), scene(6.3, -4.6, 25.0));
        for from in [(100.0, 80.0), (160.0, 120.0), (220.5, 140.25)] {
            let (x, y) = follow(&source, &target, from, from, &KltOptions::default()).expect("a clear patch is found");
            // Grey values are whole numbers: 0.3 of noise over a gradient of 8 a pixel and 121 pixels.
            assert!((x - from.0 - 6.3).hypot(y - from.1 + 4.6) < 0.1, "{from:?} went to ({x}, {y})");
        }
    }

    #[test]
    fn what_is_gone_is_not_found() {
        let source = scene(0.0, 0.0, 0.0);
        let blank = Pyramid::new(&GrayImage::from_fn(320, 240, |_, _| 128), 4);
        assert_eq!(follow(&source, &blank, (160.0, 120.0), (160.0, 120.0), &KltOptions::default()), None);
        assert_eq!(follow(&source, &source, (2.0, 120.0), (2.0, 120.0), &KltOptions::default()), None, "at the border");
        let nowhere = follow(&source, &source, (160.0, 120.0), (f64::NAN, 1e300), &KltOptions::default());
        assert_eq!(nowhere, None, "a wild guess is no reason to fail");
    }
}

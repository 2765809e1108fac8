//! What does the picture look like at every size? Float pyramids for tracking.

use planwalk_types::GrayImage;

/// One level of a pyramid: grey values as f32, row-major.
#[derive(Debug, Clone)]
pub struct Level {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels, row by row.
    pub data: Vec<f32>,
}

impl Level {
    /// Bilinear value at (x, y); the caller keeps 0 ≤ x < width − 1 and 0 ≤ y < height − 1.
    #[inline]
    pub fn sample(&self, x: f32, y: f32) -> f32 {
        let (u, v) = (x as usize, y as usize);
        let (a, b) = (x - u as f32, y - v as f32);
        let i = v * self.width + u;
        let d = &self.data;
        let top = d[i] + a * (d[i + 1] - d[i]);
        let low = d[i + self.width] + a * (d[i + self.width + 1] - d[i + self.width]);
        top + b * (low - top)
    }

    /// Whether a square of half side `reach` around (x, y) lies inside, with room for interpolation.
    #[inline]
    pub fn holds(&self, x: f32, y: f32, reach: f32) -> bool {
        x >= reach && y >= reach && x + reach < (self.width - 1) as f32 && y + reach < (self.height - 1) as f32
    }
}

/// An image at full size and halved again and again.
#[derive(Debug, Clone)]
pub struct Pyramid {
    /// Level 0 is full size.
    pub levels: Vec<Level>,
}

impl Pyramid {
    /// Up to `count` levels; it stops before a level would be under 32 px.
    pub fn new(image: &GrayImage, count: usize) -> Self {
        let data = image.data().iter().map(|p| f32::from(*p)).collect();
        let mut levels = vec![Level { width: image.width(), height: image.height(), data }];
        while levels.len() < count {
            let last = &levels[levels.len() - 1];
            if last.width.min(last.height) < 64 {
                break;
            }
            let next = halve(last);
            levels.push(next);
        }
        Self { levels }
    }

    /// The smallest level.
    pub fn smallest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }
}

/// Half the size: the mean of each 2×2 block of the image smoothed by [1 2 1]/4. Pixel (u, v) of the result is centred on
/// (2u + 0.5, 2v + 0.5) of the source.
pub(super) fn halve(source: &Level) -> Level {
    let (width, height) = (source.width / 2, source.height / 2);
    let mut data = Vec::with_capacity(width * height);
    // [1 3 3 1]/8 is the 2-block mean of the smoothed row, in each direction.
    let mut row = vec![0.0f32; source.width];
    for v in 0..height {
        let at = |dv: isize| ((2 * v) as isize + dv).clamp(0, source.height as isize - 1) as usize * source.width;
        let (a, b, c, d) = (at(-1), at(0), at(1), at(2));
        for (u, value) in row.iter_mut().enumerate() {
            let s = &source.data;
            *value = 0.125 * (s[a + u] + s[d + u]) + 0.375 * (s[b + u] + s[c + u]);
        }
        for u in 0..width {
            let left = row[(2 * u).saturating_sub(1)];
            let right = row[(2 * u + 2).min(source.width - 1)];
            data.push(0.125 * (left + right) + 0.375 * (row[2 * u] + row[2 * u + 1]));
        }
    }
    Level { width, height, data }
}

/// Position on level `level` of the point that is at (x, y) on level 0.
#[inline]
pub fn to_level(x: f64, y: f64, level: usize) -> (f32, f32) {
    let shrink = 1.0 / (1u32 << level) as f64;
    (((x + 0.5) * shrink - 0.5) as f32, ((y + 0.5) * shrink - 0.5) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_stays_a_ramp_on_every_level() {
        let image = GrayImage::from_fn(256, 128, |u, v| (u / 2 + v) as u8);
        let pyramid = Pyramid::new(&image, 3);
        assert_eq!(pyramid.levels.len(), 3);
        let (x, y) = to_level(100.0, 60.0, 1);
        // Integer division makes the ramp a staircase of height 1/2; smoothing leaves less than that.
        assert!((pyramid.levels[1].sample(x, y) - 110.0).abs() < 0.5);
    }
}

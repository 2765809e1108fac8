//! How did the camera turn before a blank wall? As the faint grain of its paint says.
//!
//! Nothing on a bare wall can be followed by itself: its grain has less than one grey value. But averaged over blocks of eight pixels
//! and taken as a whole it is far above the noise of a sensor, and shows where the picture went to better than a degree.
//!
//! pictures an eighth of the size, less their surroundings ─▶ the shift that correlates best ─▶ the turn (`super::turn`), if it is one
//! and the same on both sides of the picture
//!
//! Pitfall: a codec irons walls flat, and what it leaves are its own blocks, which stay where they are, or jump by their own width.
//! Hence a turn must be one, must stand out, and must hold left and right alike.

use nalgebra::UnitQuaternion;
use planwalk_types::Camera;

use super::image::Level;
use super::turn::{SmallPicture, Turn};

/// Half side of the surroundings that are taken off, small pixels: light falls off along a wall, its grain does not.
const SURROUNDINGS: usize = 4;
/// Widest picture whose grain is looked at, pixels: an eighth of 640.
const WIDTH: usize = 80;
/// Half sides of the part that is looked for in the next picture, as shares of the picture: lenses stretch the rest as it turns.
const PART: (f64, f64) = (0.25, 0.3);
/// Least correlation of the middle of the picture and of its worse half, together. Noise and blocks reach 0.6 now and then, but neither
/// in both nor alone.
const SAME: f64 = 1.0;
/// How alike, as a share of the best, the pictures may be where they are shifted elsewhere, and how far elsewhere is, small pixels. Grain
/// has no second place; what a codec leaves of a wall, or a shadow on it, has many.
const STANDS_OUT: f32 = 0.45;
const ELSEWHERE: i32 = 4;
/// Turns under this are no turns, but a pattern that stands in the picture: dirt, dead pixels, a codec's blocks. 0.25°.
const STANDS_RAD: f64 = 0.0045;

/// The turn from one picture to the next, by their grain; `None` where there is none, or it says nothing.
pub fn turn(camera: &Camera, last: &Level, now: &Level) -> Option<Turn> {
    let (last, now) = (Grain::of(last), Grain::of(now));
    let ((dx, dy), middle) = last.shift(&now)?;
    let shrink = camera.width as f64 / last.0.width as f64;
    let (was, is) = (camera.ray(camera.cx, camera.cy), camera.ray(camera.cx + shrink * f64::from(dx), camera.cy + shrink * f64::from(dy)));
    let guess = UnitQuaternion::rotation_between(&was, &is)?;
    let (last, now) = (SmallPicture::of_grain(last.0, camera.width), SmallPicture::of_grain(now.0, camera.width));
    let turn = super::turn::align(camera, &last, &now, &[guess])?;
    let halves = super::turn::halves(camera, &last, &now, &turn.now_from_last)?;
    let holds = f64::from(middle) + halves[0].min(halves[1]) > SAME;
    (holds && turn.now_from_last.angle() > STANDS_RAD).then_some(turn)
}

/// A small picture less its surroundings.
struct Grain(Level);

impl Grain {
    fn of(smallest: &Level) -> Self {
        let mut level = smallest.clone();
        while level.width > WIDTH && level.width.min(level.height) >= 16 {
            level = super::image::halve(&level);
        }
        let around = mean_around(&level);
        level.data.iter_mut().zip(around).for_each(|(value, mean)| *value -= mean);
        Self(level)
    }

    /// The shift, in small pixels, at which the middle of this picture is found in the next one, and how alike it is there.
    fn shift(&self, next: &Self) -> Option<((i32, i32), f32)> {
        let (w, h) = (self.0.width as i32, self.0.height as i32);
        let (half_w, half_h) = ((PART.0 * f64::from(w)) as i32, (PART.1 * f64::from(h)) as i32);
        let (cx, cy) = (w / 2, h / 2);
        let (most_x, most_y) = (cx - half_w, cy - half_h);
        let mut found: Vec<(f32, i32, i32)> = Vec::new();
        for dy in -most_y..=most_y {
            for dx in -most_x..=most_x {
                let correlation = self.correlation(next, (cx - half_w..cx + half_w, cy - half_h..cy + half_h), (dx, dy));
                found.push((correlation, dx, dy));
            }
        }
        let best = *found.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let elsewhere = found.iter().filter(|f| (f.1 - best.1).abs().max((f.2 - best.2).abs()) > ELSEWHERE);
        let second = elsewhere.map(|f| f.0).fold(-1.0, f32::max);
        let moved = (best.1, best.2) != (0, 0);
        (moved && second < STANDS_OUT * best.0).then_some(((best.1, best.2), best.0))
    }

    fn correlation(&self, next: &Self, (columns, rows): (std::ops::Range<i32>, std::ops::Range<i32>), (dx, dy): (i32, i32)) -> f32 {
        let width = self.0.width as i32;
        let (mut both, mut here2, mut there2) = (0.0f32, 1e-6f32, 1e-6f32);
        for v in rows {
            let (here, there) = (v * width + columns.start, (v + dy) * width + columns.start + dx);
            let count = columns.len();
            let here = self.0.data.get(here as usize..here as usize + count).unwrap_or(&[]);
            let there = next.0.data.get(there as usize..there as usize + count).unwrap_or(&[]);
            for (a, b) in here.iter().zip(there) {
                both += a * b;
                here2 += a * a;
                there2 += b * b;
            }
        }
        both / (here2 * there2).sqrt()
    }
}

/// Mean of the square around each pixel, by running sums; squares end with the picture.
fn mean_around(level: &Level) -> Vec<f32> {
    let (w, h, r) = (level.width, level.height, SURROUNDINGS);
    let mut sums = vec![0.0f64; (w + 1) * (h + 1)];
    for v in 0..h {
        let mut row = 0.0;
        for u in 0..w {
            row += f64::from(level.data[v * w + u]);
            sums[(v + 1) * (w + 1) + u + 1] = sums[v * (w + 1) + u + 1] + row;
        }
    }
    let mut mean = Vec::with_capacity(w * h);
    for v in 0..h {
        let (top, low) = (v.saturating_sub(r), (v + r + 1).min(h));
        for u in 0..w {
            let (left, right) = (u.saturating_sub(r), (u + r + 1).min(w));
            let at = |x: usize, y: usize| sums[y * (w + 1) + x];
            let sum = at(right, low) - at(left, low) - at(right, top) + at(left, top);
            mean.push((sum / ((right - left) * (low - top)) as f64) as f32);
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use planwalk_types::{GrayImage, Seed};

    use super::*;
    use crate::visual::image::Pyramid;
    use crate::visual::two_view::scene::uniform;

    /// Paint: waves of one to five degrees in all directions, less than one grey value (root mean square) together.
    fn paint(ray: &Vector3<f64>) -> f64 {
        let mut rng = Seed(5).derive("paint", 0);
        let wave = |_: usize| {
            let direction = Vector3::from_fn(|_, _| uniform(&mut rng, -1.0, 1.0)).normalize();
            (uniform(&mut rng, 70.0, 300.0) * direction.dot(ray) + uniform(&mut rng, 0.0, 6.3)).sin()
        };
        0.2 * (0..40).map(wave).sum::<f64>()
    }

    /// What a camera turned by `world_from_camera` sees of a painted wall, darker to one side, with a sensor's noise of two grey values.
    fn wall(camera: &Camera, world_from_camera: &UnitQuaternion<f64>, noise: u64) -> Level {
        let mut rng = Seed(noise).derive("noise", 0);
        let image = GrayImage::from_fn(camera.width, camera.height, |u, v| {
            let ray = world_from_camera * camera.ray(u as f64, v as f64);
            (150.0 + 20.0 * ray.x + paint(&ray) + uniform(&mut rng, -3.5, 3.5)).round() as u8
        });
        Pyramid::new(&image, 4).levels.pop().expect("a pyramid has a level")
    }

    #[test]
    fn a_turn_before_a_painted_wall_is_found() {
        let camera = Camera::phone_prior(320, 240);
        let before = wall(&camera, &UnitQuaternion::identity(), 1);
        for axis in [Vector3::new(0.0, 0.09, 0.0), Vector3::new(0.04, -0.15, 0.01)] {
            let turned = UnitQuaternion::from_scaled_axis(axis);
            let found = turn(&camera, &before, &wall(&camera, &turned, 2)).expect("the paint is told from the noise");
            // A fifth of a small pixel, which is 4 px of 250 here; roll is told by the picture's border alone.
            assert!(found.now_from_last.angle_to(&turned.inverse()) < 0.01, "{axis}: {}", found.now_from_last.scaled_axis());
        }
    }

    #[test]
    fn noise_dirt_and_stripes_are_no_turn() {
        let camera = Camera::phone_prior(320, 240);
        let level = |seen: &dyn Fn(usize, usize) -> f64, noise: u64| {
            let mut rng = Seed(noise).derive("noise", 0);
            let image = GrayImage::from_fn(320, 240, |u, v| (seen(u, v) + uniform(&mut rng, -3.5, 3.5)).round() as u8);
            Pyramid::new(&image, 4).levels.pop().expect("a pyramid has a level")
        };
        let plain = |_: usize, _: usize| 140.0;
        assert!(turn(&camera, &level(&plain, 1), &level(&plain, 2)).is_none(), "noise");
        // The same in both pictures: on the lens, or a codec's blocks.
        let still = UnitQuaternion::identity();
        assert!(turn(&camera, &wall(&camera, &still, 1), &wall(&camera, &still, 2)).is_none(), "dirt");
        // Stripes of wallpaper fit wherever they are laid a stripe further on.
        let stripes = |shift: usize| move |u: usize, _: usize| 140.0 + if ((u + shift) / 24).is_multiple_of(2) { 3.0 } else { 0.0 };
        assert!(turn(&camera, &level(&stripes(0), 1), &level(&stripes(13), 2)).is_none(), "stripes");
    }
}

//! How did the camera turn before a blank wall? As the faint grain of its paint says.
//!
//! Nothing on a bare wall can be followed by itself: its grain has less than one grey value. But averaged over blocks of eight pixels
//! and taken as a whole it is far above the noise of a sensor, and shows where the picture went to better than a degree.
//!
//! pictures an eighth of the size, less their surroundings ─▶ the shift that correlates best ─▶ the turn (`super::turn`), if it is one
//! and the same on both sides of the picture
//!
//! The same with every part of the picture brought to one contrast ([`turn_of_area`]) tells people that fill half of the picture from a cut.
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
/// Least correlation of the middle of the picture and of one of its halves, together: before a blank wall of the worse half, because noise
/// and a codec's blocks reach 0.6 now and then, but neither in both nor alone; else of the better one. (Cuts reach 0.7.)
const SAME: f64 = 1.0;
/// How alike, as a share of the best, the pictures may be where they are shifted elsewhere, and how far elsewhere is, small pixels. Grain
/// has no second place; what a codec leaves of a wall, or a shadow on it, has many.
const STANDS_OUT: f32 = 0.45;
const ELSEWHERE: i32 = 4;
/// Contrast under which parts of a picture are not brought to that of the others: noise, grey values, after the mean of an eighth of the size.
const FAINTEST: f32 = 0.3;
/// Turns under this are no turns, but a pattern that stands in the picture: dirt, dead pixels, a codec's blocks. 0.25°.
const STANDS_RAD: f64 = 0.0045;

/// The turn from one picture to the next before a blank wall, by its grain alone; `None` where there is none, or it says nothing.
pub fn turn_of_blank(camera: &Camera, last: &Level, now: &Level) -> Option<Turn> {
    let (last, now) = (Grain::of(last), Grain::of(now));
    let shift = last.shift(&now)?;
    let stands_out = shift.by != (0, 0) && shift.second < STANDS_OUT * shift.correlation;
    let (turn, halves) = refined(camera, last, now, &shift)?;
    let same = f64::from(shift.correlation) + halves[0].min(halves[1]) > SAME;
    (stands_out && same && turn.now_from_last.angle() > STANDS_RAD).then_some(turn)
}

/// The turn from one picture to the next as most of their area says: all parts count alike, so that people before the lens are outvoted
/// by the wall behind them. `None` where the pictures have no turn in common, as those on the two sides of a cut.
pub fn turn_of_area(camera: &Camera, last: &Level, now: &Level) -> Option<Turn> {
    let (last, now) = (Grain::of(last).evened(), Grain::of(now).evened());
    let shift = last.shift(&now)?;
    let (turn, halves) = refined(camera, last, now, &shift)?;
    // Somebody may stand in the other half.
    (f64::from(shift.correlation) + halves[0].max(halves[1]) > SAME).then_some(turn)
}

/// The turn at a shift of the middle of the picture, improved over all of it, and how alike its halves then are.
fn refined(camera: &Camera, last: Grain, now: Grain, shift: &Shift) -> Option<(Turn, [f64; 2])> {
    let shrink = camera.width as f64 / last.0.width as f64;
    let by = (shrink * f64::from(shift.by.0), shrink * f64::from(shift.by.1));
    let guess = UnitQuaternion::rotation_between(&camera.ray(camera.cx, camera.cy), &camera.ray(camera.cx + by.0, camera.cy + by.1))?;
    let (last, now) = (SmallPicture::of_grain(last.0, camera.width), SmallPicture::of_grain(now.0, camera.width));
    let turn = super::turn::align(camera, &last, &now, &[guess])?;
    let halves = super::turn::halves(camera, &last, &now, &turn.now_from_last)?;
    Some((turn, halves))
}

/// Where the middle of a picture went, in small pixels, how alike it is there, and elsewhere at best.
struct Shift {
    by: (i32, i32),
    correlation: f32,
    second: f32,
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

    /// The same with all of its parts of the same contrast.
    fn evened(mut self) -> Self {
        let squares = self.0.data.iter().map(|v| v * v).collect();
        let around = mean_around(&Level { data: squares, ..self.0.clone() });
        self.0.data.iter_mut().zip(around).for_each(|(value, square)| *value /= (square + FAINTEST * FAINTEST).sqrt());
        self
    }

    /// Where the middle of this picture is found in the next one.
    fn shift(&self, next: &Self) -> Option<Shift> {
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
        let (correlation, dx, dy) = *found.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let elsewhere = found.iter().filter(|f| (f.1 - dx).abs().max((f.2 - dy).abs()) > ELSEWHERE);
        Some(Shift { by: (dx, dy), correlation, second: elsewhere.map(|f| f.0).fold(-1.0, f32::max) })
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
            let found = turn_of_blank(&camera, &before, &wall(&camera, &turned, 2)).expect("the paint is told from the noise");
            // A fifth of a small pixel, which is 4 px of 250 here; roll is told by the picture's border alone.
            assert!(found.now_from_last.angle_to(&turned.inverse()) < 0.01, "{axis}: {}", found.now_from_last.scaled_axis());
        }
    }

    #[test]
    fn a_person_who_goes_the_other_way_is_outvoted_by_the_wall() {
        let camera = Camera::phone_prior(640, 480);
        // A shirt of strong squares over a third of the picture, and paint of less than a grey value around it.
        let seen = |world_from_camera: &UnitQuaternion<f64>, shirt_at: usize, noise: u64| {
            let mut rng = Seed(noise).derive("noise", 0);
            let image = GrayImage::from_fn(640, 480, |u, v| {
                let wall = 150.0 + paint(&(world_from_camera * camera.ray(u as f64, v as f64) * 0.4));
                let shirt = (shirt_at..shirt_at + 200).contains(&u) && v > 120;
                let square = if ((u.wrapping_sub(shirt_at)) / 20 + v / 20).is_multiple_of(2) { 40.0 } else { 200.0 };
                (if shirt { square } else { wall } + uniform(&mut rng, -3.5, 3.5)).round() as u8
            });
            Pyramid::new(&image, 4).levels.pop().expect("a pyramid has a level")
        };
        let turned = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.08, 0.0));
        let (before, after) = (seen(&UnitQuaternion::identity(), 20, 1), seen(&turned, 90, 2));
        let found = turn_of_area(&camera, &before, &after).expect("two thirds of the picture went one way");
        assert!(found.now_from_last.angle_to(&turned.inverse()) < 0.015, "{}", found.now_from_last.scaled_axis());
        let elsewhere = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 1.5, 0.0));
        assert!(turn_of_area(&camera, &before, &seen(&elsewhere, 400, 3)).is_none(), "another place");
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
        assert!(turn_of_blank(&camera, &level(&plain, 1), &level(&plain, 2)).is_none(), "noise");
        // The same in both pictures: on the lens, or a codec's blocks.
        let still = UnitQuaternion::identity();
        assert!(turn_of_blank(&camera, &wall(&camera, &still, 1), &wall(&camera, &still, 2)).is_none(), "dirt");
        // Stripes of wallpaper fit wherever they are laid a stripe further on.
        let stripes = |shift: usize| move |u: usize, _: usize| 140.0 + if ((u + shift) / 24).is_multiple_of(2) { 3.0 } else { 0.0 };
        assert!(turn_of_blank(&camera, &level(&stripes(0), 1), &level(&stripes(13), 2)).is_none(), "stripes");
    }
}

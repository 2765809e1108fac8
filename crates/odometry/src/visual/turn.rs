//! How did the camera turn since the last picture, as the picture as a whole says? Alignment of small blurry images.
//!
//! Tracking each point needs to know roughly where to look; a head turns by many pixels a frame and stops at once, so the
//! last turn is a poor guess. The idea is that of PTAM (Klein & Murray 2008, §3.2): the smallest level of the pyramid, blurred,
//! aligned over the three degrees of a rotation by inverse-compositional Gauss–Newton; here on rays, for any lens.

use nalgebra::{Matrix2x3, Matrix3, UnitQuaternion, Vector2, Vector3};
use planwalk_types::Camera;

use super::image::Level;
use super::two_view::epipolar::skew;

/// Largest width of the image that is aligned, pixels: at 640, one pixel of it is 16, and its basin some 2 pixels.
const WIDTH: usize = 48;

/// Contrast under which a small picture shows nothing, grey values (root mean square about the mean): a blank wall's noise, and
/// the blocks that a codec made of it, which stay where they are in the picture and align perfectly with themselves.
const LEAST_CONTRAST: f64 = 4.0;
/// The same of a picture's grain: under it, grey values that are whole numbers leave nothing.
const LEAST_GRAIN: f64 = 0.1;

/// A small picture, and where each of its pixels looks.
#[derive(Debug, Clone)]
pub struct SmallPicture {
    level: Level,
    /// Contrast under which it shows nothing, grey values.
    least_contrast: f64,
    /// Full-size pixels per pixel of the level.
    shrink: f64,
}

impl SmallPicture {
    /// Of the smallest level of a pyramid whose full size is `full_width` wide.
    pub fn new(smallest: &Level, full_width: usize) -> Self {
        let mut level = smallest.clone();
        while level.width > WIDTH && level.width.min(level.height) >= 16 {
            level = super::image::halve(&level);
        }
        let level = blurred(&level);
        let shrink = full_width as f64 / level.width as f64;
        Self { level, least_contrast: LEAST_CONTRAST, shrink }
    }

    /// Of the grain of a picture whose full size is `full_width` wide.
    pub(super) fn of_grain(level: Level, full_width: usize) -> Self {
        let shrink = full_width as f64 / level.width as f64;
        Self { level, least_contrast: LEAST_GRAIN, shrink }
    }

    /// Level pixel of a full-size pixel, and back.
    fn shrunk(&self, full: &Vector2<f64>) -> (f32, f32) {
        (((full.x + 0.5) / self.shrink - 0.5) as f32, ((full.y + 0.5) / self.shrink - 0.5) as f32)
    }

    fn full(&self, x: f64, y: f64) -> Vector2<f64> {
        Vector2::new((x + 0.5) * self.shrink - 0.5, (y + 0.5) * self.shrink - 0.5)
    }
}

/// [1 2 1]/4 in both directions: without it, edges of single pixels make a basin of single pixels.
fn blurred(level: &Level) -> Level {
    let (w, h) = (level.width, level.height);
    let at = |u: isize, v: isize| level.data[v.clamp(0, h as isize - 1) as usize * w + u.clamp(0, w as isize - 1) as usize];
    let mut data = Vec::with_capacity(w * h);
    for v in 0..h as isize {
        for u in 0..w as isize {
            let row = |v: isize| at(u - 1, v) + 2.0 * at(u, v) + at(u + 1, v);
            data.push((row(v - 1) + 2.0 * row(v) + row(v + 1)) / 16.0);
        }
    }
    Level { width: w, height: h, data }
}

/// A turn and how alike the pictures are after it.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// `now ← last`: turns rays of the last frame into rays of this one.
    pub now_from_last: UnitQuaternion<f64>,
    /// Normalised correlation of the overlap, −1..=1.
    pub correlation: f64,
}

/// One pixel of the last picture: its ray, value, and how the value changes when the ray is turned.
struct Sample {
    ray: Vector3<f64>,
    value: f64,
    by_turn: Vector3<f64>,
}

/// The rotation that best aligns the pictures from any of these guesses; `None` for pictures without structure.
pub fn align(camera: &Camera, last: &SmallPicture, now: &SmallPicture, guesses: &[UnitQuaternion<f64>]) -> Option<Turn> {
    let samples = samples(camera, last);
    let hessian: Matrix3<f64> = samples.iter().map(|s| s.by_turn * s.by_turn.transpose()).sum();
    let inverse = hessian.try_inverse()?;
    let turns = guesses.iter().filter_map(|guess| descend(camera, &samples, &inverse, now, *guess));
    turns.max_by(|a, b| a.correlation.total_cmp(&b.correlation))
}

/// Correlation of the left and the right half of the last picture after this turn; `None` where a half is out of view.
pub(super) fn halves(camera: &Camera, last: &SmallPicture, now: &SmallPicture, turn: &UnitQuaternion<f64>) -> Option<[f64; 2]> {
    let (left, right): (Vec<_>, Vec<_>) = samples(camera, last).into_iter().partition(|s| (turn * s.ray).x + s.ray.x < 0.0);
    Some([correlate(camera, &left, now, turn)?.correlation, correlate(camera, &right, now, turn)?.correlation])
}

/// Turns that are looked through by [`search`]: to the sides by up to so many steps, up and down by so many; 3° each, which is within
/// a step's basin.
const STEP_RAD: f64 = 0.052;
const ASIDE: i32 = 9;
const UP_AND_DOWN: i32 = 2;
/// Of the small picture's pixels, every so many-th is compared before any guess is improved.
const SPARSE: usize = 3;
/// Turns that are found at most.
const FOUND: usize = 3;

/// The turns, of all that a head can make between two pictures, that align them best: up to three that differ, the best first.
pub fn search(camera: &Camera, last: &SmallPicture, now: &SmallPicture) -> Vec<Turn> {
    let samples = samples(camera, last);
    let hessian: Matrix3<f64> = samples.iter().map(|s| s.by_turn * s.by_turn.transpose()).sum();
    let Some(inverse) = hessian.try_inverse() else { return Vec::new() };
    let sparse: Vec<&Sample> = samples.iter().step_by(SPARSE).collect();
    let guess = |(aside, up): (i32, i32)| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(f64::from(up), f64::from(aside), 0.0) * STEP_RAD);
        Some((correlate(camera, &sparse, now, &turn)?.correlation, turn))
    };
    let all = (-ASIDE..=ASIDE).flat_map(|aside| (-UP_AND_DOWN..=UP_AND_DOWN).map(move |up| (aside, up)));
    let mut guesses: Vec<(f64, UnitQuaternion<f64>)> = all.filter_map(guess).collect();
    guesses.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut starts: Vec<UnitQuaternion<f64>> = Vec::new();
    for (_, turn) in guesses {
        if starts.len() < FOUND && starts.iter().all(|s| s.angle_to(&turn) > 1.5 * STEP_RAD) {
            starts.push(turn);
        }
    }
    let mut found: Vec<Turn> = starts.iter().filter_map(|start| descend(camera, &samples, &inverse, now, *start)).collect();
    found.sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
    found
}

fn samples(camera: &Camera, picture: &SmallPicture) -> Vec<Sample> {
    let level = &picture.level;
    let mut samples = Vec::with_capacity(level.width * level.height);
    for v in 1..level.height.saturating_sub(1) {
        for u in 1..level.width.saturating_sub(1) {
            let at = |u: usize, v: usize| f64::from(level.data[v * level.width + u]);
            let gradient = Vector2::new(at(u + 1, v) - at(u - 1, v), at(u, v + 1) - at(u, v - 1)) * (0.5 / picture.shrink);
            let full = picture.full(u as f64, v as f64);
            let ray = camera.ray(full.x, full.y);
            let Some(by_ray) = projection_slope(camera, &ray, &full) else { continue };
            // A ray turned by θ moves by θ × ray = −[ray]× θ.
            let by_turn = (gradient.transpose() * by_ray * -skew(&ray)).transpose();
            samples.push(Sample { ray, value: at(u, v), by_turn });
        }
    }
    samples
}

/// Derivative of the projection by the ray, by forward differences: exact enough for a Gauss–Newton slope.
fn projection_slope(camera: &Camera, ray: &Vector3<f64>, pixel: &Vector2<f64>) -> Option<Matrix2x3<f64>> {
    let mut slope = Matrix2x3::zeros();
    for i in 0..3 {
        let mut moved = *ray;
        moved[i] += 1e-5;
        slope.set_column(i, &((camera.project(&moved)? - pixel) / 1e-5));
    }
    Some(slope)
}

/// How alike two pictures are after a turn, and where more of it lies.
struct Comparison {
    correlation: f64,
    gradient: Vector3<f64>,
    count: f64,
}

/// `None` where less than two fifths of the picture is in common, or where that shows nothing.
fn correlate<'s>(
    camera: &Camera,
    samples: &'s [impl std::borrow::Borrow<Sample> + 's],
    now: &SmallPicture,
    turn: &UnitQuaternion<f64>,
) -> Option<Comparison> {
    let samples = samples.iter().map(std::borrow::Borrow::borrow);
    let all = samples.len();
    let pairs: Vec<(&Sample, f64)> = samples.filter_map(|s| Some((s, look(camera, now, &(turn * s.ray))?))).collect();
    if 5 * pairs.len() < 2 * all {
        return None;
    }
    let count = pairs.len() as f64;
    let mean_last = pairs.iter().map(|(s, _)| s.value).sum::<f64>() / count;
    let mean_now = pairs.iter().map(|(_, v)| v).sum::<f64>() / count;
    let (mut gradient, mut both, mut last2, mut now2) = (Vector3::zeros(), 0.0, 1e-9, 1e-9);
    for (sample, value) in &pairs {
        let (a, b) = (sample.value - mean_last, value - mean_now);
        gradient += sample.by_turn * (b - a);
        both += a * b;
        last2 += a * a;
        now2 += b * b;
    }
    let shows = last2.min(now2) >= now.least_contrast.powi(2) * count;
    shows.then(|| Comparison { correlation: both / (last2 * now2).sqrt(), gradient, count })
}

/// Gauss–Newton from one guess.
fn descend(camera: &Camera, samples: &[Sample], inverse: &Matrix3<f64>, now: &SmallPicture, guess: UnitQuaternion<f64>) -> Option<Turn> {
    let mut turn = guess;
    let mut correlation = -1.0;
    for _ in 0..12 {
        let compared = correlate(camera, samples, now, &turn)?;
        correlation = compared.correlation;
        let step = inverse * compared.gradient * (samples.len() as f64 / compared.count);
        let step = step * (0.2 / step.norm().max(0.2));
        turn *= UnitQuaternion::from_scaled_axis(step).inverse();
        if step.norm() < 2e-4 {
            break;
        }
    }
    Some(Turn { now_from_last: turn, correlation })
}

fn look(camera: &Camera, picture: &SmallPicture, ray: &Vector3<f64>) -> Option<f64> {
    let (x, y) = picture.shrunk(&camera.project(ray)?);
    picture.level.holds(x, y, 0.0).then(|| f64::from(picture.level.sample(x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::image::Pyramid;
    use planwalk_types::GrayImage;

    /// What a camera turned by `world_from_camera` sees of a world of smooth blobs at infinity.
    fn view(camera: &Camera, world_from_camera: &UnitQuaternion<f64>, brighter: f64) -> SmallPicture {
        let image = GrayImage::from_fn(camera.width, camera.height, |u, v| {
            let d = world_from_camera * camera.ray(u as f64, v as f64);
            let value = 110.0 + 50.0 * (7.0 * d.x + 2.0 * d.y).sin() + 40.0 * (9.0 * d.y - 4.0 * d.x).cos() + brighter;
            value as u8
        });
        let pyramid = Pyramid::new(&image, 4);
        SmallPicture::new(&pyramid.levels[pyramid.levels.len() - 1], camera.width)
    }

    #[test]
    fn a_turn_of_many_pixels_is_found_without_a_guess() {
        let camera = Camera::phone_prior(640, 480);
        for axis in [Vector3::new(0.0, 0.08, 0.0), Vector3::new(0.03, -0.05, 0.02), Vector3::new(-0.05, 0.0, 0.04)] {
            let turned = UnitQuaternion::from_scaled_axis(axis);
            let (last, now) = (view(&camera, &UnitQuaternion::identity(), 0.0), view(&camera, &turned, 20.0));
            let found = align(&camera, &last, &now, &[UnitQuaternion::identity()]).unwrap();
            // A tenth of a small pixel: 16 px of 500, over ten.
            assert!(found.now_from_last.angle_to(&turned.inverse()) < 3e-3, "{axis}: {found:?}");
            assert!(found.correlation > 0.97, "{axis}: {found:?}");
        }
    }

    #[test]
    fn a_blank_picture_has_no_turn() {
        let camera = Camera::phone_prior(640, 480);
        let blank = Pyramid::new(&GrayImage::from_fn(640, 480, |_, _| 80), 4);
        let blank = SmallPicture::new(&blank.levels[3], 640);
        assert!(align(&camera, &blank, &blank, &[UnitQuaternion::identity()]).is_none());
    }
}

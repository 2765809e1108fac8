//! How well do a camera's turns explain the points that it followed, if the lens is so long?
//!
//! matches of two pictures ─▶ for each focal length: the essential matrix that explains them best ─▶ log-likelihood of what is left
//!
//! A turned camera moves points by H = K R K⁻¹: those at the border go farther than those in the middle, by θ u²/f, and aslant, by θ u v/f
//! (Hartley 1997, "Self-calibration of stationary cameras"). Residual: Sampson's, of the essential matrix (as Bougnoux 1998 has it, the focal
//! length is what is left when the principal point is known); so parallax does not count against a lens.
//!
//! Pitfall: a camera that only goes ahead says nothing of its lens, nor does one that looks at a wall: the curve is flat.

use nalgebra::{Vector2, Vector3};
use rand::Rng;

use crate::visual::two_view::essential::{Twisted, residual};
use crate::visual::two_view::matches::Match;
use crate::visual::two_view::{RayPair, RelativePoseOptions, estimate_relative_pose};

/// Noise of a followed point, pixels at a width of 640: what KLT leaves over several frames.
const SIGMA_PX: f64 = 0.6;
/// Residual from which on a match says nothing, in standard deviations.
const CUT: f64 = 5.0;
/// Steps of least squares at each focal length.
const STEPS: usize = 6;
/// Fewest matches that say anything.
const FEWEST: usize = 30;

/// A match in pixels from the principal point.
pub(super) type PixelPair = [Vector2<f64>; 2];

/// Log-likelihood of the matches for each of these focal lengths, pixels, `middle` being the one to begin at; `None` of too few.
pub(super) fn curve(pairs: &[PixelPair], width: f64, lenses: &[f64], middle: usize, rng: &mut impl Rng) -> Option<Vec<f64>> {
    if pairs.len() < FEWEST {
        return None;
    }
    let sigma_px = SIGMA_PX * width / 640.0;
    let focal = *lenses.get(middle)?;
    let ray = |p: &Vector2<f64>| Vector3::new(p.x / focal, p.y / focal, 1.0).normalize();
    let rays: Vec<RayPair> = pairs.iter().map(|[a, b]| RayPair { a: ray(a), b: ray(b) }).collect();
    // The lens may be another: what it bends is no outlier.
    let options = RelativePoseOptions { limit_rad: 3.0 * CUT * sigma_px / focal, ..RelativePoseOptions::for_focal(focal) };
    let fit = estimate_relative_pose(&rays, &options, rng)?;
    let start = Twisted { rotation: fit.pose.rotation.to_rotation_matrix().into_inner(), direction: fit.pose.direction };
    let mut values = vec![0.0; lenses.len()];
    for order in [(0..=middle).rev().collect::<Vec<_>>(), (middle..lenses.len()).collect()] {
        let mut pose = start;
        let mut last = focal;
        for i in order {
            let focal = lenses[i];
            let (cost, found) = best(pairs, focal, sigma_px, &[rescaled(&pose, last / focal), pose]);
            values[i] = -0.5 * cost;
            (pose, last) = (found, focal);
        }
    }
    Some(values)
}

/// The same way, and so much more or less of a turn.
fn rescaled(pose: &Twisted, by: f64) -> Twisted {
    let turn = nalgebra::Rotation3::from_matrix_unchecked(pose.rotation).scaled_axis();
    Twisted { rotation: nalgebra::Rotation3::from_scaled_axis(turn * by).into_inner(), direction: pose.direction }
}

fn best(pairs: &[PixelPair], focal: f64, sigma_px: f64, starts: &[Twisted]) -> (f64, Twisted) {
    let at = |p: &Vector2<f64>| [p.x / focal, p.y / focal];
    let matches: Vec<Match> = pairs.iter().enumerate().map(|(pair, [a, b])| Match { a: at(a), b: at(b), weight: 1.0, pair }).collect();
    let sigma = sigma_px / focal;
    let settle = |start: &Twisted| {
        let mut pose = *start;
        for k in 0..STEPS {
            let limit = if k < 2 { 3.0 * CUT } else { CUT } * sigma;
            let before = pose;
            if pose.step(matches.iter(), limit).is_none() {
                pose = before;
                break;
            }
        }
        let essential = pose.essential();
        let cost: f64 = matches.iter().map(|m| (residual(&essential, m) / sigma).powi(2).min(CUT * CUT)).sum();
        (cost, pose)
    };
    let settled = starts.iter().map(settle);
    settled.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, starts[0]))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::visual::two_view::scene::uniform;
    use nalgebra::UnitQuaternion;
    use planwalk_types::Seed;

    const LENSES: [f64; 11] = [300.0, 350.0, 400.0, 440.0, 480.0, 500.0, 520.0, 560.0, 600.0, 700.0, 800.0];

    /// Points before a lens of 500 px that turns about its upright axis and moves, with a third of a pixel of noise; a share goes anywhere.
    pub fn pairs(seed: u64, turn_rad: f64, way: Vector3<f64>, wild: f64) -> Vec<PixelPair> {
        let mut rng = Seed(seed).derive("turn", 0);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * turn_rad);
        let mut pairs = Vec::new();
        while pairs.len() < 150 {
            let a = Vector2::new(uniform(&mut rng, -300.0, 300.0), uniform(&mut rng, -220.0, 220.0));
            let depth = uniform(&mut rng, 2.0, 8.0);
            let point = turn * (Vector3::new(a.x / 500.0, a.y / 500.0, 1.0) * depth) + way;
            let noise = Vector2::new(uniform(&mut rng, -0.6, 0.6), uniform(&mut rng, -0.6, 0.6));
            let b = 500.0 * point.xy() / point.z + noise;
            let lost = Vector2::new(uniform(&mut rng, -300.0, 300.0), uniform(&mut rng, -220.0, 220.0));
            let b = if uniform(&mut rng, 0.0, 1.0) < wild { lost } else { b };
            if b.x.abs() < 320.0 && b.y.abs() < 240.0 {
                pairs.push([a, b]);
            }
        }
        pairs
    }

    fn curve_of(seed: u64, turn_rad: f64, way: Vector3<f64>, wild: f64) -> Vec<f64> {
        curve(&pairs(seed, turn_rad, way, wild), 640.0, &LENSES, 5, &mut Seed(seed).derive("test", 0)).unwrap()
    }

    #[test]
    fn a_turn_shows_its_lens_whether_the_camera_moves_or_not() {
        for way in [Vector3::zeros(), Vector3::new(0.2, 0.05, -0.3)] {
            let best = |seed: u64| {
                let curve = curve_of(seed, 0.2, way, 0.2);
                LENSES[(0..LENSES.len()).max_by(|a, b| curve[*a].total_cmp(&curve[*b])).unwrap()]
            };
            // Between 480 and 520 px, points at the border go half a pixel less or more, aslant: 120 of them know.
            let right = (0..10).filter(|seed| (best(*seed) - 500.0).abs() <= 40.0).count();
            assert!(right >= 9, "{right} of 10, {way:?}");
        }
    }

    #[test]
    fn going_straight_ahead_says_nothing() {
        for seed in 0..5 {
            let curve = curve_of(seed, 0.0, Vector3::new(0.0, 0.0, -0.5), 0.0);
            let (low, high) = curve.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
            // Six parameters find some noise of 150 points to explain: a few half squares, of which a twentieth will count.
            assert!(high - low < 10.0, "seed {seed}: {curve:?}");
        }
    }

    #[test]
    fn few_or_senseless_points_say_nothing() {
        let rng = &mut Seed(1).derive("test", 0);
        assert!(curve(&[], 640.0, &LENSES, 5, rng).is_none());
        let lost = vec![[Vector2::repeat(f64::NAN); 2]; 50];
        assert!(curve(&lost, 640.0, &LENSES, 5, rng).is_none());
    }
}

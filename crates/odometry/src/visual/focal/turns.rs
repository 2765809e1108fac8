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

//! Which essential matrices fit three pairs exactly, if up is known in both pictures? Fraundorfer, Tanskanen & Pollefeys 2010 (ECCV).
//!
//! rays ─▶ turned until up is up in both ─▶ a turn by θ about up is left ─▶ three rows (R(θ) a) × b at right angles to the way
//! ─▶ determinant, a trigonometric polynomial of θ ─▶ quartic in tan θ/2 (Sweeney, Flynn & Turk 2014, §3) ─▶ θ, way ─▶ E
//!
//! Three right pairs are drawn far sooner than five: at 70 % of wrong ones after 250 samples, not 2800 (Fischler & Bolles 1981, 99.9 %).
//! Pitfalls: an answer is off by as much as up is, and only what improves on it over many pairs makes that good; where the camera only
//! turned, every row is zero and there is no answer; a half turn (θ = π) is at infinity and is not found.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::matches::Match;
use super::{RayPair, polynomial};

/// Three rows whose cross products are all shorter than this, as sines, share a line: they leave the way open.
const LEAST_SINE: f64 = 1e-9;

/// Up to four essential matrices, of norm √2, that fit the first three of these pairs; `ups` are unit vectors, in A's and B's frame.
pub fn solve(pairs: &[RayPair], ups: &[Vector3<f64>; 2]) -> Vec<Matrix3<f64>> {
    let mut found = Vec::with_capacity(4);
    if let (Some(sample), Some(upright)) = (pairs.first_chunk(), Uprights::of(ups)) {
        upright.solve_rays(sample, &mut found);
    }
    found
}

/// Turns of both cameras that put up where it belongs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Uprights {
    /// `level_from_a` and `level_from_b`: up is y there.
    turns: [Matrix3<f64>; 2],
}

impl Uprights {
    /// `None` where a vector has no direction.
    pub fn of(ups: &[Vector3<f64>; 2]) -> Option<Self> {
        let turn = |up: &Vector3<f64>| {
            let up = up.try_normalize(1e-9).filter(|up| up.iter().all(|v| v.is_finite()))?;
            // Where up is −y, as in an upright camera, any half turn about a level axis will do.
            let turn = Rotation3::rotation_between(&up, &Vector3::y());
            Some(turn.map_or_else(|| Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)), Rotation3::into_inner))
        };
        Some(Self { turns: [turn(&ups[0])?, turn(&ups[1])?] })
    }

    /// Adds what fits the first three of these matches.
    pub fn solve_matches(&self, sample: &[Match], found: &mut Vec<Matrix3<f64>>) {
        let ray = |p: [f64; 2]| Vector3::new(p[0], p[1], 1.0);
        if let Some(sample) = sample.first_chunk::<3>() {
            self.solve_rays(&sample.map(|m| RayPair { a: ray(m.a), b: ray(m.b) }), found);
        }
    }

    fn solve_rays(&self, sample: &[RayPair; 3], found: &mut Vec<Matrix3<f64>>) {
        let level = sample.map(|pair| RayPair { a: (self.turns[0] * pair.a).normalize(), b: (self.turns[1] * pair.b).normalize() });
        for half in polynomial::real_roots(&quartic(&level)) {
            // c = cos θ, s = sin θ of θ = 2 atan(half).
            let (c, s) = ((1.0 - half * half) / (1.0 + half * half), 2.0 * half / (1.0 + half * half));
            let Some(way) = way(&rows(&level, c, s)) else { continue };
            let turn = Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
            found.push(self.turns[1].transpose() * way.cross_matrix() * turn * self.turns[0]);
        }
    }
}

/// What is at right angles to the way, after a turn about y: (R a) × b of each pair.
fn rows(level: &[RayPair; 3], c: f64, s: f64) -> [Vector3<f64>; 3] {
    level.map(|p| Vector3::new(c * p.a.x + s * p.a.z, p.a.y, c * p.a.z - s * p.a.x).cross(&p.b))
}

/// The unit vector at right angles to all three rows: the best conditioned of their cross products.
fn way(rows: &[Vector3<f64>; 3]) -> Option<Vector3<f64>> {
    let crosses = [rows[0].cross(&rows[1]), rows[1].cross(&rows[2]), rows[2].cross(&rows[0])];
    crosses.iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?.try_normalize(LEAST_SINE)
}

/// cos and sin of k · 72°.
const FIFTHS: [(f64, f64); 5] = [
    (1.0, 0.0),
    (0.309_016_994_374_947_45, 0.951_056_516_295_153_5),
    (-0.809_016_994_374_947_5, 0.587_785_252_292_473_1),
    (-0.809_016_994_374_947_5, -0.587_785_252_292_473_1),
    (0.309_016_994_374_947_45, -0.951_056_516_295_153_5),
];

/// The rows' determinant as a polynomial of tan θ/2, lowest power first.
///
/// Each row is linear in cos θ and sin θ, so that the determinant might reach the third harmonic; but at the first harmonic's own pitch
/// the x and z columns are the same but for a factor i, and it ends at the second: five values of it say everything.
fn quartic(level: &[RayPair; 3]) -> [f64; polynomial::DEGREE + 1] {
    let values = FIFTHS.map(|(c, s)| {
        let [first, second, third] = rows(level, c, s);
        first.dot(&second.cross(&third))
    });
    // The discrete Fourier transform of five values: mean, and cosine and sine of both harmonics.
    let sum = |of: &dyn Fn(usize) -> f64| (0..5).map(|k| values[k] * of(k)).sum::<f64>() * 0.4;
    let mean = 0.5 * sum(&|_| 1.0);
    let (cos1, sin1) = (sum(&|k| FIFTHS[k].0), sum(&|k| FIFTHS[k].1));
    let (cos2, sin2) = (sum(&|k| FIFTHS[2 * k % 5].0), sum(&|k| FIFTHS[2 * k % 5].1));
    // With cos θ = (1 − q²) / (1 + q²) and sin θ = 2q / (1 + q²), times (1 + q²)².
    let powers = [mean + cos1 + cos2, 2.0 * sin1 + 4.0 * sin2, 2.0 * mean - 6.0 * cos2, 2.0 * sin1 - 4.0 * sin2, mean - cos1 + cos2];
    std::array::from_fn(|i| powers.get(i).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::essential::Twisted;
    use crate::visual::two_view::{RelativePose, epipolar, five_point, scene};
    use nalgebra::{Rotation3, UnitQuaternion};

    /// Up in both frames, some direction or other that the turn between them carries over.
    fn ups(seed: u64, truth: &RelativePose) -> [Vector3<f64>; 2] {
        let roll = 0.1 * (seed % 7) as f64 - 0.3;
        let up = UnitQuaternion::from_scaled_axis(Vector3::new(0.2 * roll, 0.0, roll)) * -Vector3::y();
        [up, truth.rotation * up]
    }

    fn nearest(found: &[Matrix3<f64>], truth: &RelativePose) -> f64 {
        let expected = epipolar::essential_of(truth);
        found.iter().map(|e| (e - expected).norm().min((e + expected).norm())).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_truth_is_among_the_answers_of_three_exact_pairs() {
        let mut off: Vec<f64> = Vec::new();
        for seed in 0..300 {
            let (pairs, truth) = scene::pairs(seed, 3, 0.7, 0.0, 0.0);
            let found = solve(&pairs, &ups(seed, &truth));
            assert!(found.len() <= 4, "seed {seed}: {} answers of a quartic", found.len());
            for e in &found {
                assert!(
                    (e.norm_squared() - 2.0).abs() < 1e-9 && pairs.iter().all(|p| epipolar::epipolar_angle(e, p) < 1e-7),
                    "seed {seed}"
                );
            }
            off.push(nearest(&found, &truth));
        }
        off.sort_by(f64::total_cmp);
        // Round-off times what the sample magnifies: as a rule a thousand, of 300 samples one a hundred million.
        assert!(off[150] < 1e-12 && off[299] < 1e-7, "median {:e}, worst {:e}", off[150], off[299]);
    }

    #[test]
    fn five_exact_pairs_say_the_same_without_knowing_up() {
        for seed in 0..50 {
            let (pairs, truth) = scene::pairs(seed, 5, 0.7, 0.0, 0.0);
            let point = |ray: &Vector3<f64>| [ray.x / ray.z, ray.y / ray.z];
            let sample: Vec<Match> = pairs.iter().map(|p| Match { a: point(&p.a), b: point(&p.b), weight: 1.0, pair: 0 }).collect();
            let mut by_five = Vec::new();
            five_point::solve_into(&sample, &mut by_five);
            let fits_all = |e: &&Matrix3<f64>| pairs.iter().all(|p| epipolar::epipolar_angle(e, p) < 1e-6);
            let by_three = solve(&pairs, &ups(seed, &truth));
            let of_three = by_three.iter().find(fits_all).unwrap_or_else(|| panic!("seed {seed}: one fits the other two pairs"));
            let apart = by_five.iter().map(|e| (e - of_three).norm().min((e + of_three).norm())).fold(f64::INFINITY, f64::min);
            // The five-point method's own round-off (see there).
            assert!(apart < 1e-3, "seed {seed}: {apart:e}");
        }
    }

    #[test]
    fn an_up_that_is_off_by_half_a_degree_turns_the_answer_of_three_pairs_by_some_degree() {
        let mut off: Vec<f64> = Vec::new();
        for seed in 0..200 {
            let (pairs, truth) = scene::pairs(seed, 3, 1.5, 0.0, 0.0);
            let [a, b] = ups(seed, &truth);
            let way = 0.7 * seed as f64;
            let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(way.cos(), 0.0, way.sin()) * 0.5f64.to_radians());
            let poses = solve(&pairs, &[a, tilt * b]).into_iter().filter_map(|e| Twisted::of(&e));
            let rotations = poses.flat_map(|pose| [pose.rotation, pose.twin()]).map(Rotation3::from_matrix_unchecked);
            let rotations = rotations.map(|r| UnitQuaternion::from_rotation_matrix(&r));
            off.push(rotations.map(|r| r.angle_to(&truth.rotation).to_degrees()).fold(f64::INFINITY, f64::min));
        }
        off.sort_by(f64::total_cmp);
        // The tilt itself is always in it. The turn about up must make good for it, with pairs whose lever is a third: up to three times.
        assert!(off[100] > 0.5 && off[100] < 1.5, "median {}°", off[100]);
    }

    #[test]
    fn what_does_not_determine_a_motion_gives_nothing() {
        let (pairs, truth) = scene::pairs(1, 3, 0.7, 0.0, 0.0);
        let up = ups(1, &truth);
        assert!(solve(&pairs[..2], &up).is_empty() && solve(&[], &up).is_empty(), "two pairs");
        assert!(solve(&[pairs[0]; 3], &up).is_empty(), "one pair three times");
        assert!(solve(&pairs, &[Vector3::zeros(), up[1]]).is_empty(), "no up");
        assert!(solve(&pairs, &[up[0], Vector3::repeat(f64::NAN)]).is_empty(), "no number");
        let lost = pairs.iter().map(|p| RayPair { a: p.a * f64::NAN, b: p.b }).collect::<Vec<_>>();
        assert!(solve(&lost, &up).is_empty(), "no rays");
    }
}

//! Which essential matrix fits eight or more pairs? The normalised linear method (Hartley 1997; Hartley & Zisserman 2003, alg. 11.1).
//!
//! Works on the rays' image coordinates (x/z, y/z), each set moved to its centroid and scaled to a mean distance of √2.
//! Pitfall: points on one plane leave a family of answers; the five-point method does not mind.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::matches::Match;
use super::{RayPair, epipolar};

/// The same of matches on the planes at distance 1.
pub(crate) fn solve_matches(sample: &[Match]) -> Option<Matrix3<f64>> {
    let ray = |p: [f64; 2]| Vector3::new(p[0], p[1], 1.0);
    let pairs: Vec<RayPair> = sample.iter().map(|m| RayPair { a: ray(m.a), b: ray(m.b) }).collect();
    solve(&pairs)
}

/// The essential matrix that best fits at least eight pairs; `None` when there are fewer, or they do not determine one.
pub fn solve(pairs: &[RayPair]) -> Option<Matrix3<f64>> {
    if pairs.len() < 8 || pairs.iter().any(|p| p.a.z < 0.05 || p.b.z < 0.05) {
        return None;
    }
    let (to_a, to_b) = (normaliser(pairs.iter().map(|p| p.a))?, normaliser(pairs.iter().map(|p| p.b))?);
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for pair in pairs {
        let (a, b) = (to_a * (pair.a / pair.a.z), to_b * (pair.b / pair.b.z));
        let row = SMatrix::<f64, 9, 1>::from_fn(|i, _| b[i / 3] * a[i % 3]);
        normal += row * row.transpose();
    }
    // The normal equations square the condition, which normalisation keeps small (Hartley 1997, §5): 1e-16 becomes 1e-8.
    let eigen = normal.symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]));
    if !(eigen.eigenvalues[order[1]] > 1e-10 * eigen.eigenvalues[order[8]]) {
        return None;
    }
    let null = eigen.eigenvectors.column(order[0]);
    let fundamental = Matrix3::from_fn(|i, j| null[3 * i + j]);
    epipolar::nearest_essential(&(to_b.transpose() * fundamental * to_a))
}

/// The similarity that moves the points' centroid to 0 and their mean distance from it to √2.
fn normaliser(rays: impl Iterator<Item = Vector3<f64>> + Clone) -> Option<Matrix3<f64>> {
    let points = rays.map(|r| (r.x / r.z, r.y / r.z));
    let (n, sx, sy) = points.clone().fold((0.0, 0.0, 0.0), |(n, sx, sy), (x, y)| (n + 1.0, sx + x, sy + y));
    let (cx, cy) = (sx / n, sy / n);
    let mean = points.map(|(x, y)| (x - cx).hypot(y - cy)).sum::<f64>() / n;
    if !(mean > 1e-9) {
        return None;
    }
    let s = std::f64::consts::SQRT_2 / mean;
    Some(Matrix3::new(s, 0.0, -s * cx, 0.0, s, -s * cy, 0.0, 0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene;

    #[test]
    fn exact_pairs_give_the_exact_essential() {
        for seed in 0..20 {
            let (pairs, truth) = scene::pairs(seed, 20, 0.7, 0.0, 0.0);
            let found = solve(&pairs).expect("general points determine it");
            let expected = epipolar::essential_of(&truth);
            let sign = found.dot(&expected).signum();
            assert!((found * sign - expected).norm() < 1e-6, "seed {seed}: {found} for {expected}");
        }
    }

    #[test]
    fn too_few_or_degenerate_pairs_give_nothing() {
        let (pairs, _) = scene::pairs(1, 7, 0.7, 0.0, 0.0);
        assert!(solve(&pairs).is_none());
        assert!(solve(&vec![pairs[0]; 12]).is_none(), "one pair twelve times");
    }
}

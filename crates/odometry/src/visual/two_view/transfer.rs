//! How far is a match from where a 3×3 matrix puts its first point? What homographies and rotations have in common.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use wide::f32x8;

use super::essential::sum_costs;
use super::matches::{Lanes, Match, Matches};

/// Squared distance from the transferred point to the match; infinite behind the camera.
pub(crate) fn transfer_squared(h: &Matrix3<f64>, m: &Match) -> f64 {
    let p = h * Vector3::new(m.a[0], m.a[1], 1.0);
    if p.z > 1e-9 { (p.x / p.z - m.b[0]).powi(2) + (p.y / p.z - m.b[1]).powi(2) } else { f64::INFINITY }
}

/// Whether each match agrees.
pub(super) fn transfer_agrees(h: &Matrix3<f64>, matches: &Matches, limit: f64) -> Vec<bool> {
    matches.list.iter().map(|m| transfer_squared(h, m) < limit * limit).collect()
}

/// As [`super::robust::Kind::cost`].
pub(super) fn transfer_cost(h: &Matrix3<f64>, matches: &Matches, limit: f64, enough: f64) -> f64 {
    let h = [0, 1, 2].map(|r| [0, 1, 2].map(|c| f32x8::splat(h[(r, c)] as f32)));
    let squared = |lanes: &Lanes| {
        let ([x, y], [u, v]) = (lanes.a, lanes.b);
        let row = |r: usize| h[r][0] * x + h[r][1] * y + h[r][2];
        let inverse = f32x8::ONE / row(2);
        let (du, dv) = (row(0) * inverse - u, row(1) * inverse - v);
        // Behind the camera nothing agrees.
        inverse.simd_gt(f32x8::ZERO).select(du * du + dv * dv, f32x8::splat(1e30))
    };
    sum_costs(&matches.lanes, limit, enough, squared)
}

/// One step of Gauss–Newton with Tukey's weights: `rows` are the derivatives of both coordinates of the transferred point.
pub(super) fn least_squares<const N: usize>(
    h: &Matrix3<f64>,
    matches: &Matches,
    limit: f64,
    rows: impl Fn(&Match, &Vector3<f64>) -> [[f64; N]; 2],
) -> Option<SVector<f64, N>> {
    let (mut normal, mut gradient) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
    for m in &matches.list {
        let share = transfer_squared(h, m) / (limit * limit);
        if !(share < 1.0) {
            continue;
        }
        let p = h * Vector3::new(m.a[0], m.a[1], 1.0);
        let off = [p.x / p.z - m.b[0], p.y / p.z - m.b[1]];
        let weight = m.weight * (1.0 - share) * (1.0 - share);
        for (row, off) in rows(m, &p).into_iter().zip(off) {
            let row = SVector::<f64, N>::from(row);
            gradient += weight * off * row;
            normal.syger(weight, &row, &row, 1.0);
        }
    }
    normal.fill_upper_triangle_with_lower_triangle();
    let damped = normal + SMatrix::<f64, N, N>::identity() * (1e-9 * normal.trace().max(1e-30));
    Some(-damped.cholesky()?.solve(&gradient))
}

//! Which motions agree with matches on one plane? The homography as a [`Kind`] of model.
//!
//! Residual: how far the transferred point is from its match, at distance 1. Decomposition into rotation, direction and plane: Ma, Soatto, Košecká & Sastry 2004, §5.3.3.

use nalgebra::{Matrix3, Vector3};

use super::matches::{Match, Matches};
use super::robust::Kind;
use super::transfer::{least_squares, transfer_agrees, transfer_cost};

/// Homographies from four matches.
pub(crate) struct Plane;

impl Kind for Plane {
    type Model = Matrix3<f64>;

    fn sample_size(&self) -> usize {
        4
    }

    fn solve(&self, sample: &[Match], found: &mut Vec<Matrix3<f64>>) {
        let mut system = [[0.0; 9]; 8];
        for (k, m) in sample.iter().take(4).enumerate() {
            let ([x, y], [u, v]) = (m.a, m.b);
            system[2 * k] = [x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y, u];
            system[2 * k + 1] = [0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y, v];
        }
        let Some(h) = solved(system) else { return };
        let h = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0);
        // What is seen stays before the camera.
        if sample.iter().all(|m| h[(2, 0)] * m.a[0] + h[(2, 1)] * m.a[1] + 1.0 > 0.0) {
            found.push(h);
        }
    }

    fn cost(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64, enough: f64) -> f64 {
        transfer_cost(model, matches, limit, enough)
    }

    fn agree(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64) -> Vec<bool> {
        transfer_agrees(model, matches, limit)
    }

    fn improve(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64, steps: usize) -> Option<Matrix3<f64>> {
        let mut h = *model;
        for _ in 0..steps {
            if !(h[(2, 2)].abs() > 1e-6) {
                return None;
            }
            h /= h[(2, 2)];
            let rows = |m: &Match, p: &Vector3<f64>| {
                let ([x, y], [u, v], w) = (m.a, [p.x / p.z, p.y / p.z], p.z);
                let (x, y, one) = (x / w, y / w, 1.0 / w);
                [[x, y, one, 0.0, 0.0, 0.0, -x * u, -y * u], [0.0, 0.0, 0.0, x, y, one, -x * v, -y * v]]
            };
            let step = least_squares::<8>(&h, matches, limit, rows)?;
            for (k, d) in step.iter().enumerate() {
                h[(k / 3, k % 3)] += d;
            }
            if step.norm() < 1e-8 {
                break;
            }
        }
        h.iter().all(|v| v.is_finite()).then_some(h)
    }
}

/// Gauss with pivots; the last column is the right side.
fn solved(mut m: [[f64; 9]; 8]) -> Option<[f64; 8]> {
    for k in 0..8 {
        let pivot = (k..8).max_by(|i, j| m[*i][k].abs().total_cmp(&m[*j][k].abs()))?;
        m.swap(k, pivot);
        if !(m[k][k].abs() > 1e-10) {
            return None;
        }
        let lead = m[k];
        for row in m.iter_mut().skip(k + 1) {
            let factor = row[k] / lead[k];
            for c in k..9 {
                row[c] -= factor * lead[c];
            }
        }
    }
    let mut x = [0.0; 8];
    for k in (0..8).rev() {
        x[k] = (m[k][8] - (k + 1..8).map(|c| m[k][c] * x[c]).sum::<f64>()) / m[k][k];
    }
    Some(x)
}

/// A motion along a plane: H ~ R + t nᵀ, with t in distances of the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneMotion {
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
    /// Towards the plane, in the first camera.
    pub normal: Vector3<f64>,
}

/// The four motions of a homography between calibrated pictures (two of them see the plane from its back); none for a mere rotation.
pub(crate) fn decompose(h: &Matrix3<f64>) -> Vec<PlaneMotion> {
    let mut eigen: Vec<(f64, Vector3<f64>)> = {
        let e = (h.transpose() * h).symmetric_eigen();
        (0..3).map(|k| (e.eigenvalues[k].max(0.0), e.eigenvectors.column(k).into_owned())).collect()
    };
    eigen.sort_by(|x, y| y.0.total_cmp(&x.0));
    let middle = eigen[1].0;
    if !(middle > 1e-12) {
        return Vec::new();
    }
    let sign = h.determinant().signum();
    let h = h * (sign / middle.sqrt());
    let (s1, s3) = (eigen[0].0 / middle, eigen[2].0 / middle);
    // Without parallax all three are 1, and nothing says where the plane is.
    if !(s1 - s3 > 1e-9) {
        return Vec::new();
    }
    let (v1, v2, v3) = (eigen[0].1, eigen[1].1, eigen[2].1);
    let (p, q) = (((1.0 - s3).max(0.0) / (s1 - s3)).sqrt(), ((s1 - 1.0).max(0.0) / (s1 - s3)).sqrt());
    let mut all = Vec::with_capacity(4);
    for u in [v1 * p + v3 * q, v1 * p - v3 * q] {
        let frame = |a: Vector3<f64>, b: Vector3<f64>| Matrix3::from_columns(&[a, b, a.cross(&b)]);
        let (from, to) = (frame(v2, u), frame(h * v2, h * u));
        let rotation = to * from.transpose();
        let normal = v2.cross(&u);
        let translation = (h - rotation) * normal;
        for side in [1.0, -1.0] {
            all.push(PlaneMotion { rotation, translation: translation * side, normal: normal * side });
        }
    }
    all
}

//! How well does a relative pose explain a pair of rays, and where is the point?

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{RayPair, RelativePose};

/// The matrix of the cross product with `v`.
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// E = \[t\]× R of a relative pose (Hartley & Zisserman 2003, eq. 9.12).
pub fn essential_of(pose: &RelativePose) -> Matrix3<f64> {
    skew(&pose.direction) * pose.rotation.to_rotation_matrix().into_inner()
}

/// The angle from either ray to its epipolar plane, the larger of both, as its sine (radians where small).
pub fn epipolar_angle(essential: &Matrix3<f64>, pair: &RayPair) -> f64 {
    let plane_b = essential * pair.a;
    let plane_a = essential.tr_mul(&pair.b);
    let product = pair.b.dot(&plane_b).abs();
    // At the epipole the plane is undefined and the pair says nothing.
    let norm = plane_a.norm().min(plane_b.norm());
    if norm < 1e-9 { 0.0 } else { product / norm }
}

/// The nearest essential matrix: singular values (1, 1, 0). `None` for a matrix without two independent columns.
pub fn nearest_essential(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = matrix.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    let order = by_size(&svd.singular_values);
    let s = svd.singular_values;
    if !(s[order[1]] > 1e-12 * s[order[0]]) {
        return None;
    }
    Some(u.column(order[0]) * vt.row(order[0]) + u.column(order[1]) * vt.row(order[1]))
}

fn by_size(values: &Vector3<f64>) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    order
}

/// Distances along both rays to the point, in baselines, by the midpoint method; `None` for parallel rays.
///
/// Negative distances are behind a camera.
pub fn depths(pose: &RelativePose, pair: &RayPair) -> Option<(f64, f64)> {
    let ray_a = pose.rotation * pair.a;
    let cosine = ray_a.dot(&pair.b);
    let sine2 = 1.0 - cosine * cosine;
    if sine2 < 1e-12 {
        return None;
    }
    // Least squares of  λb·b − λa·(R a) = t.
    let (along_b, along_a) = (pair.b.dot(&pose.direction), ray_a.dot(&pose.direction));
    Some(((cosine * along_b - along_a) / sine2, (along_b - cosine * along_a) / sine2))
}

/// Angle between the rays once the rotation is taken off, radians: the parallax of the pair.
pub fn parallax(rotation: &UnitQuaternion<f64>, pair: &RayPair) -> f64 {
    let turned = rotation * pair.a;
    libm::atan2(turned.cross(&pair.b).norm(), turned.dot(&pair.b))
}

/// Two unit vectors that make a right-handed frame with `axis`.
pub(crate) fn tangent_basis(axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let other = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let u = axis.cross(&other).normalize();
    (u, axis.cross(&u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene;

    #[test]
    fn rays_of_an_exact_pose_meet_before_both_cameras() {
        for seed in 0..20 {
            let (pairs, pose) = scene::pairs(seed, 30, 0.7, 0.0, 0.0);
            let essential = nearest_essential(&(essential_of(&pose) * 3.0)).unwrap();
            for pair in &pairs {
                assert!(epipolar_angle(&essential, pair) < 1e-12);
                let (da, db) = depths(&pose, pair).unwrap();
                let apart = pose.rotation * pair.a * da + pose.direction - pair.b * db;
                assert!(da > 0.0 && db > 0.0 && apart.norm() < 1e-7, "{da}, {db}, {apart}");
            }
        }
    }
}

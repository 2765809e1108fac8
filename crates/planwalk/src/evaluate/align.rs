//! Which rotation, shift and scale bring an odometry's own frame onto the truth's?
//!
//! Least squares over positions (Umeyama 1991, eq. 34–43), as evo does it. Planar alignments look at x and y only.

use nalgebra::{Matrix2, Matrix3, Rotation3, UnitQuaternion, Vector3};
use planwalk_types::Similarity;
use serde::{Deserialize, Serialize};

use super::EvaluateError;

/// What is free when an estimate is laid over the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Alignment {
    /// Nothing: both are in one frame.
    None,
    /// Shift and turn on the floor; heights, roll and pitch are left out of all scores.
    Se2,
    /// Shift, turn and scale on the floor; heights, roll and pitch are left out of all scores.
    Sim2,
    /// Shift and turn in space.
    Se3,
    /// Shift, turn and scale in space: for a single camera.
    Sim3,
}

impl Alignment {
    /// Whether only the floor counts.
    pub fn planar(self) -> bool {
        matches!(self, Self::Se2 | Self::Sim2)
    }

    fn scaled(self) -> bool {
        matches!(self, Self::Sim2 | Self::Sim3)
    }
}

impl std::fmt::Display for Alignment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Se2 => "se2",
            Self::Sim2 => "sim2",
            Self::Se3 => "se3",
            Self::Sim3 => "sim3",
        })
    }
}

/// Lays positions of an estimate over the true ones, pair by pair: `truth_from_estimate`.
///
/// # Errors
/// [`EvaluateError::Degenerate`] where the positions do not say how to turn (a point; for alignments in space also a line).
pub fn align(estimate: &[Vector3<f64>], truth: &[Vector3<f64>], alignment: Alignment) -> Result<Similarity, EvaluateError> {
    if alignment == Alignment::None {
        return Ok(Similarity::identity());
    }
    let pairs = estimate.len().min(truth.len());
    let mean = |points: &[Vector3<f64>]| points.iter().take(pairs).sum::<Vector3<f64>>() / pairs.max(1) as f64;
    let (mean_e, mean_t) = (mean(estimate), mean(truth));
    let (mut covariance, mut spread_e, mut spread_t) = (Matrix3::zeros(), 0.0, 0.0);
    for (e, t) in estimate.iter().zip(truth) {
        let (mut e, mut t) = (e - mean_e, t - mean_t);
        if alignment.planar() {
            (e.z, t.z) = (0.0, 0.0);
        }
        covariance += t * e.transpose() / pairs as f64;
        spread_e += e.norm_squared() / pairs as f64;
        spread_t += t.norm_squared() / pairs as f64;
    }
    let degenerate = |shape, instead| EvaluateError::Degenerate { alignment, pairs, shape, instead };
    // Relative to the spread: a millimetre's walk and a kilometre's drive are told from a point alike.
    let least = 1e-12 * (spread_e * spread_t).sqrt();
    let turned = if alignment.planar() { planar(&covariance, least) } else { spatial(&covariance, least) };
    let (rotation, trace) = match turned {
        Ok(turned) => turned,
        Err(0) => return Err(degenerate("in one point: nothing moved", "--align none")),
        Err(_) => return Err(degenerate("on one line", "--align se2 or sim2")),
    };
    let scale = if alignment.scaled() { trace / spread_e } else { 1.0 };
    Ok(Similarity { scale, rotation, translation: mean_t - rotation * (scale * mean_e) })
}

/// Rotation and trace(D S), or how many directions the positions span where these are too few.
fn spatial(covariance: &Matrix3<f64>, least: f64) -> Result<(UnitQuaternion<f64>, f64), usize> {
    let svd = covariance.svd(true, true);
    let d = svd.singular_values;
    let rank = d.iter().filter(|v| **v > least).count();
    let (Some(u), Some(v_t), true) = (svd.u, svd.v_t, rank >= 2) else { return Err(rank) };
    // A mirror image is no rotation: the weakest direction is turned round (eq. 43).
    let sign = if u.determinant() * v_t.determinant() < 0.0 { -1.0 } else { 1.0 };
    let rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t;
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Ok((rotation, d[0] + d[1] + sign * d[2]))
}

/// The same on the floor, in closed form: the turn that makes Σ tᵀ R e largest.
fn planar(covariance: &Matrix3<f64>, least: f64) -> Result<(UnitQuaternion<f64>, f64), usize> {
    let c: Matrix2<f64> = covariance.fixed_view::<2, 2>(0, 0).into();
    let (along, across) = (c[(0, 0)] + c[(1, 1)], c[(1, 0)] - c[(0, 1)]);
    let trace = along.hypot(across);
    if trace > least {
        return Ok((UnitQuaternion::from_axis_angle(&Vector3::z_axis(), across.atan2(along)), trace));
    }
    Err(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn walk() -> Vec<Vector3<f64>> {
        (0..40).map(f64::from).map(|t| Vector3::new(0.3 * t, (0.2 * t).sin(), 0.05 * (0.7 * t).cos())).collect()
    }

    proptest! {
        #[test]
        fn a_walk_moved_turned_and_scaled_is_laid_back(
            roll in -3.0..3.0f64, pitch in -1.5..1.5f64, yaw in -3.0..3.0f64, scale in 0.05..20.0f64, x in -50.0..50.0f64
        ) {
            for (alignment, turn) in [
                (Alignment::Sim3, UnitQuaternion::from_euler_angles(roll, pitch, yaw)),
                (Alignment::Sim2, UnitQuaternion::from_euler_angles(0.0, 0.0, yaw)),
            ] {
                let truth: Vec<_> = walk().iter().map(|p| turn * (scale * p) + Vector3::new(x, -x, 1.0)).collect();
                let found = align(&walk(), &truth, alignment).unwrap();
                prop_assert!((found.scale / scale - 1.0).abs() < 1e-9 && found.rotation.angle_to(&turn) < 1e-6, "{found:?}");
            }
        }
    }

    #[test]
    fn a_point_and_a_line_are_refused_with_what_would_do() {
        let still = vec![Vector3::new(1.0, 2.0, 3.0); 9];
        for alignment in [Alignment::Se2, Alignment::Sim2, Alignment::Se3, Alignment::Sim3] {
            assert!(align(&still, &walk()[..9], alignment).unwrap_err().to_string().contains("nothing moved"));
        }
        let line: Vec<_> = (0..9).map(|i| Vector3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(align(&line, &line, Alignment::Sim3).unwrap_err().to_string().contains("sim2"));
        assert!((align(&line, &line, Alignment::Sim2).unwrap().scale - 1.0).abs() < 1e-12);
        assert_eq!(align(&[], &[], Alignment::None).unwrap(), Similarity::identity());
        assert!(align(&[], &[], Alignment::Sim3).is_err());
    }
}

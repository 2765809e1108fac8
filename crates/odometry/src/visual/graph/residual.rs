//! By how much do two keyframes contradict what was measured between them?
//!
//! E = `a_from_b`⁻¹ · `odom_from_a`⁻¹ · `odom_from_b` would be the identity; r = [ρ; θ; λ] of E, in B's axes and unit.
//! With u = R_aᵀ (t_b − t_a) / s_a, where A sees B, and M = (R, t, s) as measured:
//!   ρ = Rᵀ (u − t) / s,   θ = log(Rᵀ R_aᵀ R_b),   λ = ln(s_b / (s_a s)).
//! Keyframes are perturbed on the right: X ← X · [δρ; δθ; δλ].
//!
//! Strasdat, Montiel & Davison 2010 take the logarithm of the group instead. Ours leaves λ out of ρ, see [`Similarity`]: where an edge
//! knows no scale, theirs grows smaller as the scale grows, without end. Derivatives are exact, of large errors too.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use planwalk_types::{Similarity, Tangent7};

use super::{Information, part};
use crate::visual::two_view::epipolar::skew;

/// Derivatives of seven numbers by seven others.
pub type Jacobian = Information;

/// r of a measured pair.
pub fn residual(a_from_b: &Similarity, odom_from_a: &Similarity, odom_from_b: &Similarity) -> Tangent7 {
    (a_from_b.inverse() * odom_from_a.inverse() * *odom_from_b).tangent()
}

/// r, its derivatives by A and by B.
pub fn linearised(a_from_b: &Similarity, odom_from_a: &Similarity, odom_from_b: &Similarity) -> (Tangent7, Jacobian, Jacobian) {
    let now = odom_from_a.inverse() * *odom_from_b;
    let error = a_from_b.inverse() * now;
    let r = error.tangent();
    let unit = 1.0 / a_from_b.scale;
    let measured = a_from_b.rotation.inverse().to_rotation_matrix().into_inner() * unit;
    let by_turn = by_right_turn(&part(&r, 3));
    let (mut by_a, mut by_b) = (Jacobian::zeros(), Jacobian::zeros());
    by_a.fixed_view_mut::<3, 3>(0, 0).copy_from(&-measured);
    by_a.fixed_view_mut::<3, 3>(0, 3).copy_from(&(measured * skew(&now.translation)));
    by_a.fixed_view_mut::<3, 1>(0, 6).copy_from(&(measured * -now.translation));
    by_a.fixed_view_mut::<3, 3>(3, 3).copy_from(&(by_turn * -now.rotation.inverse().to_rotation_matrix().into_inner()));
    by_a[(6, 6)] = -1.0;
    by_b.fixed_view_mut::<3, 3>(0, 0).copy_from(&(error.rotation.to_rotation_matrix().into_inner() * error.scale));
    by_b.fixed_view_mut::<3, 3>(3, 3).copy_from(&by_turn);
    by_b[(6, 6)] = 1.0;
    (r, by_a, by_b)
}

/// Derivative of log(exp(θ) exp(δ)) by δ at 0: the inverse right Jacobian of SO(3) (Chirikjian 2012).
pub fn by_right_turn(theta: &Vector3<f64>) -> Matrix3<f64> {
    let squared = theta.norm_squared();
    let angle = squared.sqrt();
    // 1/θ² − cot(θ/2)/(2θ); as a series where the difference would be round-off. The next term is 3e-5 θ⁴.
    let second = if angle < 1e-2 {
        1.0 / 12.0 + squared / 720.0
    } else {
        let (sin, cos) = libm::sincos(0.5 * angle);
        1.0 / squared - cos / (2.0 * angle * sin)
    };
    let cross = skew(theta);
    Matrix3::identity() + cross * 0.5 + cross * cross * second
}

/// A keyframe moved by a small similarity in its own axes and unit.
pub fn moved(node: &Similarity, step: &Tangent7) -> Similarity {
    let moved = *node * Similarity::from_tangent(step);
    // Products of unit quaternions creep off the sphere by an ε each.
    Similarity { rotation: UnitQuaternion::new_normalize(moved.rotation.into_inner()), ..moved }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    prop_compose! {
        fn any_similarity()(numbers in prop::array::uniform7(-1.0..1.0f64)) -> Similarity {
            // Shifts of up to 5, turns of up to 2.6 rad, scales of e^±1.
            let scaled = Tangent7::from(numbers).component_mul(&Tangent7::from([3.0, 3.0, 3.0, 1.5, 1.5, 1.5, 1.0]));
            Similarity::from_tangent(&scaled)
        }
    }

    proptest! {
        #[test]
        fn derivatives_agree_with_finite_differences(measured in any_similarity(), a in any_similarity(), b in any_similarity()) {
            let (r, by_a, by_b) = linearised(&measured, &a, &b);
            // Past half a turn the rotation vector leaps to the other side.
            prop_assume!(part(&r, 3).norm() < 3.0);
            for i in 0..7 {
                let mut unit = Tangent7::zeros();
                unit[i] = 1e-6;
                let along_a = (residual(&measured, &moved(&a, &unit), &b) - residual(&measured, &moved(&a, &-unit), &b)) / 2e-6;
                let along_b = (residual(&measured, &a, &moved(&b, &unit)) - residual(&measured, &a, &moved(&b, &-unit))) / 2e-6;
                // Shifts reach 5 · e³ = 100: their round-off over 1e-6 is 1e-8, and a quaternion's beside half a turn ten times that.
                prop_assert!((along_a - by_a.column(i)).norm() < 1e-6, "{i}: {along_a} {by_a}");
                prop_assert!((along_b - by_b.column(i)).norm() < 1e-6, "{i}: {along_b} {by_b}");
            }
        }
    }

    #[test]
    fn the_series_for_small_turns_goes_on_where_the_formula_ends() {
        let at = |angle: f64| by_right_turn(&Vector3::new(angle, 0.0, 0.0));
        // 3e-5 · 1e-8 · 1e-4 is left out; the formula loses 1e-16 / 1e-4 to round-off, times 1e-4.
        assert!((at(0.01 - 1e-12) - at(0.01 + 1e-12)).norm() < 1e-11);
    }

    #[test]
    fn an_unknown_scale_does_not_change_the_shift() {
        let shifted = |scale: f64| Similarity { scale, translation: Vector3::new(1.0, 0.2, 0.0), ..Similarity::identity() };
        let (one, other) = (
            residual(&shifted(1.0), &Similarity::identity(), &shifted(1.0)),
            residual(&shifted(1.0), &Similarity::identity(), &shifted(9.0)),
        );
        assert_eq!(part(&one, 0), part(&other, 0));
    }
}

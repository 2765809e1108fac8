//! How does a frame lie in another whose unit of length is another one? Similarities: turn, shift and scale, Sim(3).
//!
//! `a_from_b` maps coordinates in B to coordinates in A: a = scale · R b + t; `a_from_b * b_from_c` is `a_from_c`.
//! A small one is written as seven numbers [ρ; θ; λ]: shift, rotation vector (radians), logarithm of the scale.
//!
//! Pitfall: [`Similarity::from_tangent`] is not the exponential of the group (Strasdat, Montiel & Davison 2010), whose shift is
//! V(θ, λ) ρ. There a wrong scale makes a shift's error look shorter; here the three parts leave each other alone, so whoever knows
//! nothing of one of them says nothing of it. Both agree to first order.

use std::ops::Mul;

use nalgebra::{Isometry3, SVector, Translation3, UnitQuaternion, Vector3};

/// [ρ; θ; λ]: shift (3), rotation vector (3, radians), logarithm of the scale.
pub type Tangent7 = SVector<f64, 7>;

/// `a_from_b`: a = scale · rotation · b + translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// A's units per unit of B.
    pub scale: f64,
    /// B's axes in A.
    pub rotation: UnitQuaternion<f64>,
    /// B's origin in A, A's unit.
    pub translation: Vector3<f64>,
}

impl Similarity {
    /// Leaves everything where it is.
    pub fn identity() -> Self {
        Self { scale: 1.0, rotation: UnitQuaternion::identity(), translation: Vector3::zeros() }
    }

    /// A pose of B in A's frame.
    pub fn apply(&self, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let at = self.rotation * (self.scale * pose.translation.vector) + self.translation;
        Isometry3::from_parts(Translation3::from(at), self.rotation * pose.rotation)
    }

    /// `b_from_a`.
    pub fn inverse(&self) -> Self {
        let (scale, rotation) = (1.0 / self.scale, self.rotation.inverse());
        Self { scale, rotation, translation: rotation * self.translation * -scale }
    }

    /// The similarity with these seven numbers, [ρ; θ; λ].
    pub fn from_tangent(tangent: &Tangent7) -> Self {
        let [x, y, z, a, b, c, log_scale]: [f64; 7] = (*tangent).into();
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c));
        Self { scale: libm::exp(log_scale), rotation, translation: Vector3::new(x, y, z) }
    }

    /// Its seven numbers, [ρ; θ; λ]; the rotation vector is no longer than π.
    pub fn tangent(&self) -> Tangent7 {
        let (t, turn) = (self.translation, self.rotation.scaled_axis());
        Tangent7::from([t.x, t.y, t.z, turn.x, turn.y, turn.z, libm::log(self.scale)])
    }

    /// Whether it is made of numbers, and its scale is one that lengths can have.
    pub fn is_sound(&self) -> bool {
        let finite = self.translation.iter().chain(self.rotation.coords.iter()).all(|v| v.is_finite());
        finite && self.scale.is_finite() && self.scale > 0.0
    }
}

impl From<&Isometry3<f64>> for Similarity {
    /// Both frames have the same unit.
    fn from(pose: &Isometry3<f64>) -> Self {
        Self { scale: 1.0, rotation: pose.rotation, translation: pose.translation.vector }
    }
}

impl Mul for Similarity {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            scale: self.scale * other.scale,
            rotation: self.rotation * other.rotation,
            translation: self.rotation * (other.translation * self.scale) + self.translation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    prop_compose! {
        /// Turns of up to 175°, shifts of up to 50, scales of 1/20 to 20.
        fn any_similarity()(
            shift in prop::array::uniform3(-50.0..50.0f64), axis in prop::array::uniform3(-1.0..1.0f64),
            angle in 0.0..3.05f64, log_scale in -3.0..3.0f64
        ) -> Similarity {
            let turn = Vector3::from(axis).try_normalize(1e-3).unwrap_or_else(Vector3::x) * angle;
            Similarity::from_tangent(&Tangent7::from([shift[0], shift[1], shift[2], turn.x, turn.y, turn.z, log_scale]))
        }
    }

    proptest! {
        #[test]
        fn seven_numbers_and_back(s in any_similarity()) {
            let (tangent, again) = (s.tangent(), Similarity::from_tangent(&s.tangent()).tangent());
            // Round-off of a quaternion and its angle, and of a shift of 87.
            prop_assert!((tangent - again).norm() < 1e-13 * 100.0, "{tangent} {again}");
        }

        #[test]
        fn a_similarity_undoes_its_inverse(s in any_similarity()) {
            // Shifts grow to 87 · 20 on the way: round-off of a few such.
            prop_assert!((s * s.inverse()).tangent().norm() < 1e-11 && (s.inverse() * s).tangent().norm() < 1e-11);
        }

        #[test]
        fn composing_and_applying_agree(a in any_similarity(), b in any_similarity()) {
            let pose = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.1, 0.2, 0.3));
            let (one, other) = ((a * b).apply(&pose), a.apply(&b.apply(&pose)));
            // Lengths of up to 20 · (87 + 20 · 4): round-off of a few such.
            prop_assert!((one.translation.vector - other.translation.vector).norm() < 1e-11);
            prop_assert!(one.rotation.angle_to(&other.rotation) < 1e-7);
        }
    }

    #[test]
    fn what_is_no_number_is_not_sound() {
        assert!(Similarity::identity().is_sound());
        assert!(!Similarity { scale: f64::NAN, ..Similarity::identity() }.is_sound());
        assert!(!Similarity { scale: 0.0, ..Similarity::identity() }.is_sound());
        assert!(!Similarity { translation: Vector3::new(0.0, f64::INFINITY, 0.0), ..Similarity::identity() }.is_sound());
    }
}

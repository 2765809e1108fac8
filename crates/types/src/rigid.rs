//! How does one frame lie in another? Rigid transforms that only compose where their frames meet.
//!
//! `a_from_b` maps coordinates in B to coordinates in A: `a_from_b * b_from_c` is `a_from_c`.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Mul;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::space::{Body, Cam, Pt2, Pt3};

/// The angle in (−π, π] that differs from `angle_rad` by whole turns.
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let wrapped = angle_rad - turn * (angle_rad / turn).round();
    if wrapped <= -std::f64::consts::PI { wrapped + turn } else { wrapped }
}

/// `A ← B` on the floor: heading of B's x axis in A, anticlockwise, and B's origin in A.
pub struct Rigid2<A, B> {
    /// B's origin in A.
    pub x: f64,
    /// B's origin in A.
    pub y: f64,
    /// Direction of B's x axis in A, radians, anticlockwise, in (−π, π].
    pub heading_rad: f64,
    frames: PhantomData<fn() -> (A, B)>,
}

impl<A, B> Rigid2<A, B> {
    /// The transform with this origin and heading; the heading is wrapped to (−π, π].
    pub fn new(x: f64, y: f64, heading_rad: f64) -> Self {
        Self { x, y, heading_rad: wrap_angle(heading_rad), frames: PhantomData }
    }

    /// The frames coincide.
    pub fn identity() -> Self {
        Self::new(0.0, 0.0, 0.0)
    }

    /// `B ← A`.
    pub fn inverse(self) -> Rigid2<B, A> {
        let (s, c) = libm::sincos(self.heading_rad);
        Rigid2::new(-(c * self.x + s * self.y), s * self.x - c * self.y, -self.heading_rad)
    }

    /// B's origin as a point of A.
    pub fn origin(self) -> Pt2<A> {
        Pt2::new(self.x, self.y)
    }
}

impl<A, B, C> Mul<Rigid2<B, C>> for Rigid2<A, B> {
    type Output = Rigid2<A, C>;
    fn mul(self, other: Rigid2<B, C>) -> Rigid2<A, C> {
        let (s, c) = libm::sincos(self.heading_rad);
        Rigid2::new(self.x + c * other.x - s * other.y, self.y + s * other.x + c * other.y, self.heading_rad + other.heading_rad)
    }
}

impl<A, B> Mul<Pt2<B>> for Rigid2<A, B> {
    type Output = Pt2<A>;
    fn mul(self, point: Pt2<B>) -> Pt2<A> {
        let (s, c) = libm::sincos(self.heading_rad);
        Pt2::new(self.x + c * point.x - s * point.y, self.y + s * point.x + c * point.y)
    }
}

impl<A, B> Clone for Rigid2<A, B> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<A, B> Copy for Rigid2<A, B> {}
impl<A, B> PartialEq for Rigid2<A, B> {
    fn eq(&self, other: &Self) -> bool {
        (self.x, self.y, self.heading_rad) == (other.x, other.y, other.heading_rad)
    }
}
impl<A, B> fmt::Debug for Rigid2<A, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {}; {} rad)", self.x, self.y, self.heading_rad)
    }
}

/// `A ← B` in space. Quaternions are written w last in files; nalgebra stores them so.
pub struct Rigid3<A, B> {
    /// The isometry that maps B coordinates to A coordinates.
    pub iso: Isometry3<f64>,
    frames: PhantomData<fn() -> (A, B)>,
}

impl<A, B> Rigid3<A, B> {
    /// The transform with this isometry.
    pub fn new(iso: Isometry3<f64>) -> Self {
        Self { iso, frames: PhantomData }
    }

    /// The transform with B's origin at `translation` and B's axes turned by `rotation` in A.
    pub fn from_parts(translation: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Self {
        Self::new(Isometry3::from_parts(Translation3::from(translation), rotation))
    }

    /// The frames coincide.
    pub fn identity() -> Self {
        Self::new(Isometry3::identity())
    }

    /// `B ← A`.
    pub fn inverse(self) -> Rigid3<B, A> {
        Rigid3::new(self.iso.inverse())
    }

    /// B's origin as a point of A.
    pub fn origin(self) -> Pt3<A> {
        Pt3::from_vector(self.iso.translation.vector)
    }
}

/// Camera axes (right, down, forward) in the axes of a body that carries it level and looks ahead.
fn body_from_camera() -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(0.5, -0.5, 0.5, -0.5))
}

impl<A> Rigid3<A, Body> {
    /// Its shadow on the floor of a world with z up, facing where its x axis points.
    pub fn on_floor(self) -> Rigid2<A, Body> {
        let (at, ahead) = (self.iso.translation.vector, self.iso.rotation * Vector3::x());
        Rigid2::new(at.x, at.y, libm::atan2(ahead.y, ahead.x))
    }

    /// A camera in its place that looks where it faces.
    pub fn camera(self) -> Rigid3<A, Cam> {
        Rigid3::from_parts(self.iso.translation.vector, self.iso.rotation * body_from_camera())
    }
}

impl<A> Rigid3<A, Cam> {
    /// A body in its place that faces where it looks.
    pub fn body(self) -> Rigid3<A, Body> {
        Rigid3::from_parts(self.iso.translation.vector, self.iso.rotation * body_from_camera().inverse())
    }
}

impl<A, B, C> Mul<Rigid3<B, C>> for Rigid3<A, B> {
    type Output = Rigid3<A, C>;
    fn mul(self, other: Rigid3<B, C>) -> Rigid3<A, C> {
        Rigid3::new(self.iso * other.iso)
    }
}

impl<A, B> Mul<Pt3<B>> for Rigid3<A, B> {
    type Output = Pt3<A>;
    fn mul(self, point: Pt3<B>) -> Pt3<A> {
        Pt3::from_vector(self.iso * nalgebra::Point3::from(point.coords) - nalgebra::Point3::origin())
    }
}

impl<A, B> Clone for Rigid3<A, B> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<A, B> Copy for Rigid3<A, B> {}
impl<A, B> PartialEq for Rigid3<A, B> {
    fn eq(&self, other: &Self) -> bool {
        self.iso == other.iso
    }
}
impl<A, B> fmt::Debug for Rigid3<A, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (t, q) = (self.iso.translation.vector, self.iso.rotation);
        write!(f, "({}, {}, {}; {} {} {} {})", t.x, t.y, t.z, q.i, q.j, q.k, q.w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Odom, Plan};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_transform_undoes_its_inverse(x in -50.0..50.0f64, y in -50.0..50.0f64, h in -7.0..7.0f64) {
            let plan_from_body = Rigid2::<Plan, Body>::new(x, y, h);
            let same = plan_from_body * plan_from_body.inverse();
            // Round-off of two rotations of a 70 m lever: 70 · 4 ε.
            prop_assert!(same.x.hypot(same.y) < 1e-13 * 70.0 && same.heading_rad.abs() < 1e-14);
        }

        #[test]
        fn composing_and_mapping_agree(x in -9.0..9.0f64, y in -9.0..9.0f64, h in -4.0..4.0f64, px in -9.0..9.0f64) {
            let plan_from_odom = Rigid2::<Plan, Odom>::new(x, y, h);
            let odom_from_body = Rigid2::<Odom, Body>::new(y, px, 2.0 * h);
            let toe_in_body = Pt2::<Body>::new(px, x);
            let one = (plan_from_odom * odom_from_body) * toe_in_body;
            let other = plan_from_odom * (odom_from_body * toe_in_body);
            prop_assert!(one.distance(other) < 1e-13 * 40.0);
        }

        #[test]
        fn wrapped_angles_point_the_same_way(a in -100.0..100.0f64) {
            let w = wrap_angle(a);
            prop_assert!(w > -std::f64::consts::PI - 1e-12 && w <= std::f64::consts::PI + 1e-12);
            prop_assert!((w.sin() - a.sin()).abs() < 1e-12 && (w.cos() - a.cos()).abs() < 1e-12);
        }
    }

    #[test]
    fn a_camera_and_its_body_look_the_same_way() {
        let turn = UnitQuaternion::from_euler_angles(0.1, -0.2, 2.0);
        let plan_from_body = Rigid3::<Plan, Body>::from_parts(Vector3::new(3.0, 4.0, 1.5), turn);
        let plan_from_camera = plan_from_body.camera();
        let (ahead, looks) = (plan_from_body.iso.rotation * Vector3::x(), plan_from_camera.iso.rotation * Vector3::z());
        assert!((ahead - looks).norm() < 1e-14, "{ahead} {looks}");
        assert!((plan_from_camera.iso.rotation * -Vector3::y() - plan_from_body.iso.rotation * Vector3::z()).norm() < 1e-14);
        assert!(plan_from_camera.body().iso.rotation.angle_to(&turn) < 1e-7);
        let shadow = plan_from_body.on_floor();
        assert_eq!((shadow.x, shadow.y), (3.0, 4.0));
        // Roll and pitch tilt the x axis, but do not turn it about z in this order.
        assert!((shadow.heading_rad - 2.0).abs() < 1e-14);
    }

    #[test]
    fn half_a_turn_wraps_to_plus_pi() {
        assert_eq!(wrap_angle(-std::f64::consts::PI), std::f64::consts::PI);
        assert_eq!(wrap_angle(std::f64::consts::PI), std::f64::consts::PI);
    }
}

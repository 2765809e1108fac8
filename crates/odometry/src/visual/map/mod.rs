//! Which points stand still in the world, and where were they seen from? Keyframes and landmarks.
//!
//! frame ─▶ [`pose`] (against the landmarks) ─▶ [`depth`] (of each landmark) ─▶ keyframe? ─▶ [`bundle`] (of the last few)
//!
//! A landmark is a ray of its anchor keyframe and an inverse distance along it (Civera, Davison & Montiel 2008): it is born
//! as a bearing with a vague distance and gets the distance later, so a view full of new points still gives the rotation.

pub mod bundle;
pub mod depth;
pub mod planes;
pub mod pose;
pub mod prior;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Matrix2x3, Matrix3, UnitQuaternion, Vector2, Vector3};
use planwalk_types::Stamp;

use crate::visual::axes::Fix;
use crate::visual::track::TrackId;
use crate::visual::two_view::epipolar::tangent_basis;

/// `odom ← camera`, as the solvers use it.
pub type Pose = Isometry3<f64>;

/// A keyframe, counted from the beginning of the walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyframeId(pub usize);

/// A frame that the map remembers.
#[derive(Debug, Clone)]
pub struct Keyframe {
    /// When it was taken.
    pub stamp: Stamp,
    /// Where the camera was.
    pub pose: Pose,
    /// How it had turned since the keyframe before (`before ← this`), as the frames between said.
    pub turn: UnitQuaternion<f64>,
    /// What the building's edges say of its rotation.
    pub fix: Option<Fix>,
}

/// A point of the world.
#[derive(Debug, Clone)]
pub struct Landmark {
    /// The keyframe that first saw it.
    pub anchor: KeyframeId,
    /// Its unit ray there, camera frame.
    pub ray: Vector3<f64>,
    /// Inverse distance along the ray, 1 / unit.
    pub rho: f64,
    /// Standard deviation of the inverse distance.
    pub sigma_rho: f64,
    /// What was assumed of the inverse distance before anything was seen: mean and standard deviation.
    pub born: (f64, f64),
    /// What is assumed of it now: as it was born, or what the floor says.
    pub prior: (f64, f64),
    /// Keyframes that saw it later, with its unit ray there.
    pub seen: Vec<(KeyframeId, Vector3<f64>)>,
    /// Consecutive disagreements with the map's motion.
    pub strikes: u32,
}

impl Landmark {
    /// Whether its distance is known well enough to measure translation by.
    pub fn has_depth(&self) -> bool {
        knows_depth(self.rho, self.sigma_rho)
    }

    /// Its unit ray in this keyframe, if it was seen there.
    pub fn ray_in(&self, keyframe: KeyframeId) -> Option<Vector3<f64>> {
        let seen = || self.seen.iter().rev().find(|s| s.0 == keyframe).map(|s| s.1);
        if self.anchor == keyframe { Some(self.ray) } else { seen() }
    }
}

/// Whether a distance is known well enough to measure translation by.
pub fn knows_depth(rho: f64, sigma_rho: f64) -> bool {
    sigma_rho < 0.35 * rho
}

/// Keyframes and landmarks.
#[derive(Debug, Clone, Default)]
pub struct Map {
    /// All keyframes, oldest first; only the last few are still moved.
    pub keyframes: Vec<Keyframe>,
    /// Landmarks that are still followed, and lost ones whose rays hold keyframes that are still moved.
    pub landmarks: BTreeMap<TrackId, Landmark>,
    /// Keyframes whose place was known again by points from before a gap: the way from the keyframe before says nothing.
    pub leaps: BTreeSet<KeyframeId>,
    /// What is known of the poses that are moved by what is not looked at any more.
    pub prior: Option<prior::WindowPrior>,
    /// Floor and ceiling.
    pub planes: planes::Planes,
}

/// Least inverse distance: 1 km when units are about metres. Zero would put points at infinity, where strikes cannot be told.
pub const MIN_RHO: f64 = 1e-3;

impl Map {
    /// Pose of the keyframe.
    pub fn pose(&self, id: KeyframeId) -> &Pose {
        &self.keyframes[id.0].pose
    }

    /// The newest keyframe, if there is one.
    pub fn newest(&self) -> Option<KeyframeId> {
        self.keyframes.len().checked_sub(1).map(KeyframeId)
    }

    /// The oldest keyframe that new frames are measured by: one that is still moved, or the anchor of a landmark.
    pub fn oldest_live(&self, window: usize) -> KeyframeId {
        let moved = self.keyframes.len().saturating_sub(window + 2);
        KeyframeId(self.landmarks.values().map(|l| l.anchor.0).fold(moved, usize::min))
    }

    /// Puts the newest keyframe where its place was known again.
    pub fn leap(&mut self, pose: Pose) {
        let Some(newest) = self.newest() else { return };
        let before = newest.0.checked_sub(1).map(|k| self.keyframes[k].pose.rotation);
        self.leaps.insert(newest);
        let keyframe = &mut self.keyframes[newest.0];
        keyframe.turn = before.map_or(keyframe.turn, |before| before.inverse() * pose.rotation);
        keyframe.pose = pose;
    }

    /// Multiplies all lengths since this keyframe by `factor`, and the distances of the points that were first seen since.
    pub fn rescale(&mut self, factor: f64, since: KeyframeId) {
        let Some(start) = self.keyframes.get(since.0).map(|k| k.pose.translation.vector) else { return };
        for keyframe in &mut self.keyframes[since.0..] {
            keyframe.pose.translation.vector = start + (keyframe.pose.translation.vector - start) * factor;
        }
        if let Some(prior) = &mut self.prior {
            prior.rescale(&start, factor, since);
        }
        for landmark in self.landmarks.values_mut().filter(|l| l.anchor >= since) {
            landmark.rho /= factor;
            landmark.sigma_rho /= factor;
            for (rho, sigma) in [&mut landmark.born, &mut landmark.prior] {
                (*rho, *sigma) = (*rho / factor, *sigma / factor);
            }
        }
    }

    /// Multiplies all lengths before this keyframe by `factor`; it and what comes after it stay.
    pub fn rescale_before(&mut self, factor: f64, end: KeyframeId) {
        let Some(fixed) = self.keyframes.get(end.0).map(|k| k.pose.translation.vector) else { return };
        for keyframe in &mut self.keyframes[..end.0] {
            keyframe.pose.translation.vector = fixed + (keyframe.pose.translation.vector - fixed) * factor;
        }
    }

    /// The first keyframe after the last one whose rotation is as the building's edges say within `near_rad`.
    pub fn after_last_sound(&self, near_rad: f64) -> KeyframeId {
        let sound = |k: &Keyframe| k.fix.is_some_and(|f| f.heading && f.error(&k.pose.rotation).norm() < near_rad);
        KeyframeId(self.keyframes.iter().rposition(sound).map_or(0, |k| k + 1))
    }

    /// Turns the keyframes from `oldest` on about this point; that the one before it stays is no error of what was seen between them.
    pub fn turn_about(&mut self, centre: &Vector3<f64>, turn: &UnitQuaternion<f64>, oldest: KeyframeId) {
        let before = oldest.0.checked_sub(1).and_then(|k| self.keyframes.get(k)).map(|k| k.pose.rotation);
        if let (Some(before), Some(first)) = (before, self.keyframes.get_mut(oldest.0)) {
            first.turn = before.inverse() * turn * before * first.turn;
        }
        if let Some(prior) = &mut self.prior {
            prior.turn_about(centre, turn, oldest);
        }
        for keyframe in &mut self.keyframes[oldest.0..] {
            keyframe.pose.translation.vector = centre + turn * (keyframe.pose.translation.vector - centre);
            keyframe.pose.rotation = turn * keyframe.pose.rotation;
        }
    }

    /// Learns floor and ceiling from the points in view of a keyframe: see [`planes::Planes::learn`].
    pub fn learn_planes(&mut self, up: &Vector3<f64>, in_view: &[TrackId]) -> Option<f64> {
        let heights = in_view.iter().filter_map(|id| self.landmarks.get(id)).filter(|l| l.seen.len() >= 3 && l.strikes == 0);
        let heights = heights.filter(|l| l.sigma_rho < 0.1 * l.rho);
        let heights = heights.map(|l| (up.dot(&(self.keyframes[l.anchor.0].pose.rotation * l.ray)), l.rho, l.sigma_rho / l.rho));
        let heights: Vec<_> = heights.collect();
        self.planes.learn(heights.into_iter())
    }

    /// Lays points that are on the floor or the ceiling there.
    pub fn lay_on_planes(&mut self, up: &Vector3<f64>) {
        let Self { keyframes, landmarks, planes, .. } = self;
        for landmark in landmarks.values_mut() {
            let direction = keyframes[landmark.anchor.0].pose.rotation * landmark.ray;
            let knows = landmark.has_depth() && landmark.seen.len() >= 2;
            let laid = planes.laid(up, &direction, landmark.rho, landmark.sigma_rho).filter(|_| knows);
            landmark.prior = laid.unwrap_or(landmark.born);
        }
    }

    /// The landmark's position relative to `camera`, times its inverse distance (finite for far points), camera frame.
    pub fn direction(&self, landmark: &Landmark, camera: &Pose) -> Vector3<f64> {
        direction(self.pose(landmark.anchor), &landmark.ray, landmark.rho, camera)
    }
}

/// R_jᵀ (R_a m + ρ (C_a − C_j)): parallel to the landmark's ray in camera j.
#[inline]
pub fn direction(anchor: &Pose, ray: &Vector3<f64>, rho: f64, camera: &Pose) -> Vector3<f64> {
    let world = anchor.rotation * ray + (anchor.translation.vector - camera.translation.vector) * rho;
    camera.rotation.inverse() * world
}

/// How the seen ray differs from where the landmark should be, on the plane tangent to the seen ray, radians;
/// with the derivatives that Gauss–Newton needs. Rotations are perturbed on the right: R exp(θ).
pub struct Residual {
    /// Predicted less seen, radians.
    pub error: Vector2<f64>,
    /// By the direction in the camera frame.
    by_direction: Matrix2x3<f64>,
    /// The predicted direction.
    predicted: Vector3<f64>,
}

impl Residual {
    /// `None` where the landmark would be behind the seen ray.
    #[inline]
    pub fn new(predicted: Vector3<f64>, seen: &Vector3<f64>) -> Option<Self> {
        let norm = predicted.norm();
        let unit = predicted / norm;
        if !(unit.dot(seen) > 0.2) {
            return None;
        }
        let (u, v) = tangent_basis(seen);
        let tangent = Matrix2x3::from_rows(&[u.transpose(), v.transpose()]);
        let error = tangent * unit;
        let by_direction = tangent * (Matrix3::identity() - unit * unit.transpose()) / norm;
        Some(Self { error, by_direction, predicted })
    }

    /// By the rotation of the seeing camera.
    #[inline]
    pub fn by_turn(&self) -> Matrix2x3<f64> {
        self.by_direction * crate::visual::two_view::epipolar::skew(&self.predicted)
    }

    /// By the position of the seeing camera.
    #[inline]
    pub fn by_move(&self, camera: &UnitQuaternion<f64>, rho: f64) -> Matrix2x3<f64> {
        self.by_direction * camera.inverse().to_rotation_matrix().matrix() * -rho
    }

    /// By the rotation of the anchor.
    #[inline]
    pub fn by_anchor_turn(&self, camera: &UnitQuaternion<f64>, anchor: &UnitQuaternion<f64>, ray: &Vector3<f64>) -> Matrix2x3<f64> {
        let camera_from_anchor = (camera.inverse() * anchor).to_rotation_matrix();
        -(self.by_direction * camera_from_anchor.matrix() * crate::visual::two_view::epipolar::skew(ray))
    }

    /// By the inverse distance.
    #[inline]
    pub fn by_rho(&self, anchor: &Pose, camera: &Pose) -> Vector2<f64> {
        self.by_direction * (camera.rotation.inverse() * (anchor.translation.vector - camera.translation.vector))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_edges_agree_with_is_not_turned() {
        let turn = |yaw: f64| UnitQuaternion::from_scaled_axis(Vector3::y() * yaw);
        let fix = |yaw: f64| Some(Fix { rotation: turn(yaw), information: Matrix3::identity(), edges: 20, upright: 5, heading: true });
        let keyframe = |x: f64, yaw: f64, fix: Option<Fix>| Keyframe {
            stamp: Stamp((x * 1e9) as i64),
            pose: Pose::from_parts(Vector3::new(x, 0.0, 0.0).into(), turn(yaw)),
            turn: UnitQuaternion::identity(),
            fix,
        };
        let mut map = Map::default();
        assert_eq!(map.after_last_sound(0.05), KeyframeId(0), "no keyframe is sound");
        // Before a blank wall, along it, and behind it, where the edges say that odometry has turned by 0.3.
        map.keyframes = vec![keyframe(0.0, 0.0, fix(0.01)), keyframe(1.0, 0.2, None), keyframe(2.0, 0.3, fix(0.0))];
        let lost = map.after_last_sound(0.05);
        assert_eq!(lost, KeyframeId(1));
        map.turn_about(&Vector3::new(2.0, 0.0, 0.0), &turn(-0.3), lost);
        assert_eq!(map.keyframes[0].pose, Pose::identity(), "what was right stays");
        assert!(map.keyframes[2].pose.rotation.angle() < 1e-12);
        assert_eq!(map.after_last_sound(0.05), KeyframeId(3), "all is sound now");
        map.rescale_before(0.5, KeyframeId(2));
        let x: Vec<f64> = map.keyframes.iter().map(|k| k.pose.translation.x).collect();
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[2] - 2.0).abs() < 1e-12, "what comes later stays, lengths before it halve: {x:?}");
    }

    #[test]
    fn derivatives_agree_with_finite_differences() {
        let turn = |x: f64, y: f64, z: f64| UnitQuaternion::from_scaled_axis(Vector3::new(x, y, z));
        let anchor = Pose::from_parts(Vector3::new(0.1, 0.2, -0.3).into(), turn(0.1, -0.2, 0.05));
        let camera = Pose::from_parts(Vector3::new(0.6, 0.1, 0.4).into(), turn(0.0, 0.1, -0.1));
        let (ray, rho) = (Vector3::new(0.2, -0.1, 1.0).normalize(), 0.3);
        let seen = (direction(&anchor, &ray, rho, &camera).normalize() + Vector3::new(0.01, -0.02, 0.0)).normalize();
        let at = |a: &Pose, c: &Pose, rho: f64| Residual::new(direction(a, &ray, rho, c), &seen).unwrap();
        let base = at(&anchor, &camera, rho);
        // Central differences of step 1e-6 lose 1e-12 / 1e-6 to round-off and as much to curvature.
        let check = |name: &str, expected: Vector2<f64>, plus: Residual, minus: Residual| {
            let found = (plus.error - minus.error) / 2e-6;
            assert!((found - expected).norm() < 1e-6, "{name}: {found} for {expected}");
        };
        for i in 0..3 {
            let mut unit = Vector3::zeros();
            unit[i] = 1e-6;
            let turned = |p: &Pose, w: Vector3<f64>| Pose::from_parts(p.translation, p.rotation * UnitQuaternion::from_scaled_axis(w));
            let moved = |p: &Pose, t: Vector3<f64>| Pose::from_parts((p.translation.vector + t).into(), p.rotation);
            let column = |m: Matrix2x3<f64>| m.column(i).into_owned();
            check("turn", column(base.by_turn()), at(&anchor, &turned(&camera, unit), rho), at(&anchor, &turned(&camera, -unit), rho));
            let by_move = base.by_move(&camera.rotation, rho);
            check("move", column(by_move), at(&anchor, &moved(&camera, unit), rho), at(&anchor, &moved(&camera, -unit), rho));
            check("anchor move", -column(by_move), at(&moved(&anchor, unit), &camera, rho), at(&moved(&anchor, -unit), &camera, rho));
            let by_anchor = base.by_anchor_turn(&camera.rotation, &anchor.rotation, &ray);
            check("anchor turn", column(by_anchor), at(&turned(&anchor, unit), &camera, rho), at(&turned(&anchor, -unit), &camera, rho));
        }
        check("rho", base.by_rho(&anchor, &camera), at(&anchor, &camera, rho + 1e-6), at(&anchor, &camera, rho - 1e-6));
    }
}

//! What is still known of the window by what has left it? A marginal prior over its poses.
//!
//! keyframe leaves ─▶ all that measures it, linearised ─▶ its pose eliminated ([`WindowPrior::without_oldest`]) ─▶ a Gaussian over the rest
//!
//! Square-root form, linearised once, where the keyframe left (Dong-Si & Mourikis 2011; Leutenegger et al. 2015, §3.5): cost =
//! ‖root · δ + offset‖² with δ the steps of the poses since. What turns or stretches the map turns and stretches the prior.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, UnitQuaternion, Vector3};

use super::{KeyframeId, Pose, pose};

/// Information that a pose has of itself, 1/rad² and 1/unit²: next to nothing. A place that was known again is tied to no pose before it.
const LEAST_INFORMATION: f64 = 1e-2;

/// A Gaussian over the poses of successive keyframes.
#[derive(Debug, Clone)]
pub struct WindowPrior {
    first: usize,
    /// Where it was linearised.
    poses: Vec<Pose>,
    /// Upper triangular, a column a degree of freedom.
    root: DMatrix<f64>,
    offset: DVector<f64>,
}

impl WindowPrior {
    /// The keyframe that it begins with.
    pub fn first(&self) -> KeyframeId {
        KeyframeId(self.first)
    }

    /// What is left of the normal equations `normal · δ + gradient = 0` over `poses`, the first of them keyframe `oldest`, when that
    /// one is eliminated (Schur complement); `None` where they are not numbers, or nothing would be left.
    pub fn without_oldest(oldest: KeyframeId, poses: &[Pose], mut normal: DMatrix<f64>, gradient: &DVector<f64>) -> Option<Self> {
        let rest = 6 * poses.len().checked_sub(1).filter(|n| *n > 0)?;
        (0..6 + rest).for_each(|i| normal[(i, i)] += LEAST_INFORMATION);
        let own: Matrix6<f64> = normal.fixed_view::<6, 6>(0, 0).into_owned();
        let across = normal.view((0, 6), (6, rest));
        let solved = own.cholesky()?.solve(&across.into_owned());
        let left = normal.view((6, 6), (rest, rest)) - across.transpose() * &solved;
        let pull = gradient.rows(6, rest) - solved.transpose() * gradient.rows(0, 6);
        let lower = left.cholesky()?.l();
        let offset = lower.solve_lower_triangular(&pull)?;
        Some(Self { first: oldest.0 + 1, poses: poses[1..].to_vec(), root: lower.transpose(), offset })
    }

    /// Its residuals, in standard deviations, with the keyframes at these poses.
    fn residuals(&self, keyframes: &[Pose]) -> DVector<f64> {
        let mut steps = DVector::zeros(self.offset.len());
        for (k, (from, to)) in self.poses.iter().zip(&keyframes[self.first..]).enumerate() {
            steps.fixed_rows_mut::<6>(6 * k).copy_from(&pose::difference(from, to));
        }
        &self.root * steps + &self.offset
    }

    /// Squared standard deviations with the keyframes at these poses.
    pub fn cost(&self, keyframes: &[Pose]) -> f64 {
        self.residuals(keyframes).norm_squared()
    }

    /// Adds itself to normal equations whose first six rows are keyframe [`first`](Self::first)'s.
    pub fn add_to(&self, keyframes: &[Pose], normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        let size = self.offset.len();
        let transposed = self.root.transpose();
        let mut block = normal.view_mut((0, 0), (size, size));
        block += &transposed * &self.root;
        let mut rows = gradient.rows_mut(0, size);
        rows += transposed * self.residuals(keyframes);
    }

    /// The same after the keyframes from `oldest` on were turned about `centre`.
    pub fn turn_about(&mut self, centre: &Vector3<f64>, turn: &UnitQuaternion<f64>, oldest: KeyframeId) {
        let back = turn.inverse().to_rotation_matrix().into_inner();
        self.change(oldest, &back, |pose| {
            Pose::from_parts((centre + turn * (pose.translation.vector - centre)).into(), turn * pose.rotation)
        });
    }

    /// The same after all lengths from `since` on, which was at `start`, were multiplied by `factor`.
    pub fn rescale(&mut self, start: &Vector3<f64>, factor: f64, since: KeyframeId) {
        let back = Matrix3::identity() / factor;
        self.change(since, &back, |pose| Pose::from_parts((start + (pose.translation.vector - start) * factor).into(), pose.rotation));
    }

    /// Poses from `since` on are elsewhere, and what was a step `back · s` of their positions is now a step s.
    fn change(&mut self, since: KeyframeId, back: &Matrix3<f64>, moved: impl Fn(&Pose) -> Pose) {
        for k in since.0.saturating_sub(self.first)..self.poses.len() {
            self.poses[k] = moved(&self.poses[k]);
            let mut columns = self.root.columns_mut(6 * k + 3, 3);
            let changed = &columns * back;
            columns.copy_from(&changed);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;
    use planwalk_types::{Seed, StreamRng};

    use super::*;
    use crate::visual::two_view::scene::uniform;

    fn random_pose(rng: &mut StreamRng) -> Pose {
        pose::moved(&Pose::identity(), &Vector6::from_fn(|_, _| uniform(rng, -1.0, 1.0)))
    }

    /// Normal equations of four poses, well tied to each other.
    fn normal_equations(rng: &mut StreamRng) -> (Vec<Pose>, DMatrix<f64>, DVector<f64>) {
        let mix = DMatrix::from_fn(24, 24, |_, _| uniform(rng, -1.0, 1.0));
        let gradient = DVector::from_fn(24, |_, _| uniform(rng, -1.0, 1.0));
        ((0..4).map(|_| random_pose(rng)).collect(), &mix * mix.transpose() * 1e3 + DMatrix::identity(24, 24) * 1e3, gradient)
    }

    #[test]
    fn it_costs_what_the_best_place_of_the_one_that_left_would() {
        for seed in 0..20 {
            let mut rng = Seed(seed).derive("prior", 0);
            let (poses, normal, gradient) = normal_equations(&mut rng);
            let prior = WindowPrior::without_oldest(KeyframeId(3), &poses, normal.clone(), &gradient).unwrap();
            assert_eq!(prior.first(), KeyframeId(4));
            let cost = |step: &DVector<f64>| (step.transpose() * &normal * step).x + 2.0 * gradient.dot(step);
            // The other three a little off; the first wherever it costs least, found by solving for it alone.
            let best = |rest: &DVector<f64>| {
                let own: Matrix6<f64> = normal.fixed_view::<6, 6>(0, 0).into_owned();
                let pull = gradient.rows(0, 6) + normal.view((0, 6), (6, 18)) * rest;
                let mut step = DVector::zeros(24);
                step.rows_mut(0, 6).copy_from(&-own.cholesky().unwrap().solve(&pull));
                step.rows_mut(6, 18).copy_from(rest);
                cost(&step)
            };
            let rest = DVector::from_fn(18, |_, _| uniform(&mut rng, -0.1, 0.1));
            let mut keyframes = vec![Pose::identity(); 4];
            keyframes.extend(poses[1..].iter().enumerate().map(|(k, p)| pose::moved(p, &rest.fixed_rows::<6>(6 * k).into_owned())));
            let mut still = vec![Pose::identity(); 4];
            still.extend_from_slice(&poses[1..]);
            let (found, expected) = (prior.cost(&keyframes) - prior.cost(&still), best(&rest) - best(&DVector::zeros(18)));
            // The least information, 0.01 against a thousand, over 24 degrees of freedom.
            assert!((found - expected).abs() < 1e-3 * expected.abs(), "seed {seed}: {found} for {expected}");
        }
    }

    #[test]
    fn what_turns_and_stretches_the_map_leaves_the_cost() {
        let mut rng = Seed(5).derive("prior", 1);
        let (poses, normal, gradient) = normal_equations(&mut rng);
        let mut prior = WindowPrior::without_oldest(KeyframeId(0), &poses, normal, &gradient).unwrap();
        let mut keyframes: Vec<Pose> =
            poses.iter().map(|p| pose::moved(p, &Vector6::from_fn(|_, _| uniform(&mut rng, -0.1, 0.1)))).collect();
        let cost = prior.cost(&keyframes);
        let (centre, turn) = (Vector3::new(1.0, 2.0, 3.0), UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 1.2, -0.3)));
        prior.turn_about(&centre, &turn, KeyframeId(2));
        for pose in &mut keyframes[2..] {
            *pose = Pose::from_parts((centre + turn * (pose.translation.vector - centre)).into(), turn * pose.rotation);
        }
        assert!((prior.cost(&keyframes) - cost).abs() < 1e-9 * cost, "turned: {} for {cost}", prior.cost(&keyframes));
        let start = keyframes[1].translation.vector;
        prior.rescale(&start, 3.0, KeyframeId(1));
        for pose in &mut keyframes[1..] {
            pose.translation.vector = start + (pose.translation.vector - start) * 3.0;
        }
        assert!((prior.cost(&keyframes) - cost).abs() < 1e-9 * cost, "stretched: {} for {cost}", prior.cost(&keyframes));
    }
}

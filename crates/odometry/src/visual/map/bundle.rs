//! What poses and distances explain the last keyframes best together? Windowed bundle adjustment.
//!
//! Levenberg–Marquardt on keyframe poses (6) and inverse distances (1), the distances eliminated by the Schur complement
//! (Triggs et al. 2000, §6.1), Huber loss. Keyframes before the window stay fixed: they hold position, heading and scale; or a
//! marginal prior does ([`WindowPast`]).
//! A weak prior on how fast the speed changes holds the scale where nothing else does: in a corner, in front of a blank wall.

use std::collections::BTreeSet;
use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix2x6, Matrix3, UnitQuaternion, Vector3, Vector6};

use super::prior::WindowPrior;
use super::{KeyframeId, Landmark, MIN_RHO, Map, Pose, Residual, direction};
use crate::visual::axes::Fix;
use crate::visual::track::TrackId;

/// Options of [`adjust`].
#[derive(Debug, Clone, Copy)]
pub struct BundleOptions {
    /// Keyframes that are moved.
    pub window: usize,
    /// Noise of a ray, radians.
    pub sigma_rad: f64,
    /// Most iterations.
    pub iterations: usize,
    /// How fast the speed may change: units/s per √s, one standard deviation.
    pub speed_walk: f64,
    /// What holds the oldest of them.
    pub past: WindowPast,
}

/// What holds the window to all that was before it?
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WindowPast {
    /// The keyframes before it stay as they are.
    #[default]
    Held,
    /// A marginal prior over its poses: [`WindowPrior`]. Anchors, and rays of points that are still followed, stay as they are.
    Marginal,
}

/// Loss turns linear at this many standard deviations (Huber).
const HUBER: f64 = 1.8;

/// Standard deviation of the turn between keyframes as the frames between said it. Wide against what points say (a
/// milliradian), narrow against what a keyframe without common points would do by itself.
const TURN_SIGMA_RAD: f64 = 0.02;

/// One ray of a landmark in a keyframe of the window.
struct Ray<'a> {
    keyframe: usize,
    seen: &'a Vector3<f64>,
}

/// Everything that is moved, and what it is measured by.
struct Problem<'a> {
    /// First keyframe that is moved.
    first: usize,
    poses: Vec<Pose>,
    stamps_s: Vec<f64>,
    turns: Vec<UnitQuaternion<f64>>,
    leaps: &'a BTreeSet<KeyframeId>,
    fixes: Vec<Option<Fix>>,
    prior: Option<&'a WindowPrior>,
    ties: Ties,
    landmarks: Vec<(&'a Landmark, Vec<Ray<'a>>)>,
    options: BundleOptions,
}

/// Moves the newest keyframes and all landmarks that they see. Landmarks get the standard deviation that the fit gives them.
///
/// Returns the root mean square of the residuals in standard deviations, or `None` when there was nothing to adjust.
pub fn adjust(map: &mut Map, options: &BundleOptions) -> Option<f64> {
    let count = map.keyframes.len();
    // Two stay fixed at least: with one, the scale would be free.
    let first = first_moved(count, options);
    if count < 2 || first >= count {
        return None;
    }
    let ids: Vec<_> = map.landmarks.keys().copied().collect();
    let (poses, rhos, sigmas, rms) = {
        let problem = Problem::new(map, first, Ties::of(first, count, options.past), *options, |_, _| true);
        problem.solve()?
    };
    for (keyframe, pose) in map.keyframes.iter_mut().zip(poses) {
        keyframe.pose = pose;
    }
    for ((id, rho), sigma) in ids.iter().zip(rhos).zip(sigmas) {
        if let (Some(landmark), Some(rho)) = (map.landmarks.get_mut(id), rho) {
            landmark.rho = rho;
            landmark.sigma_rho = sigma;
        }
    }
    Some(rms)
}

fn first_moved(count: usize, options: &BundleOptions) -> usize {
    count.saturating_sub(options.window).max(2.min(count.saturating_sub(1)))
}

/// Lets the keyframe go that the window of the next one will not move any more: what was measured of it, but by points that are
/// still followed, stays as a prior over the poses of the rest, if that is what holds them.
pub fn let_go(map: &mut Map, options: &BundleOptions, followed: &BTreeSet<TrackId>) {
    if options.past == WindowPast::Held {
        return;
    }
    let count = map.keyframes.len();
    let (first, next) = (first_moved(count, options), first_moved(count + 1, options));
    if next == first || next >= count {
        return;
    }
    let ties = Ties::of(first, count, options.past).less(&Ties::of(next, count, options.past));
    let sees = |landmark: &Landmark| landmark.anchor.0 == first || landmark.seen.iter().any(|(k, _)| k.0 == first);
    let goes = |id: &TrackId, landmark: &Landmark| !followed.contains(id) && sees(landmark);
    let prior = Problem::new(map, first, ties, *options, goes).marginal();
    map.landmarks.retain(|id, landmark| !goes(id, landmark));
    map.prior = prior;
}

/// What ties keyframes to those before them: keyframes whose turn, whose speed, and whose edges count.
#[derive(Debug, Clone, PartialEq)]
struct Ties {
    turns: Range<usize>,
    speeds: Range<usize>,
    fixes: Range<usize>,
}

impl Ties {
    /// Those of the keyframes that are moved. Where a prior knows what was before, they touch nothing before the first, but the two
    /// that the walk began with.
    fn of(first: usize, count: usize, past: WindowPast) -> Self {
        let after = |n: usize| if past == WindowPast::Held || first <= 2 { first } else { first + n };
        Self { turns: after(1).max(1)..count, speeds: after(2).max(2)..count, fixes: first..count }
    }

    /// Those that the other, later one does not have.
    fn less(self, later: &Self) -> Self {
        Self {
            turns: self.turns.start..later.turns.start,
            speeds: self.speeds.start..later.speeds.start,
            fixes: self.fixes.start..later.fixes.start,
        }
    }
}

type Solution = (Vec<Pose>, Vec<Option<f64>>, Vec<f64>, f64);

impl<'a> Problem<'a> {
    fn new(map: &'a Map, first: usize, ties: Ties, options: BundleOptions, takes: impl Fn(&TrackId, &Landmark) -> bool) -> Self {
        let origin = map.keyframes[0].stamp;
        let oldest = first.saturating_sub(2);
        let rays_of = |landmark: &'a Landmark| {
            let recent = landmark.seen.iter().filter(|(KeyframeId(k), _)| *k >= oldest);
            recent.map(|(KeyframeId(k), seen)| Ray { keyframe: *k, seen }).collect()
        };
        Self {
            first,
            poses: map.keyframes.iter().map(|k| k.pose).collect(),
            stamps_s: map.keyframes.iter().map(|k| k.stamp.secs_since(origin)).collect(),
            turns: map.keyframes.iter().map(|k| k.turn).collect(),
            leaps: &map.leaps,
            fixes: map.keyframes.iter().map(|k| k.fix).collect(),
            prior: map.prior.as_ref(),
            ties,
            landmarks: map.landmarks.iter().filter(|(id, l)| takes(id, l)).map(|(_, l)| (l, rays_of(l))).collect(),
            options,
        }
    }

    fn solve(&self) -> Option<Solution> {
        let mut poses = self.poses.clone();
        let mut rhos: Vec<f64> = self.landmarks.iter().map(|(l, _)| l.rho).collect();
        let mut cost = self.cost(&poses, &rhos);
        let mut damping = 1e-4;
        for _ in 0..self.options.iterations {
            let Some((next_poses, next_rhos)) = self.step(&poses, &rhos, damping) else {
                damping *= 10.0;
                continue;
            };
            let next = self.cost(&next_poses, &next_rhos);
            if next.0 < cost.0 {
                let gain = (cost.0 - next.0) / cost.0.max(1e-12);
                (poses, rhos, cost) = (next_poses, next_rhos, next);
                damping = (damping * 0.2f64).max(1e-9);
                if gain < 1e-4 {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e4 {
                    break;
                }
            }
        }
        let seen: usize = cost.1;
        if seen == 0 {
            return None;
        }
        let sigmas = self.sigmas(&poses, &rhos);
        let moved = self.landmarks.iter().zip(&rhos).map(|((_, rays), rho)| (!rays.is_empty()).then_some(*rho)).collect();
        Some((poses, moved, sigmas, (cost.0 / (2 * seen) as f64).sqrt()))
    }

    fn residual(&self, poses: &[Pose], landmark: &Landmark, rho: f64, ray: &Ray<'_>) -> Option<Residual> {
        Residual::new(direction(&poses[landmark.anchor.0], &landmark.ray, rho, &poses[ray.keyframe]), ray.seen)
    }

    /// Robust cost in squared standard deviations, and the number of rays.
    fn cost(&self, poses: &[Pose], rhos: &[f64]) -> (f64, usize) {
        let (mut sum, mut rays_seen) = (0.0, 0);
        for ((landmark, rays), rho) in self.landmarks.iter().zip(rhos) {
            if rays.is_empty() {
                continue;
            }
            sum += ((rho - landmark.prior.0) / landmark.prior.1).powi(2);
            for ray in rays {
                rays_seen += 1;
                let sigmas = self.residual(poses, landmark, *rho, ray).map_or(1e3, |r| r.error.norm() / self.options.sigma_rad);
                sum += if sigmas < HUBER { sigmas * sigmas } else { HUBER * (2.0 * sigmas - HUBER) };
            }
        }
        sum += self.ties.speeds.clone().map(|k| self.speed_change(poses, k).0.norm_squared()).sum::<f64>();
        sum += self.ties.turns.clone().map(|k| self.turn_error(poses, k).0.norm_squared()).sum::<f64>();
        sum += self.ties.fixes.clone().filter_map(|k| Some(self.fixes[k]?.cost(&poses[k].rotation))).sum::<f64>();
        sum += self.prior.map_or(0.0, |prior| prior.cost(poses));
        (sum, rays_seen)
    }

    fn fix_terms(&self, poses: &[Pose], normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        for k in self.ties.fixes.clone() {
            let Some(fix) = self.fixes[k] else { continue };
            let row = 6 * (k - self.first);
            gradient.fixed_rows_mut::<3>(row).gemv(1.0, &fix.information, &fix.error(&poses[k].rotation), 1.0);
            let mut block = normal.fixed_view_mut::<3, 3>(row, row);
            block += fix.information;
        }
    }

    /// Change of velocity at keyframe k − 1 in standard deviations, and its derivatives by the positions of k, k − 1, k − 2.
    fn speed_change(&self, poses: &[Pose], k: usize) -> (Vector3<f64>, [f64; 3]) {
        // No walk led to where a place was known again.
        if self.leaps.contains(&KeyframeId(k)) || self.leaps.contains(&KeyframeId(k - 1)) {
            return (Vector3::zeros(), [0.0; 3]);
        }
        let at = |i: usize| poses[i].translation.vector;
        let late = (self.stamps_s[k] - self.stamps_s[k - 1]).max(1e-3);
        let early = (self.stamps_s[k - 1] - self.stamps_s[k - 2]).max(1e-3);
        let sigma = self.options.speed_walk * (0.5 * (late + early)).sqrt();
        let by = [1.0 / (late * sigma), -(1.0 / late + 1.0 / early) / sigma, 1.0 / (early * sigma)];
        (at(k) * by[0] + at(k - 1) * by[1] + at(k - 2) * by[2], by)
    }

    /// How the turn from keyframe k − 1 to k differs from what the frames between said, in standard deviations, and its
    /// derivative by the rotation of k − 1 (that by k is the identity over the standard deviation, to first order).
    fn turn_error(&self, poses: &[Pose], k: usize) -> (Vector3<f64>, Matrix3<f64>) {
        let turn = poses[k - 1].rotation.inverse() * poses[k].rotation;
        let error = (self.turns[k].inverse() * turn).scaled_axis() / TURN_SIGMA_RAD;
        (error, -turn.inverse().to_rotation_matrix().into_inner() / TURN_SIGMA_RAD)
    }

    fn turn_terms(&self, poses: &[Pose], normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        for k in self.ties.turns.clone() {
            let (error, by_before) = self.turn_error(poses, k);
            let touched = [(k, Matrix3::identity() / TURN_SIGMA_RAD), (k - 1, by_before)];
            for (i, a) in &touched {
                let Some(row) = i.checked_sub(self.first) else { continue };
                gradient.fixed_rows_mut::<3>(6 * row).gemv(1.0, &a.transpose(), &error, 1.0);
                for (j, b) in &touched {
                    let Some(column) = j.checked_sub(self.first) else { continue };
                    let mut block = normal.fixed_view_mut::<3, 3>(6 * row, 6 * column);
                    block += a.transpose() * b;
                }
            }
        }
    }

    /// One damped Gauss–Newton step; `None` when the reduced system is not positive definite.
    fn step(&self, poses: &[Pose], rhos: &[f64], damping: f64) -> Option<(Vec<Pose>, Vec<f64>)> {
        let (normal, gradient, eliminated) = self.reduced(poses, rhos, damping);
        let step = -normal.cholesky()?.solve(&gradient);
        let mut next_poses = poses.to_vec();
        for (k, pose) in next_poses.iter_mut().enumerate().skip(self.first) {
            *pose = super::pose::moved(pose, &step.fixed_rows::<6>(6 * (k - self.first)).into_owned());
        }
        let next_rhos = rhos.iter().zip(&eliminated).map(|(rho, entry)| {
            if entry.curvature <= 0.0 {
                return *rho;
            }
            let pull: f64 = entry.coupling.iter().map(|(i, a)| a.dot(&step.fixed_rows::<6>(*i))).sum();
            let change = -(entry.gradient + pull) / (entry.curvature * (1.0 + damping));
            // A point may come no closer than half its distance in one step.
            (rho + change).clamp(MIN_RHO, 2.0 * rho + 0.5)
        });
        let next_rhos = next_rhos.collect();
        Some((next_poses, next_rhos))
    }

    /// What all of it says of the poses but the oldest moved one, as it stands.
    fn marginal(&self) -> Option<WindowPrior> {
        let rhos: Vec<f64> = self.landmarks.iter().map(|(l, _)| l.rho).collect();
        let (normal, gradient, _) = self.reduced(&self.poses, &rhos, 0.0);
        WindowPrior::without_oldest(KeyframeId(self.first), &self.poses[self.first..], normal, &gradient)
    }

    /// Normal equations of the poses that are moved, the distances eliminated, and what finds these again.
    fn reduced(&self, poses: &[Pose], rhos: &[f64], damping: f64) -> (DMatrix<f64>, DVector<f64>, Vec<Eliminated>) {
        let size = 6 * (poses.len() - self.first);
        let (mut normal, mut gradient) = (DMatrix::<f64>::zeros(size, size), DVector::<f64>::zeros(size));
        // Per landmark: its own curvature and gradient, and its coupling to the poses that it touches.
        let mut eliminated = Vec::with_capacity(rhos.len());
        for ((landmark, rays), rho) in self.landmarks.iter().zip(rhos) {
            let entry = self.landmark_terms(poses, landmark, rays, *rho, &mut normal, &mut gradient);
            eliminated.push(entry);
        }
        self.speed_terms(poses, &mut normal, &mut gradient);
        self.turn_terms(poses, &mut normal, &mut gradient);
        self.fix_terms(poses, &mut normal, &mut gradient);
        if let Some(prior) = self.prior {
            prior.add_to(poses, &mut normal, &mut gradient);
        }
        let diagonal = normal.diagonal();
        for (i, d) in diagonal.iter().enumerate() {
            normal[(i, i)] += damping * d.max(1e-6);
        }
        for entry in eliminated.iter().filter(|e| !e.coupling.is_empty()) {
            let inverse = 1.0 / (entry.curvature * (1.0 + damping));
            for (i, a) in &entry.coupling {
                gradient.rows_mut(*i, 6).axpy(-inverse * entry.gradient, a, 1.0);
                for (j, b) in &entry.coupling {
                    let mut block = normal.fixed_view_mut::<6, 6>(*i, *j);
                    block -= a * b.transpose() * inverse;
                }
            }
        }
        (normal, gradient, eliminated)
    }

    /// Adds a landmark's rays to the poses' system; returns what eliminates its distance.
    fn landmark_terms(
        &self,
        poses: &[Pose],
        landmark: &Landmark,
        rays: &[Ray<'_>],
        rho: f64,
        normal: &mut DMatrix<f64>,
        gradient: &mut DVector<f64>,
    ) -> Eliminated {
        if rays.is_empty() {
            return Eliminated { curvature: 0.0, gradient: 0.0, coupling: Vec::new() };
        }
        let information = landmark.prior.1.powi(-2);
        let mut entry = Eliminated { curvature: information, gradient: information * (rho - landmark.prior.0), coupling: Vec::new() };
        let anchor = &poses[landmark.anchor.0];
        for ray in rays {
            let Some(residual) = self.residual(poses, landmark, rho, ray) else { continue };
            let camera = &poses[ray.keyframe];
            let weight = self.weight(&residual);
            let by_rho = residual.by_rho(anchor, camera);
            entry.curvature += weight * by_rho.norm_squared();
            entry.gradient += weight * by_rho.dot(&residual.error);
            let mut touched: [Option<(usize, Matrix2x6<f64>)>; 2] = [None, None];
            if ray.keyframe >= self.first {
                touched[0] = Some((6 * (ray.keyframe - self.first), beside(residual.by_turn(), residual.by_move(&camera.rotation, rho))));
            }
            if landmark.anchor.0 >= self.first {
                let turn = residual.by_anchor_turn(&camera.rotation, &anchor.rotation, &landmark.ray);
                let shift = -residual.by_move(&camera.rotation, rho);
                touched[1] = Some((6 * (landmark.anchor.0 - self.first), beside(turn, shift)));
            }
            for (i, a) in touched.iter().flatten() {
                gradient.fixed_rows_mut::<6>(*i).axpy(weight, &(a.transpose() * residual.error), 1.0);
                entry.couple(*i, a.transpose() * by_rho * weight);
                for (j, b) in touched.iter().flatten() {
                    let mut block = normal.fixed_view_mut::<6, 6>(*i, *j);
                    block += a.transpose() * b * weight;
                }
            }
        }
        entry
    }

    fn speed_terms(&self, poses: &[Pose], normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        for k in self.ties.speeds.clone() {
            let (error, by) = self.speed_change(poses, k);
            for (i, by_i) in by.iter().enumerate() {
                let Some(row) = (k - i).checked_sub(self.first) else { continue };
                gradient.fixed_rows_mut::<3>(6 * row + 3).axpy(*by_i, &error, 1.0);
                for (j, by_j) in by.iter().enumerate() {
                    let Some(column) = (k - j).checked_sub(self.first) else { continue };
                    for c in 0..3 {
                        normal[(6 * row + 3 + c, 6 * column + 3 + c)] += by_i * by_j;
                    }
                }
            }
        }
    }

    fn weight(&self, residual: &Residual) -> f64 {
        let sigmas = residual.error.norm() / self.options.sigma_rad;
        (HUBER / sigmas.max(HUBER)) / self.options.sigma_rad.powi(2)
    }

    /// Standard deviation of each inverse distance with the poses held, widened for the poses' own error.
    fn sigmas(&self, poses: &[Pose], rhos: &[f64]) -> Vec<f64> {
        let sigma = |((landmark, rays), rho): (&(&Landmark, Vec<Ray<'_>>), &f64)| {
            let information = rays.iter().filter_map(|ray| {
                let residual = self.residual(poses, landmark, *rho, ray)?;
                let by_rho = residual.by_rho(&poses[landmark.anchor.0], &poses[ray.keyframe]);
                Some(self.weight(&residual) * by_rho.norm_squared())
            });
            // 1.5: neighbouring keyframes share much of their error, which the fixed poses hide.
            1.5 * (landmark.prior.1.powi(-2) + information.sum::<f64>()).sqrt().recip()
        };
        self.landmarks.iter().zip(rhos).map(sigma).collect()
    }
}

fn beside(turn: nalgebra::Matrix2x3<f64>, shift: nalgebra::Matrix2x3<f64>) -> Matrix2x6<f64> {
    let mut both = Matrix2x6::zeros();
    both.fixed_view_mut::<2, 3>(0, 0).copy_from(&turn);
    both.fixed_view_mut::<2, 3>(0, 3).copy_from(&shift);
    both
}

/// What is needed to take a landmark's inverse distance out of the system and to find it again.
struct Eliminated {
    curvature: f64,
    gradient: f64,
    /// Row of a pose in the system, and Σ Jᵀ w J_ρ there.
    coupling: Vec<(usize, Vector6<f64>)>,
}

impl Eliminated {
    fn couple(&mut self, row: usize, value: Vector6<f64>) {
        match self.coupling.iter_mut().find(|(i, _)| *i == row) {
            Some((_, sum)) => *sum += value,
            None => self.coupling.push((row, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::track::TrackId;
    use crate::visual::two_view::scene::uniform;
    use planwalk_types::{Seed, Stamp};

    /// Six keyframes a step of 0.3 apart on an arc before 80 points, seen with noise; poses and distances then disturbed.
    fn disturbed(seed: u64, noise_rad: f64) -> (Map, Vec<Pose>) {
        let mut rng = Seed(seed).derive("bundle", 0);
        let truth: Vec<Pose> = (0..6)
            .map(|k| {
                let k = f64::from(k);
                Pose::from_parts(
                    Vector3::new(0.3 * k, 0.01 * k, 0.1 * k).into(),
                    UnitQuaternion::from_scaled_axis(Vector3::y() * (-0.05 * k)),
                )
            })
            .collect();
        let mut map = Map::default();
        for (k, pose) in truth.iter().enumerate() {
            let turn = truth[k.saturating_sub(1)].rotation.inverse() * pose.rotation;
            map.keyframes.push(super::super::Keyframe { stamp: Stamp(k as i64 * 300_000_000), pose: *pose, turn, fix: None });
        }
        for i in 0..80 {
            let distance = uniform(&mut rng, 2.0, 7.0);
            let ray = Vector3::new(uniform(&mut rng, -0.4, 0.6), uniform(&mut rng, -0.4, 0.4), 1.0).normalize();
            let anchor = KeyframeId(usize::from(i % 2 == 1));
            let seen = (anchor.0 + 1..6).map(|k| {
                let exact = direction(&truth[anchor.0], &ray, 1.0 / distance, &truth[k]).normalize();
                (KeyframeId(k), (exact + Vector3::from_fn(|_, _| uniform(&mut rng, -1.7, 1.7) * noise_rad)).normalize())
            });
            let seen = seen.collect();
            let rho = 1.0 / (distance * uniform(&mut rng, 0.8, 1.25));
            map.landmarks
                .insert(TrackId(i), Landmark { anchor, ray, rho, sigma_rho: 0.2, born: (0.25, 0.5), prior: (0.25, 0.5), seen, strikes: 0 });
        }
        for keyframe in map.keyframes.iter_mut().skip(2) {
            let step = Vector6::from_fn(|i, _| uniform(&mut rng, -1.0, 1.0) * if i < 3 { 0.01 } else { 0.05 });
            keyframe.pose = super::super::pose::moved(&keyframe.pose, &step);
        }
        (map, truth)
    }

    fn options() -> BundleOptions {
        BundleOptions { window: 4, sigma_rad: 1e-3, iterations: 20, speed_walk: 2.0, past: WindowPast::Held }
    }

    #[test]
    fn exact_rays_lead_back_to_the_exact_poses() {
        let (mut map, truth) = disturbed(1, 0.0);
        adjust(&mut map, &options()).unwrap();
        for (keyframe, pose) in map.keyframes.iter().zip(&truth) {
            // The priors on distance (0.5 on an inverse of 0.25) and speed pull a little; rays of 1 mrad pull a thousand times more.
            assert!((keyframe.pose.translation.vector - pose.translation.vector).norm() < 2e-3, "{} for {pose}", keyframe.pose);
            assert!(keyframe.pose.rotation.angle_to(&pose.rotation) < 1e-3);
        }
    }

    #[test]
    fn noisy_rays_leave_residuals_of_one_standard_deviation() {
        for seed in 2..6 {
            let (mut map, truth) = disturbed(seed, 1e-3);
            let rms = adjust(&mut map, &options()).unwrap();
            assert!((0.7..1.1).contains(&rms), "seed {seed}: rms {rms} σ");
            let off = (map.keyframes[5].pose.translation.vector - truth[5].translation.vector).norm();
            assert!(off < 0.02, "seed {seed}: the last keyframe is {off} off");
        }
    }

    #[test]
    fn a_keyframe_without_points_keeps_the_turn_that_the_frames_said() {
        let (mut map, truth) = disturbed(1, 0.0);
        for landmark in map.landmarks.values_mut() {
            landmark.seen.retain(|(k, _)| k.0 < 5);
        }
        adjust(&mut map, &options()).unwrap();
        // Held by a turn of 0.02 rad and a speed alone, with nothing against them.
        assert!(map.keyframes[5].pose.rotation.angle_to(&truth[5].rotation) < 2e-3, "{}", map.keyframes[5].pose);
        assert!((map.keyframes[5].pose.translation.vector - truth[5].translation.vector).norm() < 0.05);
    }

    #[test]
    fn keyframes_keep_to_what_the_edges_say() {
        let (mut map, truth) = disturbed(1, 0.0);
        map.landmarks.values_mut().for_each(|l| l.seen.retain(|(k, _)| k.0 < 4));
        let told = truth[5].rotation * UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.02, 0.0));
        map.keyframes[5].fix = Some(Fix { rotation: told, information: Matrix3::identity() * 1e6, edges: 9, upright: 3, heading: true });
        adjust(&mut map, &options()).unwrap();
        // A milliradian against turns of 0.02 rad from frame to frame: they pull by less than 1/400 of the 0.02 rad.
        assert!(map.keyframes[5].pose.rotation.angle_to(&told) < 1e-3, "{}", map.keyframes[5].pose);
    }

    #[test]
    fn what_has_left_the_window_still_holds_it_as_a_prior() {
        let options = BundleOptions { past: WindowPast::Marginal, ..options() };
        let (mut map, truth) = disturbed(1, 0.0);
        adjust(&mut map, &options).unwrap();
        // All but one point are lost from view, and one cannot hold a pose.
        let followed = BTreeSet::from([TrackId(0)]);
        let_go(&mut map, &options, &followed);
        assert_eq!(map.landmarks.len(), 1);
        assert_eq!(map.prior.as_ref().unwrap().first(), KeyframeId(3));
        let stamp = Stamp(6 * 300_000_000);
        map.keyframes.push(super::super::Keyframe { stamp, pose: truth[5], turn: UnitQuaternion::identity(), fix: None });
        for keyframe in map.keyframes[3..6].iter_mut() {
            let off = Vector6::new(0.01, -0.01, 0.01, 0.05, -0.05, 0.05);
            keyframe.pose = super::super::pose::moved(&keyframe.pose, &off);
        }
        let worst =
            |map: &Map| (3..6).map(|k| (map.keyframes[k].pose.translation.vector - truth[k].translation.vector).norm()).fold(0.0, f64::max);
        let mut unheld = Map { prior: None, ..map.clone() };
        adjust(&mut map, &options).unwrap();
        adjust(&mut unheld, &options).unwrap();
        // As near as all eighty points had brought them, above; the speed of the new keyframe pulls too.
        assert!(worst(&map) < 4e-3, "{} off", worst(&map));
        assert!(worst(&unheld) > 4.0 * worst(&map), "{} off without the prior, {} with it", worst(&unheld), worst(&map));
    }

    #[test]
    fn held_keyframes_need_no_prior() {
        let (mut map, _) = disturbed(1, 0.0);
        let_go(&mut map, &options(), &BTreeSet::new());
        assert!(map.prior.is_none() && map.landmarks.len() == 80);
    }

    #[test]
    fn nothing_to_adjust_is_no_problem() {
        assert_eq!(adjust(&mut Map::default(), &options()), None);
        let (mut map, _) = disturbed(1, 0.0);
        map.landmarks.clear();
        assert_eq!(adjust(&mut map, &options()), None);
    }
}

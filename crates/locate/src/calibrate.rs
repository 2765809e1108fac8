//! How far off does the plan draw its walls, and how much do sightings tell that others did not?
//!
//! residuals of a polished walk ──by 2 m of walk and side of the wall──▶ groups ──▶ spread of their means, spread within
//!
//! Drawn walls stand off by centimetres, and all that is seen of one from one place is off together. So each group shares an
//! unknown offset (a random effect; Searle, Casella & McCulloch 1992): its mean is good to τ² + σ²/n, not to σ²/n, however much
//! was seen. Both are measured on the walk itself, by moments, with a weak prior, so that a short walk does not claim to know.
//! Pitfall: a lone wall's offset moves the walk and leaves no residual; what the fit took up is given back (h below).

use nalgebra::{Matrix4, Vector4};

use crate::polish::Touch;

/// Length of walk over which walls are seen from about the same place, metres.
const WINDOW_M: f64 = 2.0;
/// Directions that walls face, told apart.
const SIDES: usize = 8;
/// What plans are off by, before anything is measured, metres, and how many groups that knowledge is worth.
const PRIOR_M: f64 = 0.05;
const PRIOR_GROUPS: f64 = 8.0;
/// Relative error that the ranges of one stretch share: points of a map are off together. It counts as an offset of the wall.
const SHARED_RANGE: f64 = 0.02;
/// Sightings that the stated noise is worth, before any is measured.
const PRIOR_SIGHTINGS: f64 = 50.0;

/// What the residuals say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Calibration {
    /// Standard deviation of a group's common offset, metres.
    pub plan_sigma_m: f64,
    /// Correlation of the offsets of neighbouring groups, 0..1.
    pub persistence: f64,
    /// Spread within groups over the stated one.
    pub noise: f64,
}

impl Calibration {
    /// What is known before any residual: half a cell of drawing, and what plans are usually off by.
    pub(crate) fn prior(cell_m: f64) -> Self {
        Self { plan_sigma_m: PRIOR_M.hypot(cell_m / 12f64.sqrt()), persistence: 0.3, noise: 1.0 }
    }

    /// Variance of an offset as the chain feels it, m²: neighbours that are off together average out later.
    fn plan_variance(&self) -> f64 {
        self.plan_sigma_m * self.plan_sigma_m * (1.0 + self.persistence) / (1.0 - self.persistence)
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Group {
    /// Sightings, by their share.
    count: f64,
    /// Sum of share over variance, 1/m².
    precision: f64,
    /// Sums weighted by it.
    residual: f64,
    square: f64,
    slope: Vector4<f64>,
    link: usize,
}

/// Touches gathered by place and side.
#[derive(Debug, Clone)]
pub(crate) struct Grouped<'a> {
    groups: Vec<Group>,
    way_m: &'a [f64],
}

impl<'a> Grouped<'a> {
    pub(crate) fn new<'t>(touches: impl Iterator<Item = &'t Touch>, way_m: &'a [f64]) -> Self {
        let windows = (way_m.last().copied().unwrap_or(0.0) / WINDOW_M) as usize + 1;
        let mut all = Self { groups: vec![Group::default(); windows * SIDES], way_m };
        for touch in touches {
            let index = all.index(touch);
            let Some(group) = all.groups.get_mut(index) else { continue };
            let precision = touch.share / (touch.sigma_m * touch.sigma_m);
            group.count += touch.share;
            group.precision += precision;
            group.residual += precision * touch.residual_m;
            group.square += precision * touch.residual_m * touch.residual_m;
            group.slope += touch.slope * precision;
            group.link = touch.link;
        }
        all
    }

    fn index(&self, touch: &Touch) -> usize {
        let window = (self.way_m.get(touch.link).copied().unwrap_or(0.0) / WINDOW_M) as usize;
        let turn = libm::atan2(touch.normal.1, touch.normal.0) / std::f64::consts::TAU;
        let side = libm::round(turn * SIDES as f64 + SIDES as f64) as usize % SIDES;
        window * SIDES + side
    }

    /// Share of a touch that its group does not know already: 1 for a lone one, little for one of many.
    pub(crate) fn independence(&self, touch: &Touch, calibration: &Calibration) -> f64 {
        let Some(group) = self.groups.get(self.index(touch)).filter(|g| g.precision > 0.0) else { return 1.0 };
        // How an offset of the walls goes with log scale: the distance of the wall.
        let range = SHARED_RANGE * group.slope[3] / group.precision;
        1.0 / (1.0 + (calibration.plan_variance() + range * range) * group.precision)
    }

    /// Measures anew; `covariances` are those of the fit that left these residuals.
    pub(crate) fn measure(&self, covariances: &[Matrix4<f64>], before: &Calibration, cell_m: f64) -> Calibration {
        let prior = Calibration::prior(cell_m);
        let prior_variance = prior.plan_sigma_m * prior.plan_sigma_m;
        let (mut sum, mut weight) = (PRIOR_GROUPS * prior_variance, PRIOR_GROUPS);
        let (mut within, mut freedom) = (PRIOR_SIGHTINGS, PRIOR_SIGHTINGS);
        let variance = before.plan_sigma_m * before.plan_sigma_m;
        for group in self.groups.iter().filter(|g| g.count > 2.0) {
            let mean = group.residual / group.precision;
            within += group.square - group.precision * mean * mean;
            freedom += group.count - 1.0;
            let slope = group.slope / group.precision;
            let white = 1.0 / group.precision;
            // What the fit took up of the offset.
            let taken = covariances.get(group.link).map_or(0.0, |p| slope.dot(&(p * slope))).min(variance + white);
            let left = 1.0 - taken / (variance + white);
            let worth = (left * variance / (variance + white)).powi(2);
            sum += worth * (mean * mean - white + taken);
            weight += worth;
        }
        // Not below a tenth of the prior: no drawing is that good.
        let plan_sigma_m = (sum / weight).max(0.01 * prior_variance).sqrt();
        let noise = (before.noise * before.noise * within / freedom.max(1.0)).sqrt().clamp(0.15, 1.5);
        Calibration { plan_sigma_m, persistence: self.persistence(prior_variance), noise }
    }

    /// How alike the offsets of neighbouring groups of one side are.
    fn persistence(&self, prior_variance: f64) -> f64 {
        let mean = |i: usize| self.groups.get(i).filter(|g| g.count > 2.0).map(|g| g.residual / g.precision);
        let (mut together, mut alone) = (0.3 * PRIOR_GROUPS * prior_variance, PRIOR_GROUPS * prior_variance);
        for i in 0..self.groups.len() {
            if let (Some(a), Some(b)) = (mean(i), mean(i + SIDES)) {
                together += a * b;
                alone += 0.5 * (a * a + b * b);
            }
        }
        (together / alone).clamp(0.0, 0.7)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::normal;
    use planwalk_types::Seed;

    /// Walls to the left whose offsets have spread `plan` from window to window, seen with noise `noise`.
    fn touches(plan: f32, noise: f32, windows: usize) -> (Vec<Touch>, Vec<f64>) {
        let mut rng = Seed(4).derive("offsets", 0);
        let way_m: Vec<f64> = (0..windows * 8).map(|i| 0.25 * i as f64).collect();
        let mut all = Vec::new();
        let mut offset = 0.0;
        for link in 0..way_m.len() {
            if link % 8 == 0 {
                offset = plan * normal(&mut rng);
            }
            for _ in 0..8 {
                let residual_m = f64::from(offset + noise * normal(&mut rng));
                let slope = Vector4::new(0.0, -1.0, 0.0, 0.0);
                all.push(Touch { link, normal: (0.0, -1.0), residual_m, slope, sigma_m: 0.12, share: 1.0 });
            }
        }
        (all, way_m)
    }

    #[test]
    fn offsets_and_noise_are_told_apart_and_measured() {
        let (touches, way_m) = touches(0.08, 0.06, 100);
        let groups = Grouped::new(touches.iter(), &way_m);
        let covariances = vec![Matrix4::zeros(); way_m.len()];
        let mut calibration = Calibration::prior(0.05);
        for _ in 0..5 {
            calibration = Calibration { noise: 1.0, ..groups.measure(&covariances, &calibration, 0.05) };
        }
        // A spread from 100 draws is good to 1/√200 = 7 %; the prior's 8 groups take another 5 %.
        assert!((calibration.plan_sigma_m / 0.08 - 1.0).abs() < 0.2, "{calibration:?}");
        let noise = groups.measure(&covariances, &calibration, 0.05).noise;
        assert!((noise / 0.5 - 1.0).abs() < 0.05, "{noise}: 0.06 of the 0.12 m that were stated");
        assert!(calibration.persistence < 0.3, "each window's offset is its own: {calibration:?}");
    }

    #[test]
    fn a_short_walk_does_not_claim_to_know_the_plan() {
        let (touches, way_m) = touches(0.0, 0.01, 1);
        let groups = Grouped::new(touches.iter(), &way_m);
        let prior = Calibration::prior(0.05);
        let calibration = groups.measure(&vec![Matrix4::zeros(); way_m.len()], &prior, 0.05);
        assert!(calibration.plan_sigma_m > 0.8 * prior.plan_sigma_m, "{calibration:?}");
    }

    #[test]
    fn a_hundred_looks_at_one_wall_are_worth_a_few() {
        let (touches, way_m) = touches(0.05, 0.05, 1);
        let groups = Grouped::new(touches.iter(), &way_m);
        let worth: f64 = touches.iter().map(|t| groups.independence(t, &Calibration::prior(0.05))).sum();
        assert!(worth < 4.0, "{} sightings of one wall count as {worth}", touches.len());
    }
}

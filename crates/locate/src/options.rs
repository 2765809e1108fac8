//! What can be chosen about a localisation, and what holds where nobody chose?

use planwalk_types::{FloorPlan, Seed};

use crate::LocateError;
use crate::drift::HeadingDrift;
use crate::likelihood::SightingModel;
use crate::look::LookOptions;
use crate::motion::NoiseFloor;
use crate::prior::{ScalePrior, StartPrior};
use crate::verdict::VerdictOptions;
use crate::walls::GroundCosts;

/// Options of [`crate::Localizer`] and [`crate::localize`].
#[derive(Debug, Clone, PartialEq)]
pub struct LocateOptions {
    /// Where chance comes from.
    pub seed: Seed,
    /// Where the walk begins, if somebody knows.
    pub start: Option<StartPrior>,
    /// Metres in a unit of odometry.
    pub scale: ScalePrior,
    /// Noise that every odometry is taken to have at least.
    pub noise_floor: NoiseFloor,
    /// How much the scale of odometry drifts: standard deviation of its logarithm per √m walked. It is drawn back to
    /// [`LocateOptions::scale`], so that drift and pull balance at the prior's own spread.
    pub scale_drift_per_sqrt_m: f64,
    /// How much its heading may drift.
    pub heading_drift: HeadingDrift,
    /// How sightings score.
    pub sightings: SightingModel,
    /// What ground costs that is no floor.
    pub ground: GroundCosts,
    /// Probability that a walk goes through what the plan calls a wall: planned and not built, or a door drawn shut.
    pub leak: f64,
    /// Particles for each square metre of floor at an unknown start: all headings and scales share them.
    pub particles_per_m2: f64,
    /// Fewest particles, once the place is clear.
    pub particles_min: usize,
    /// Most particles.
    pub particles_max: usize,
    /// Particles for each filled bin (0.5 m, 0.5 m, 15°) that resampling keeps: the number falls as the cloud gathers.
    pub particles_per_bin: f64,
    /// The filter updates when the body has moved so far, in metres at the prior's scale …
    pub update_distance_m: f64,
    /// … or has turned by so much, radians.
    pub update_turn_rad: f64,
    /// Resample when the effective share of particles falls below this.
    pub resample_below: f64,
    /// When a place is believed.
    pub verdict: VerdictOptions,
    /// Look over the whole plan: at first, now and then, and when what is seen is not explained any more (mixture MCL, Thrun et
    /// al. 2001; the kidnapped robot). Not where a start was given: whoever says where the walk began is believed before sightings
    /// that explain little.
    pub relocalise: bool,
    /// Most particles at an unknown start where sightings are to come: the first look finds what so few leave out.
    pub particles_seeing: usize,
    /// How the whole plan is looked at.
    pub look: LookOptions,
    /// Way that [`crate::Localizer`] remembers, metres at the prior's scale; `None` for all of it. A stream without end needs a bound:
    /// what is forgotten is not smoothed, and not in the answer of [`crate::Localizer::finish`]. What is known now does not change.
    pub remember_m: Option<f64>,
    /// Most independent runs over a whole walk whose start is unknown; two that agree on the best place end the search. A
    /// filter that loses the right place among a million others loses it for good; another one, with other draws, may not.
    pub attempts: usize,
}

impl LocateOptions {
    /// The defaults for this seed and scale, start unknown.
    pub fn new(seed: Seed, scale: ScalePrior) -> Self {
        Self {
            seed,
            start: None,
            scale,
            noise_floor: NoiseFloor::default(),
            scale_drift_per_sqrt_m: 0.01,
            heading_drift: HeadingDrift::default(),
            sightings: SightingModel::default(),
            ground: GroundCosts::default(),
            leak: 0.025,
            particles_per_m2: 3000.0,
            particles_min: 8_000,
            particles_max: 1_000_000,
            particles_per_bin: 20.0,
            update_distance_m: 0.25,
            update_turn_rad: 10f64.to_radians(),
            resample_below: 0.5,
            verdict: VerdictOptions::default(),
            relocalise: true,
            particles_seeing: 150_000,
            look: LookOptions::default(),
            remember_m: None,
            attempts: 3,
        }
    }

    pub(crate) fn check(&self, plan: &FloorPlan) -> Result<(), LocateError> {
        let scale = self.scale;
        if !(scale.metres_per_unit > 0.0 && scale.metres_per_unit.is_finite() && (0.0..=3.0).contains(&scale.relative_sigma)) {
            let (metres_per_unit, relative_sigma) = (scale.metres_per_unit, scale.relative_sigma);
            return Err(LocateError::BadScalePrior { metres_per_unit, relative_sigma });
        }
        let Some(start) = &self.start else { return Ok(()) };
        let finite = [start.x, start.y, start.heading_rad.unwrap_or(0.0)].iter().all(|v| v.is_finite());
        if !(finite && start.sigma_m >= 0.0 && start.sigma_m.is_finite() && start.sigma_rad >= 0.0 && start.sigma_rad.is_finite()) {
            return Err(LocateError::BadStart { x: start.x, y: start.y, sigma_m: start.sigma_m, sigma_rad: start.sigma_rad });
        }
        let (low, (width, height)) = (plan.origin(), plan.size_m());
        let (high_x, high_y) = (low.x + width, low.y + height);
        let off_m = (low.x - start.x).max(start.x - high_x).max(low.y - start.y).max(start.y - high_y);
        if off_m > self.ground.margin_m + 3.0 * start.sigma_m {
            let span = [low.x, high_x, low.y, high_y];
            return Err(LocateError::StartOffPlan { x: start.x, y: start.y, off_m, span });
        }
        Ok(())
    }
}

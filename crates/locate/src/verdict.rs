//! Is the walker where the filter thinks: tracking, ambiguous, or lost?
//!
//! modes + how much better the best one explains the sightings than calling them all furniture does ──▶ Status
//!
//! A mode's mass says only that it beats its rivals *among the particles*. Therefore a best mode whose walls explain nothing
//! of what was seen is lost, however much mass it has; and where nothing was seen, no place is believed unless somebody said
//! where the walk began: a cloud that only avoids walls gathers somewhere, right or wrong.

use planwalk_types::Status;

use crate::modes::Modes;

/// When a place is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerdictOptions {
    /// Mass that the best mode must hold. At 0.9 a rival with odds of 1 : 9 still makes the answer ambiguous.
    pub mass: f64,
    /// Largest 95 % radius of one place, metres: a room, not a wing.
    pub radius_m: f64,
    /// Largest standard deviation of the heading, radians.
    pub heading_sigma_rad: f64,
    /// Nats a sighting by which the best mode must beat calling everything furniture. On real plans, with half of the
    /// sightings on furniture, the truth does by 1.1–1.9 (a robot's laser: 2–2.7); on the plan of another floor the best place
    /// does by −0.2 to 0.4 most of the time, and by 1 in passing.
    pub gain_nats: f64,
    /// Gain under which no place explains what is seen.
    pub lost_nats: f64,
    /// Way over which gain is averaged, metres.
    pub memory_m: f64,
    /// Share of the sightings that may go through drawn walls along the track. The truth stays under 0.06 on real plans; a
    /// place that looked right for most of the way has 0.1 and more.
    pub through: f64,
    /// Way that must be walked with sightings before an unknown start is believed, metres.
    pub seen_m: f64,
}

impl Default for VerdictOptions {
    fn default() -> Self {
        Self {
            mass: 0.9,
            radius_m: 3.0,
            heading_sigma_rad: 20f64.to_radians(),
            gain_nats: 0.5,
            lost_nats: 0.3,
            memory_m: 12.0,
            through: 0.08,
            seen_m: 5.0,
        }
    }
}

/// What has spoken for the best mode so far.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Evidence {
    /// Smoothed nats a sighting over calling everything furniture.
    pub gain_nats: f64,
    /// Way walked with sightings, metres, since the start or the last new beginning.
    pub seen_m: f64,
    /// Sum of the weights of the running mean, 0..1.
    filled: f64,
}

impl Evidence {
    /// Adds an update that had sightings, after `moved_m` of way.
    pub(crate) fn add(&mut self, gain_nats: f64, moved_m: f64, options: &VerdictOptions) {
        // Turning on the spot sees new things too: it counts as a quarter of a metre.
        let moved_m = moved_m.max(0.25);
        let share = 1.0 - libm::exp(-moved_m / options.memory_m.max(1e-3));
        self.filled += share * (1.0 - self.filled);
        self.gain_nats += (gain_nats - self.gain_nats) * share / self.filled.max(share);
        self.seen_m += moved_m;
    }

    /// No place explains what is seen, and long enough.
    pub(crate) fn is_lost(&self, options: &VerdictOptions) -> bool {
        self.seen_m > options.memory_m && self.gain_nats < options.lost_nats
    }
}

/// The verdict on this cloud. `start_known` stands in for sightings: somebody said where the walk began.
pub(crate) fn verdict(modes: &Modes, evidence: &Evidence, start_known: bool, options: &VerdictOptions) -> Status {
    if evidence.is_lost(options) {
        return Status::Lost;
    }
    let Some(best) = modes.modes.first() else { return Status::Lost };
    let compact = best.radius95_m <= options.radius_m && best.covariance[(2, 2)].sqrt() <= options.heading_sigma_rad;
    let seen = evidence.seen_m >= options.seen_m && evidence.gain_nats >= options.gain_nats;
    let never_seen = evidence.seen_m == 0.0;
    if best.mass >= options.mass && compact && (seen || start_known && (never_seen || evidence.seen_m < options.seen_m)) {
        Status::Tracking
    } else {
        Status::Ambiguous
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_explains_nothing_is_lost_once_enough_was_seen() {
        let options = VerdictOptions::default();
        let mut evidence = Evidence::default();
        evidence.add(0.0, 1.0, &options);
        assert!(!evidence.is_lost(&options), "one look is not enough");
        for _ in 0..20 {
            evidence.add(0.0, 1.0, &options);
        }
        assert!(evidence.is_lost(&options));
        for _ in 0..40 {
            evidence.add(1.0, 1.0, &options);
        }
        assert!(!evidence.is_lost(&options) && evidence.gain_nats > 0.9, "{evidence:?}");
    }

    #[test]
    fn the_running_gain_is_unbiased_from_the_first_look() {
        let options = VerdictOptions::default();
        let mut evidence = Evidence::default();
        evidence.add(0.8, 0.3, &options);
        assert!((evidence.gain_nats - 0.8).abs() < 1e-12);
    }
}

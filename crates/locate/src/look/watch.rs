//! When is it time to look over the whole plan: at first, when what is seen is not explained any more, and now and then?
//!
//! moved metres + gain of each update ──▶ [`Due`]

use super::LookOptions;

/// Way over which the recent gain is averaged, metres: a carried-off walker is noticed within a few.
const RECENT_M: f64 = 3.0;

/// Why to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Due {
    /// Nobody has looked yet.
    First,
    /// What is seen is not explained where the walker is believed to be.
    Doubt,
    /// Only to make sure.
    Check,
}

/// Keeps count of the way since the last look, and of how well the view was explained.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Watch {
    looked: bool,
    since_look_m: f64,
    /// Way walked in doubt.
    doubt_m: f64,
    recent_nats: f64,
    filled: f64,
}

impl Watch {
    /// Adds an update that saw something, after `moved_m` of way; `gain_nats` as in [`crate::VerdictOptions::gain_nats`].
    pub(crate) fn add(&mut self, gain_nats: f64, moved_m: f64, options: &LookOptions) -> Option<Due> {
        let share = 1.0 - libm::exp(-moved_m.max(0.1) / RECENT_M);
        self.filled += share * (1.0 - self.filled);
        self.recent_nats += (gain_nats - self.recent_nats) * share / self.filled.max(share);
        self.since_look_m += moved_m;
        self.doubt_m = if self.recent_nats < options.doubt_nats { self.doubt_m + moved_m } else { 0.0 };
        let due = if !self.looked {
            (self.since_look_m >= options.way_m).then_some(Due::First)
        } else if self.doubt_m >= RECENT_M && self.since_look_m >= RECENT_M {
            Some(Due::Doubt)
        } else {
            (self.since_look_m >= options.every_m).then_some(Due::Check)
        };
        if due.is_some() {
            (self.looked, self.since_look_m) = (true, 0.0);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_looks_first_then_now_and_then_and_soon_in_doubt() {
        let options = LookOptions::default();
        let mut watch = Watch::default();
        let mut walk = |gain: f64, metres: usize| (0..4 * metres).filter_map(|_| watch.add(gain, 0.25, &options)).collect::<Vec<_>>();
        assert_eq!(walk(1.5, options.way_m as usize), [Due::First]);
        assert_eq!(walk(1.5, options.every_m as usize), [Due::Check]);
        // From 1.5 nats the mean over 3 m falls below the line within 4 m; 3 m of doubt later it is time.
        assert_eq!(walk(0.0, 8), [Due::Doubt]);
    }
}

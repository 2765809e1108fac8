//! When is it time to look over the whole plan: at first, when what is seen is not explained any more, and now and then?
//!
//! moved metres + gain of each update ──▶ [`Due`] ──look──▶ [`Watch::told`] something, or was [`Watch::unclear`]: again later

use super::LookOptions;
use super::window::KEPT_M;

/// Nats a sighting, times metres, by which what is seen falls short of [`LookOptions::doubt_nats`] before the place is looked for …
const DOUBT_NATS_M: f64 = 1.0;
/// … before no place is believed …
const BELIEVED_NATS_M: f64 = 0.3;
/// … and at most: a place that explains things again is believed after some metres, however long it was doubted.
const MOST_NATS_M: f64 = 3.0;
/// Way in doubt before the first look for it, metres; later ones wait for half as much way again.
const DOUBT_M: f64 = 2.0;
/// Way in doubt after which more than the place is doubted, metres.
const LONG_DOUBT_M: f64 = 24.0;
/// A look that told too little takes in so many times the way when it is repeated.
const LONGER: f64 = 1.5;

/// Why to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Due {
    /// No look has told anything yet.
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
    /// Looks in a row that told too little.
    unclear: i32,
    since_look_m: f64,
    /// By how much what is seen falls short, summed up over the way and never below zero: the test for a change of Page (1954,
    /// CUSUM). Nats a sighting, times metres.
    short_nats_m: f64,
    /// Way walked since it was zero: when the change came, most likely.
    doubt_m: f64,
}

impl Watch {
    /// Adds an update that saw something, after `moved_m` of way; `gain_nats` as in [`crate::VerdictOptions::gain_nats`].
    pub(crate) fn add(&mut self, gain_nats: f64, moved_m: f64, options: &LookOptions) -> Option<Due> {
        let moved_m = moved_m.max(0.1);
        self.short_nats_m = (self.short_nats_m + (options.doubt_nats - gain_nats) * moved_m).clamp(0.0, MOST_NATS_M);
        self.doubt_m = if self.short_nats_m > 0.0 { self.doubt_m + moved_m } else { 0.0 };
        self.since_look_m += moved_m;
        let due = if !self.looked {
            // The first look waits for its whole way, a repeated one for what is new.
            let way_m = if self.unclear == 0 { options.way_m } else { self.way_m(options) * (1.0 - 1.0 / LONGER) };
            (self.since_look_m >= way_m).then_some(Due::First)
        } else if self.doubts_enough() {
            (self.since_look_m >= DOUBT_M.max((1.0 - 1.0 / LONGER) * self.doubt_m)).then_some(Due::Doubt)
        } else {
            (self.since_look_m >= options.every_m).then_some(Due::Check)
        };
        if due.is_some() {
            self.since_look_m = 0.0;
        }
        due
    }

    fn doubts_enough(&self) -> bool {
        self.short_nats_m >= DOUBT_NATS_M && self.doubt_m >= DOUBT_M
    }

    /// Way that the look takes in that is due, metres. In doubt what was seen before it began may be of another place.
    pub(crate) fn way_m(&self, options: &LookOptions) -> f64 {
        if self.looked && self.doubts_enough() {
            return self.doubt_m.min(KEPT_M.max(options.way_m));
        }
        (options.way_m * libm::pow(LONGER, f64::from(self.unclear))).min(KEPT_M.max(options.way_m))
    }

    /// The look that was due told where the walker can be.
    pub(crate) fn told(&mut self) {
        (self.looked, self.unclear) = (true, 0);
    }

    /// The look that was due told too little.
    pub(crate) fn unclear(&mut self) {
        self.unclear = self.unclear.saturating_add(1);
    }

    /// Whether what is seen is not explained where the walker is believed to be, for more than a moment.
    pub(crate) fn in_doubt(&self) -> bool {
        self.short_nats_m > BELIEVED_NATS_M
    }

    /// Whether doubt has lasted for so long that even the unit of odometry may have been wrong.
    pub(crate) fn in_long_doubt(&self) -> bool {
        self.doubt_m > LONG_DOUBT_M
    }

    /// Way walked in doubt, metres.
    pub(crate) fn doubt_m(&self) -> f64 {
        self.doubt_m
    }

    /// Whether any look has told something.
    pub(crate) fn has_looked(&self) -> bool {
        self.looked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is due over so many metres, each look told something or not.
    fn walk(watch: &mut Watch, gain: f64, metres: usize, tells: bool) -> Vec<Due> {
        let step = |_| {
            let due = watch.add(gain, 0.25, &LookOptions::default());
            match due {
                Some(_) if tells => watch.told(),
                Some(_) => watch.unclear(),
                None => {}
            }
            due
        };
        (0..4 * metres).filter_map(step).collect()
    }

    #[test]
    fn one_looks_first_then_now_and_then_and_soon_in_doubt() {
        let options = LookOptions::default();
        let mut watch = Watch::default();
        assert_eq!(walk(&mut watch, 1.5, options.way_m as usize, true), [Due::First]);
        assert_eq!(walk(&mut watch, 1.5, options.every_m as usize, true), [Due::Check]);
        // Nothing explained falls short by 0.4 nats: 2.5 m make one nat times metre. Then 2 m are enough, or half as much way again:
        // after 4.5, 6.75, 10 m.
        assert_eq!(walk(&mut watch, 0.0, 3, true), [Due::Doubt]);
        assert!(watch.in_doubt());
        assert_eq!(walk(&mut watch, 0.0, 8, true), [Due::Doubt; 3]);
    }

    #[test]
    fn a_look_in_doubt_takes_in_the_way_since_it_began() {
        let options = LookOptions::default();
        let mut watch = Watch::default();
        walk(&mut watch, 1.5, 20, true);
        walk(&mut watch, -0.5, 5, true);
        assert!((watch.way_m(&options) - 5.0).abs() < 1e-9, "{}", watch.way_m(&options));
        // A metre that is explained by chance does not make it begin anew; four do: doubt is bounded.
        walk(&mut watch, 0.8, 1, true);
        assert!((watch.way_m(&options) - 6.0).abs() < 1e-9 && watch.in_doubt());
        walk(&mut watch, 1.2, 4, true);
        assert!(!watch.in_doubt() && watch.doubt_m() == 0.0);
    }

    #[test]
    fn a_first_look_that_tells_nothing_is_repeated_over_more_way() {
        let options = LookOptions::default();
        let mut watch = Watch::default();
        assert_eq!(walk(&mut watch, 1.5, options.way_m as usize, false), [Due::First]);
        assert!(!watch.has_looked() && (watch.way_m(&options) - 12.0).abs() < 1e-9);
        assert_eq!(walk(&mut watch, 1.5, 4, false), [Due::First]);
        assert_eq!(walk(&mut watch, 1.5, 40, false).len(), 5);
        assert_eq!(watch.way_m(&options), KEPT_M);
        walk(&mut watch, 1.5, 8, true);
        assert!(watch.has_looked() && watch.way_m(&options) == options.way_m);
    }
}

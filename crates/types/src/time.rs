//! When? Nanoseconds on the source's own clock.

use serde::{Deserialize, Serialize};

/// A moment in nanoseconds, from the container's own stamps; never `i / fps` where a clip has real ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Stamp(pub i64);

impl Stamp {
    /// The moment `seconds` after the clock's zero, rounded to the nanosecond; `None` where it is not finite or does not fit.
    pub fn from_secs(seconds: f64) -> Option<Self> {
        let ns = (seconds * 1e9).round();
        // i64::MAX is not an f64; 9.2e18 ns are 292 years, more than any clock here says.
        (ns.abs() < 9.2e18).then_some(Self(ns as i64))
    }

    /// Seconds since the clock's zero.
    pub fn as_secs(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Seconds from `earlier` to `self`; exact for clips, also where the clock's zero is far away (unix time).
    pub fn secs_since(self, earlier: Stamp) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 * 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unix_time_keeps_its_microseconds() {
        let stamp = Stamp::from_secs(1_700_000_000.123_456).unwrap();
        // f64 holds 1.7e9 s to 2.4e-7 s.
        assert!((stamp.secs_since(Stamp(1_700_000_000_000_000_000)) - 0.123_456).abs() < 3e-7);
    }

    #[test]
    fn what_is_not_a_number_is_no_moment() {
        assert_eq!(Stamp::from_secs(f64::NAN), None);
        assert_eq!(Stamp::from_secs(f64::INFINITY), None);
        assert_eq!(Stamp::from_secs(1e12), None);
    }
}

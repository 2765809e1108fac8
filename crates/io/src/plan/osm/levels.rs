//! On which storeys is it? The values of `level` and `repeat_on`: `0`, `1;2`, `-3--1`, `0.5`.
//!
//! A range goes up by whole storeys. Storeys between two others (0.5) are storeys like any other.

use std::collections::BTreeSet;

/// Most storeys that one object is on: the tallest building has 163.
const MOST_LEVELS: usize = 200;
/// Farthest storey from the ground that is taken for one.
const FARTHEST: f64 = 1000.0;

/// A storey as OpenStreetMap numbers them, in thousandths; 0 is the ground floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub(in super::super) struct Level(i32);

impl Level {
    fn of(number: &str) -> Option<Self> {
        let value: f64 = number.trim().parse().ok().filter(|v: &f64| v.abs() <= FARTHEST)?;
        Some(Self((value * 1000.0).round() as i32))
    }

    /// Its number.
    pub(in super::super) fn number(self) -> f64 {
        f64::from(self.0) / 1000.0
    }

    /// The same in digits.
    pub(in super::super) fn name(self) -> String {
        self.number().to_string()
    }
}

/// The storeys that a value lists; `None` if it is not to be understood.
pub(in super::super) fn parse(value: &str) -> Option<BTreeSet<Level>> {
    let mut levels = BTreeSet::new();
    for part in value.split([';', ',']).map(str::trim).filter(|part| !part.is_empty()) {
        let (from, to) = Level::of(part).map(|one| (one, one)).or_else(|| range(part))?;
        let (low, high) = (from.min(to).0, from.max(to).0);
        levels.extend((low..=high).step_by(1000).take(MOST_LEVELS + 1).map(Level));
        if levels.len() > MOST_LEVELS {
            return None;
        }
    }
    (!levels.is_empty()).then_some(levels)
}

/// Two numbers with a dash between them, which may have signs of their own.
fn range(part: &str) -> Option<(Level, Level)> {
    part.match_indices('-').find_map(|(at, dash)| {
        let (from, to) = (part.get(..at)?, part.get(at + dash.len()..)?);
        Some((Level::of(from)?, Level::of(to)?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn names(value: &str) -> Option<Vec<String>> {
        parse(value).map(|levels| levels.into_iter().map(Level::name).collect())
    }

    #[test]
    fn numbers_lists_and_ranges_are_understood() {
        for (value, wanted) in [
            ("0", &["0"][..]),
            ("-0", &["0"]),
            ("1;2", &["1", "2"]),
            ("2; 1;", &["1", "2"]),
            ("-3--1", &["-3", "-2", "-1"]),
            ("-1-2", &["-1", "0", "1", "2"]),
            ("0-1;5", &["0", "1", "5"]),
            ("2-0", &["0", "1", "2"]),
            ("0.5", &["0.5"]),
            ("0.5-2.5", &["0.5", "1.5", "2.5"]),
        ] {
            assert_eq!(names(value).unwrap(), wanted, "{value}");
        }
        for value in ["", ";", "EG", "1-", "-", "--", "1--", "nan", "inf", "1e9", "0-100000", "-900-900", "1-2-3"] {
            assert_eq!(names(value), None, "{value}");
        }
    }

    proptest! {
        #[test]
        fn any_value_is_read_or_refused(value in "[-0-9.;, ]{0,20}") {
            prop_assert!(parse(&value).is_none_or(|levels| levels.len() <= MOST_LEVELS));
        }
    }
}

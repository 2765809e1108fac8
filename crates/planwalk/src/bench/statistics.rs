//! How far may a mean, a median or a share be off, given so few walks?
//!
//! Medians and means: percentile bootstrap over walks (Efron & Tibshirani 1993, ch. 13). Shares: Wilson's score interval (1927),
//! which is sane at 0 of N and at N of N. Flips between two benches: the exact sign test (McNemar 1947).

use planwalk_types::Seed;
use rand::RngExt;

pub use crate::evaluate::statistics::mean;

/// Resamples of the bootstrap: the ends of a 95 % interval are then good to a few per cent of its width.
const RESAMPLES: usize = 2000;
/// √ of the 95 % point of χ² with one degree of freedom.
const SIGMAS_95: f64 = 1.959_963_984_540_054;

/// A number with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Best guess.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Whether zero is excluded: a difference that is not noise.
    pub fn excludes_zero(&self) -> bool {
        self.low > 0.0 || self.high < 0.0
    }
}

/// The median; infinite values ("never") are values like any other. `None` of nothing, or where anything is not a number.
pub fn median(values: &[f64]) -> Option<f64> {
    if values.is_empty() || values.iter().any(|v| v.is_nan()) {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
    // Infinity minus infinity is no number.
    Some(if low == high { low } else { 0.5 * (low + high) })
}

/// A statistic of values with its bootstrap interval; the same numbers for the same values.
pub fn bootstrap(values: &[f64], statistic: impl Fn(&[f64]) -> Option<f64>) -> Option<Interval> {
    let value = statistic(values)?;
    let mut rng = Seed(values.len() as u64).derive("bootstrap", 0);
    let mut drawn = vec![0.0; values.len()];
    let mut all: Vec<f64> = (0..RESAMPLES)
        .filter_map(|_| {
            drawn.iter_mut().for_each(|d| *d = values[rng.random_range(0..values.len())]);
            statistic(&drawn)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all.get(((all.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(value);
    Some(Interval { value, low: at(0.025), high: at(0.975) })
}

/// A share of `hits` in `of`, with Wilson's interval.
pub fn share(hits: usize, of: usize) -> Option<Interval> {
    if of == 0 {
        return None;
    }
    let (n, p) = (of as f64, hits as f64 / of as f64);
    let z2 = SIGMAS_95 * SIGMAS_95;
    let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = SIGMAS_95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    Some(Interval { value: p, low: (middle - half).max(0.0), high: (middle + half).min(1.0) })
}

/// Probability that a fair coin is at least as lopsided as `one` against `other` (two-sided, exact).
pub fn sign_test(one: usize, other: usize) -> f64 {
    let (n, few) = (one + other, one.min(other));
    // log n!/(k! (n−k)!) − n log 2, summed from k = 0.
    let (mut log_term, mut sum) = (-(n as f64) * std::f64::consts::LN_2, 0.0);
    for k in 0..=few {
        sum += log_term.exp();
        log_term += ((n - k) as f64).ln() - ((k + 1) as f64).ln();
    }
    (2.0 * sum).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_takes_never_for_an_answer() {
        assert_eq!(median(&[3.0, 1.0, f64::INFINITY]), Some(3.0));
        assert_eq!(median(&[1.0, f64::INFINITY, f64::INFINITY, f64::INFINITY]), Some(f64::INFINITY));
        assert_eq!((median(&[]), median(&[f64::NAN])), (None, None));
    }

    #[test]
    fn shares_have_the_intervals_of_the_literature() {
        // Newcombe 1998, table I: 81 of 263, and 0 of 20.
        let of_263 = share(81, 263).unwrap();
        assert!((of_263.low - 0.2553).abs() < 1e-4 && (of_263.high - 0.3662).abs() < 1e-4, "{of_263:?}");
        let none = share(0, 20).unwrap();
        assert!(none.low == 0.0 && (none.high - 0.1611).abs() < 1e-4, "{none:?}");
    }

    #[test]
    fn the_bootstrap_holds_the_truth_about_as_often_as_it_says() {
        // Means of 30 uniform numbers, 400 times; the truth is 0.5.
        let mut rng = Seed(8).derive("test", 0);
        let mut held = 0;
        for _ in 0..400 {
            let values: Vec<f64> = (0..30).map(|_| rng.random_range(0.0..1.0)).collect();
            let interval = bootstrap(&values, mean).unwrap();
            held += usize::from(interval.low <= 0.5 && 0.5 <= interval.high);
        }
        // The percentile bootstrap of 30 values covers some 93–95 %; four standard errors of 400 trials are 4.4 %.
        assert!((0.89..=0.99).contains(&(f64::from(held as u32) / 400.0)), "{held} of 400");
    }

    #[test]
    fn lopsided_coins_are_told_from_fair_ones() {
        assert!((sign_test(5, 5) - 1.0).abs() < 1e-12 && (sign_test(0, 0) - 1.0).abs() < 1e-12);
        // 2 / 2^6.
        assert!((sign_test(0, 6) - 0.03125).abs() < 1e-12);
        assert!((sign_test(1, 9) - 0.021_484_375).abs() < 1e-12);
    }
}

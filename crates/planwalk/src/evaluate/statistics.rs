//! How is a list of errors said in a few numbers?

use serde::{Deserialize, Serialize};

/// Errors in a few numbers, all in the unit of the errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median; the mean of the middle two of an even number.
    pub median: f64,
    /// Standard deviation about the mean (of the population, not of a sample).
    pub std: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

impl Summary {
    /// Of these errors; `None` without any.
    pub fn of(errors: &[f64]) -> Option<Self> {
        let (min, max) = errors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(*e), high.max(*e)));
        let (mean, median) = (mean(errors)?, quantile(errors, 0.5)?);
        let std = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64;
        Some(Self { rmse: rmse(errors)?, mean, median, std: std.sqrt(), min, max })
    }
}

/// Mean; `None` of nothing.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Root of the mean square; `None` of nothing.
pub fn rmse(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt())
}

/// The value below which a share `q` (0..=1) of all lie, linear between neighbours; `None` of nothing.
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = q.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    Some(low + (at - at.floor()) * (high - low))
}

/// Share of the flags that are set; 0 of nothing.
pub fn share(flags: impl Iterator<Item = bool>) -> f64 {
    let (set, all) = flags.fold((0usize, 0usize), |(set, all), flag| (set + usize::from(flag), all + 1));
    set as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_of_four() {
        let s = Summary::of(&[3.0, 1.0, 2.0, 6.0]).unwrap();
        assert_eq!((s.mean, s.median, s.min, s.max, s.std), (3.0, 2.5, 1.0, 6.0, 3.5f64.sqrt()));
        assert_eq!(s.rmse, 12.5f64.sqrt());
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[10.0, 0.0, 20.0], 0.95), Some(19.0));
        assert_eq!((quantile(&[7.0], 0.95), quantile(&[], 0.5)), (Some(7.0), None));
        assert_eq!(share([true, false, true, true].into_iter()), 0.75);
    }
}

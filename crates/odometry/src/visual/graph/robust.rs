//! How much is a loop, or another edge that may lie, believed that disagrees with all the rest?
//!
//! Geman & McClure's loss ρ(χ²) = χ² / (1 + χ²/Φ), with the weight (1 + χ²/Φ)⁻²: it is what remains of a switch on each loop when
//! the switches are solved for (Sünderhauf & Protzel 2012; Agarwal et al. 2013, "dynamic covariance scaling", write the weight as
//! min(1, 2Φ/(Φ + χ²))², which is four times ours far out and leaves small χ² alone).
//!
//! Pitfall: a true loop at the end of a long drift is far off as well, and would be doubted before it could pull. So doubt begins
//! wide enough to believe everything and narrows (graduated non-convexity; Yang, Antonante, Tzoumas & Carlone 2020).

/// The factor by which doubt narrows from one round to the next. Yang et al. take 1.4; with a few steps a round 4 finds the same.
pub const NARROWING: f64 = 4.0;

/// Doubt of loops.
#[derive(Debug, Clone, Copy)]
pub struct Doubt {
    /// Squared Mahalanobis distance Φ at which a quarter of the weight is left.
    pub at: f64,
}

impl Doubt {
    /// Weight of a loop with this squared Mahalanobis distance.
    pub fn weight(self, squared: f64) -> f64 {
        (1.0 + squared / self.at).powi(-2)
    }

    /// What it costs.
    pub fn cost(self, squared: f64) -> f64 {
        // An infinite distance costs Φ; as it stands it would be no number.
        if squared.is_infinite() { self.at } else { squared / (1.0 + squared / self.at) }
    }
}

/// By how much doubt is widened at first so that the loss is convex at the worst loop: its second derivative by χ changes
/// sign at χ² = Φ/3.
pub fn first_widening(doubt_at: f64, worst_squared: f64) -> f64 {
    (3.0 * worst_squared / doubt_at).clamp(1.0, 1e12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_slope_of_the_cost() {
        let doubt = Doubt { at: 24.0 };
        for squared in [0.0, 1.0, 24.0, 500.0] {
            let slope = (doubt.cost(squared + 1e-5) - doubt.cost(squared - 1e-5)) / 2e-5;
            // Differencing: 500 · ε / 1e-5 = 1e-8.
            assert!((slope - doubt.weight(squared)).abs() < 1e-7, "{slope} at {squared}");
        }
        assert_eq!(doubt.weight(24.0), 0.25);
    }

    #[test]
    fn without_doubt_all_counts_and_with_it_no_more_than_its_limit() {
        let none = Doubt { at: f64::INFINITY };
        assert_eq!((none.weight(1e9), none.cost(1e9)), (1.0, 1e9));
        assert!(Doubt { at: 24.0 }.cost(1e12) <= 24.0 && Doubt { at: 24.0 }.cost(f64::INFINITY) <= 24.0);
    }

    #[test]
    fn a_wide_doubt_is_convex_at_the_worst() {
        let doubt = Doubt { at: 24.0 * first_widening(24.0, 1e4) };
        let cost = |chi: f64| doubt.cost(chi * chi);
        assert!(cost(100.5) - 2.0 * cost(99.5) + cost(98.5) > 0.0);
        assert_eq!(first_widening(f64::INFINITY, 1e4), 1.0);
    }
}

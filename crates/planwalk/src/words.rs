//! How is a result said in a sentence? The same words on the terminal, in pictures and in the report.

use planwalk_types::{Estimate, ScaleEstimate, Status};

/// The verdict as a sentence; `probability` is that of the likeliest place.
pub fn verdict(status: Status, probability: f64) -> String {
    let share = percent(probability);
    match status {
        Status::Tracking => "One place on the plan explains the walk.".to_owned(),
        // Mass alone is no proof: the place must also explain what was seen.
        Status::Ambiguous if probability >= 0.9 => format!("The likeliest place holds {share}, but the evidence for it is thin."),
        Status::Ambiguous => format!("The walk is not pinned to one place yet: the likeliest holds {share}."),
        Status::Lost => "No place on the plan explains the walk; the likeliest is drawn.".to_owned(),
    }
}

/// Where the walk ended, how sure that is, and which way the walker faced.
pub fn end_pose(end: &Estimate) -> String {
    let heading_deg = signed(end.pose.heading_rad.to_degrees(), 0);
    format!("({}, {}) m ± {:.2} m (95 %), facing {heading_deg}°", signed(end.pose.x, 2), signed(end.pose.y, 2), end.radius95_m)
}

/// The scale, e.g. `1 unit of odometry = 0.84 m ± 5 %`.
pub fn scale(scale: &ScaleEstimate) -> String {
    format!("1 unit of odometry = {} m ± {:.0} %", significant(scale.metres_per_unit), 100.0 * scale.relative_sigma)
}

/// A share as per cent; what is neither none nor all is not rounded to it.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p > 0.0 && p < 1.0 => "< 1 %".to_owned(),
        p if p > 99.0 && p < 100.0 => "> 99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// A count with its thousands apart.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A number with a true minus sign and no negative zero.
fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let digits = text.trim_start_matches('-');
    let zero = digits.chars().all(|c| c == '0' || c == '.');
    if text.starts_with('-') && !zero { format!("−{digits}") } else { digits.to_owned() }
}

/// Three significant digits, for figures whose size is not known beforehand.
pub(crate) fn significant(value: f64) -> String {
    let size = value.abs();
    let decimals = if size > 0.0 && size.is_finite() { (2.0 - size.log10().floor()).clamp(0.0, 9.0) as usize } else { 2 };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{PlanPose, Stamp};

    #[test]
    fn an_end_reads_like_this() {
        let pose = PlanPose::new(-1.204, 0.0, 1.6);
        let end = Estimate {
            stamp: Stamp(0),
            pose,
            covariance: nalgebra::Matrix3::zeros(),
            radius95_m: 0.5,
            probability: 1.0,
            status: Status::Tracking,
            scale: None,
        };
        assert_eq!(end_pose(&end), "(−1.20, 0.00) m ± 0.50 m (95 %), facing 92°");
    }

    #[test]
    fn small_and_large_scales_keep_their_digits() {
        let of = |metres_per_unit: f64| scale(&ScaleEstimate { metres_per_unit, relative_sigma: 0.051 });
        assert_eq!(of(0.00834), "1 unit of odometry = 0.00834 m ± 5 %");
        assert_eq!(of(12.34), "1 unit of odometry = 12.3 m ± 5 %");
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!([0, 999, 1000, 864_214, 1_000_000].map(grouped), ["0", "999", "1,000", "864,214", "1,000,000"]);
    }

    #[test]
    fn an_ambiguous_verdict_never_sounds_sure() {
        assert!(verdict(Status::Ambiguous, 0.99).contains("evidence for it is thin"));
        assert!(verdict(Status::Ambiguous, 0.5).contains("holds 50 %"));
    }

    #[test]
    fn shares_are_not_rounded_to_certainty() {
        assert_eq!([percent(0.999), percent(0.001), percent(0.5), percent(1.0), percent(0.0)], ["> 99 %", "< 1 %", "50 %", "100 %", "0 %"]);
    }
}

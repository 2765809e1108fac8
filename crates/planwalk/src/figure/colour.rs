//! Which colour says what? One place for all, so that the pictures of a run agree.

use planwalk_types::Status;

/// Walls.
pub(super) const WALL: &str = "#37474f";
/// Doorways.
pub(super) const DOOR: &str = "#d7ccc8";
/// Glass.
pub(super) const WINDOW: &str = "#81d4fa";
/// Floor inside the building.
pub(super) const FLOOR: &str = "#ffffff";
/// Outside, and what the plan does not know.
pub(super) const OUTSIDE: &str = "#e4e8ec";
/// Words.
pub(super) const INK: &str = "#263238";
/// Words of less weight.
pub(super) const FAINT_INK: &str = "#607d8b";
/// 95 % regions.
pub(super) const DOUBT: &str = "#3f51b5";
/// Where the walk began.
pub(super) const START: &str = "#2e7d32";
/// Where the walk ended.
pub(super) const END: &str = "#c62828";
/// Known truth, where there is one.
pub(super) const TRUTH: &str = "#000000";
/// A path by itself.
pub(super) const PATH: &str = "#1565c0";
/// Needles, dots and regions that go with it.
pub(super) const RED: &str = "#e53935";

/// From soon to never; darkness grows all along, so that it also reads in grey.
pub(super) const HEAT: [&str; 7] = ["#fff7bc", "#fee391", "#fec44f", "#fb8a3c", "#e34a33", "#b30000", "#4a0033"];

/// Other hypotheses, likeliest first; told apart also by those who see few colours.
pub(super) const OTHERS: [&str; 5] = ["#d81b60", "#ef6c00", "#6d4c41", "#8e24aa", "#546e7a"];

/// The colour of a verdict.
pub(super) fn of_status(status: Status) -> &'static str {
    match status {
        Status::Tracking => "#2e7d32",
        Status::Ambiguous => "#b26a00",
        Status::Lost => "#c62828",
    }
}

/// Early is dark violet, late is yellow; lightness rises all along, so that it also reads in grey.
const TIME: [(f64, f64, f64); 6] =
    [(66.0, 18.0, 110.0), (58.0, 76.0, 150.0), (30.0, 125.0, 145.0), (40.0, 168.0, 120.0), (130.0, 202.0, 60.0), (248.0, 210.0, 20.0)];

/// The colour of a moment, `share` of the way from the first to the last.
pub(super) fn of_time(share: f64) -> String {
    // What is not a number counts as the first moment.
    let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
    let at = share * (TIME.len() - 1) as f64;
    let low = (at as usize).min(TIME.len() - 2);
    let (a, b, t) = (TIME[low], TIME[low + 1], at - low as f64);
    let mix = |a: f64, b: f64| (a + t * (b - a)).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_grows_lighter() {
        let lightness = |share: f64| {
            let text = of_time(share);
            let channel = |i: usize| f64::from(u8::from_str_radix(&text[i..i + 2], 16).unwrap());
            0.30 * channel(1) + 0.59 * channel(3) + 0.11 * channel(5)
        };
        let all: Vec<f64> = (0..=20).map(|i| lightness(f64::from(i) / 20.0)).collect();
        assert!(all.windows(2).all(|w| w[1] > w[0]), "{all:?}");
        assert_eq!(of_time(f64::NAN), of_time(0.0));
    }
}

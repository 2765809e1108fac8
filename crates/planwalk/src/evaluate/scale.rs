//! How well were the metres in a unit of odometry known, at the end, along the walk, and did they collapse?
//!
//! A single camera's unit changes as it goes, so the truth is a figure a moment: the simulator's own, or what short chords of
//! the path and of the truth say ([`by_chords`]). Pitfall: small walks hit no walls, so a localiser without an anchor sinks to
//! ever smaller scales and is wrong with confidence; that is [`ScaleScores::collapsed`].

use planwalk_types::{Path, PlanPose, Stamp};
use serde::{Deserialize, Serialize};

use super::associate::{AssociateOptions, associate};
use super::curves::{Curves, Moment};
use super::statistics::quantile;

/// What is known of the scale, against the truth. Natural logarithms: 0.03 is 3 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScaleScores {
    /// |ln(estimated / true)| of the last causal answer.
    pub end_log_error: f64,
    /// Median of |ln(estimated / true)| over the smoothed track.
    pub track_log_error: f64,
    /// Smallest estimated / true of any causal answer.
    pub least_ratio: f64,
    /// Whether that falls under [`COLLAPSED`] after [`SETTLED_M`] of walking, or at the end of a shorter walk.
    pub collapsed: bool,
}

/// Estimated over true scale that is a collapse and no mere error.
pub const COLLAPSED: f64 = 0.6;
/// Metres of walking before which a small scale is one guess among many.
pub const SETTLED_M: f64 = 30.0;

/// Length of a chord, metres: long against the noise of a step, short against the drift of headings.
const CHORD_M: f64 = 2.0;
/// Metres of walking to each side of a moment whose chords are taken together.
const AROUND_M: f64 = 5.0;

/// Holds both answers against the true metres per unit, which are taken from the nearest moment of `truth`. `None` where nothing was
/// claimed or nothing is known.
pub fn score(curves: &Curves, truth: &[(Stamp, f64)]) -> Option<ScaleScores> {
    let ratios = |moments: &[Moment]| -> Vec<(f64, f64)> {
        let ratio = |m: &Moment| Some((m.distance_m, m.metres_per_unit? / true_at(truth, m.stamp)?));
        moments.iter().filter_map(ratio).filter(|(_, r)| *r > 0.0 && r.is_finite()).collect()
    };
    let (causal, track) = (ratios(&curves.filter), ratios(&curves.track));
    let (end_m, end) = *causal.last()?;
    let errors: Vec<f64> = track.iter().map(|(_, r)| r.ln().abs()).collect();
    let settled_m = SETTLED_M.min(end_m);
    Some(ScaleScores {
        end_log_error: end.ln().abs(),
        track_log_error: quantile(&errors, 0.5)?,
        least_ratio: causal.iter().map(|(_, r)| *r).fold(f64::INFINITY, f64::min),
        collapsed: causal.iter().any(|(walked_m, r)| *walked_m >= settled_m && *r < COLLAPSED),
    })
}

fn true_at(truth: &[(Stamp, f64)], stamp: Stamp) -> Option<f64> {
    let next = truth.partition_point(|(s, _)| *s < stamp);
    let near = truth.get(next.saturating_sub(1)).into_iter().chain(truth.get(next));
    near.min_by(|a, b| a.0.secs_since(stamp).abs().total_cmp(&b.0.secs_since(stamp).abs())).map(|(_, metres)| *metres)
}

/// Metres per unit of a path along its walk, from chords of the truth and of the path over the same times. Headings play no part, so
/// that an odometry which drifts by tens of metres has a scale all the same. Empty where nobody walks as far as a chord, or where
/// both share no time.
pub fn by_chords(path: &Path, truth: &[(Stamp, PlanPose)], options: &AssociateOptions) -> Vec<(Stamp, f64)> {
    let poses: Vec<_> = path.stamps().zip(path.poses()).collect();
    let [of_path, of_truth]: [Vec<Stamp>; 2] =
        [poses.iter().map(|(stamp, _)| *stamp).collect(), truth.iter().map(|(stamp, _)| *stamp).collect()];
    let Ok(matches) = associate(&of_path, &of_truth, options, 2) else { return Vec::new() };
    let both: Vec<_> = matches.iter().map(|m| (poses[m.estimate], m.on_plan(truth))).collect();
    let mut walked = vec![0.0];
    walked.extend(both.windows(2).scan(0.0, |sum, pair| {
        *sum += pair[0].1.origin().distance(pair[1].1.origin());
        Some(*sum)
    }));
    // The way from each moment to the first one a chord ahead, in metres and in units.
    let chord = |from: usize| {
        let to = walked.partition_point(|w| *w < walked[from] + CHORD_M);
        let (there, here) = (both.get(to)?, both[from]);
        Some((here.1.origin().distance(there.1.origin()), here.0.1.origin().distance(there.0.1.origin())))
    };
    let chords: Vec<Option<(f64, f64)>> = (0..both.len()).map(chord).collect();
    let around = |i: usize| {
        let low = walked.partition_point(|w| *w < walked[i] - AROUND_M);
        let high = walked.partition_point(|w| *w <= walked[i] + AROUND_M - CHORD_M).max(low);
        let sum = chords[low..high].iter().flatten().fold((0.0, 0.0), |sum, c| (sum.0 + c.0, sum.1 + c.1));
        (sum.1 > 0.0 && sum.0 > 0.0).then(|| (both[i].0.0, sum.0 / sum.1))
    };
    (0..both.len()).filter_map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::super::place::tests::walk;
    use super::super::{PlaceOptions, curves};
    use super::*;
    use planwalk_types::path::StepNoise;
    use planwalk_types::{Estimate, ScaleEstimate};

    /// Scores of a walk of a metre a moment with this scale at each moment, where one unit is two metres.
    fn scored(metres_per_unit: &[f64]) -> ScaleScores {
        let (track, truth) = walk(&vec![0.1; metres_per_unit.len()], 0.5);
        let known =
            |(e, m): (&Estimate, &f64)| Estimate { scale: Some(ScaleEstimate { metres_per_unit: *m, relative_sigma: 0.1 }), ..e.clone() };
        let track: Vec<Estimate> = track.iter().zip(metres_per_unit).map(known).collect();
        let curves = curves(&track, &track, &truth, &PlaceOptions::default()).unwrap();
        score(&curves, &truth.iter().map(|(stamp, _)| (*stamp, 2.0)).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_small_scale_at_the_beginning_is_no_collapse() {
        let mut scales = vec![2.0; 60];
        scales[10] = 0.5;
        let early = scored(&scales);
        assert!(!early.collapsed && (early.least_ratio - 0.25).abs() < 1e-12 && early.end_log_error < 1e-12, "{early:?}");
        scales[40] = 1.1;
        assert!(scored(&scales).collapsed);
        assert!(scored(&[2.0, 2.0, 1.0]).collapsed, "a short walk is judged by its end");
    }

    #[test]
    fn three_per_cent_off_is_said_so() {
        let off = scored(&[2.06; 20]);
        assert!((off.end_log_error - 1.03f64.ln()).abs() < 1e-12 && (off.track_log_error - 1.03f64.ln()).abs() < 1e-12);
        let (track, truth) = walk(&[0.1; 5], 0.5);
        let silent = curves(&track, &track, &truth, &PlaceOptions::default()).unwrap();
        assert_eq!(score(&silent, &[(Stamp(0), 2.0)]), None, "who claims nothing has no scores");
    }

    #[test]
    fn chords_see_the_unit_change_though_headings_drift() {
        // 40 m straight ahead, a unit of 2 m that becomes 2.5 m half way, and a heading that turns by 2° a metre.
        let stamp = |i: usize| Stamp(i as i64 * 200_000_000);
        let truth: Vec<_> = (0..=160).map(|i| (stamp(i), PlanPose::new(0.25 * i as f64, 0.0, 0.0))).collect();
        let unit = |i: usize| if i < 80 { 2.0 } else { 2.5 };
        let step = |i: usize| StepNoise::default().step(stamp(i), stamp(i + 1), 0.25 / unit(i), 0.0, 0.5f64.to_radians());
        let found = by_chords(&Path { steps: (0..160).map(step).collect() }, &truth, &AssociateOptions::default());
        assert_eq!(found.len(), 161);
        // A chord of an arc of 4° is shorter by 4²/24 rad² = 0.02 %.
        assert!((found[0].1 / 2.0 - 1.0).abs() < 1e-3 && (found[160].1 / 2.5 - 1.0).abs() < 1e-3, "{:?}", [found[0], found[160]]);
        assert!(found[80].1 > 2.1 && found[80].1 < 2.4);
        assert!(by_chords(&Path::default(), &truth, &AssociateOptions::default()).is_empty());
        let standing: Vec<_> = truth.iter().map(|(s, _)| (*s, PlanPose::new(1.0, 1.0, 0.0))).collect();
        assert!(by_chords(&Path { steps: (0..160).map(step).collect() }, &standing, &AssociateOptions::default()).is_empty());
    }
}

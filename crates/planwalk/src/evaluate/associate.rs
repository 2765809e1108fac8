//! Which moment of the truth goes with which moment of the estimate?
//!
//! As evo does it: each moment of the shorter list takes the nearest of the longer one, the earlier where two are as near.
//! Where the truth is interpolated, each moment of the estimate takes the truth of its very time instead.

use nalgebra::{Isometry3, Translation3};
use planwalk_types::{PlanPose, Rigid3, Stamp, wrap_angle};

use super::EvaluateError;

/// How moments are brought together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssociateOptions {
    /// Most seconds between an estimate and its true pose. The default is 0.01 s, as evo's.
    pub max_diff_s: f64,
    /// Interpolates the truth between two poses at most this many seconds apart; `None` takes the nearest pose. For a truth that
    /// was clicked once a second: 1.5.
    pub max_gap_s: Option<f64>,
    /// Seconds that are added to the estimate's stamps.
    pub time_offset_s: f64,
}

impl Default for AssociateOptions {
    fn default() -> Self {
        Self { max_diff_s: 0.01, max_gap_s: None, time_offset_s: 0.0 }
    }
}

/// A moment of the estimate and the truth there: `share` of the way from one true pose to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Which estimate.
    pub estimate: usize,
    /// Which true pose is at or before it (or nearest).
    pub before: usize,
    /// Which true pose is after it; the same where nothing is interpolated.
    pub after: usize,
    /// 0..=1 from `before` to `after`.
    pub share: f64,
}

impl Match {
    fn at(estimate: usize, truth: usize) -> Self {
        Self { estimate, before: truth, after: truth, share: 0.0 }
    }

    /// The true pose on the plan: straight between two, the heading the shorter way round.
    pub fn on_plan(&self, truth: &[(Stamp, PlanPose)]) -> PlanPose {
        let (a, b) = (truth[self.before].1, truth[self.after].1);
        let t = self.share;
        PlanPose::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.heading_rad + t * wrap_angle(b.heading_rad - a.heading_rad))
    }

    /// The true pose in space: straight between two, turned about one axis.
    pub fn in_space<A, B>(&self, truth: &[(Stamp, Rigid3<A, B>)]) -> Rigid3<A, B> {
        let (a, b) = (truth[self.before].1.iso, truth[self.after].1.iso);
        if self.before == self.after {
            return Rigid3::new(a);
        }
        let at = a.translation.vector.lerp(&b.translation.vector, self.share);
        // Half a turn has no shorter way round: the nearer end is taken.
        let nearer = if self.share < 0.5 { a.rotation } else { b.rotation };
        let turn = a.rotation.try_slerp(&b.rotation, self.share, 1e-9).unwrap_or(nearer);
        Rigid3::new(Isometry3::from_parts(Translation3::from(at), turn))
    }
}

/// Brings the moments of an estimate and of the truth together, in time order; at least `need` pairs.
///
/// # Errors
/// [`EvaluateError`]: too few poses, stamps that go back, no common time, too few pairs, options out of range.
pub fn associate(estimate: &[Stamp], truth: &[Stamp], options: &AssociateOptions, need: usize) -> Result<Vec<Match>, EvaluateError> {
    let bad = |name, value, must| EvaluateError::BadOption { name, value, must };
    if !(options.max_diff_s >= 0.0 && options.max_diff_s.is_finite()) {
        return Err(bad("--max-diff", options.max_diff_s, "it must be a number of seconds, 0 or more"));
    }
    if let Some(gap) = options.max_gap_s.filter(|gap| !(*gap > 0.0 && gap.is_finite())) {
        return Err(bad("--interpolate-truth", gap, "it must be a number of seconds above 0"));
    }
    let offset = Stamp::from_secs(options.time_offset_s)
        .ok_or_else(|| bad("--time-offset", options.time_offset_s, "it must be a number of seconds"))?;
    check("track", estimate)?;
    check("truth", truth)?;
    let shifted: Vec<Stamp> = estimate.iter().map(|s| Stamp(s.0.saturating_add(offset.0))).collect();
    no_gulf(&shifted, truth, options)?;
    let pairs = match options.max_gap_s {
        Some(gap_s) => between(&shifted, truth, gap_s, options.max_diff_s),
        None => nearest_pairs(&shifted, truth, options.max_diff_s),
    };
    if pairs.len() < need {
        let nearest_s = shifted.iter().map(|s| truth[nearest(truth, *s)].secs_since(*s).abs()).fold(f64::INFINITY, f64::min);
        return Err(EvaluateError::TooFewPairs { got: pairs.len(), need, nearest_s, max_diff_s: options.max_diff_s });
    }
    Ok(pairs)
}

fn check(what: &'static str, stamps: &[Stamp]) -> Result<(), EvaluateError> {
    if stamps.len() < 2 {
        return Err(EvaluateError::TooFewPoses { what, got: stamps.len() });
    }
    match stamps.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(i) => Err(EvaluateError::StampsGoBack { what, index: i + 1, at_s: stamps[i + 1].as_secs() }),
        None => Ok(()),
    }
}

/// Refuses two spans of time that do not touch.
fn no_gulf(track: &[Stamp], truth: &[Stamp], options: &AssociateOptions) -> Result<(), EvaluateError> {
    let [track_from, track_to] = [track[0], track[track.len() - 1]];
    let [truth_from, truth_to] = [truth[0], truth[truth.len() - 1]];
    let gulf_s = truth_from.secs_since(track_to).max(track_from.secs_since(truth_to));
    if gulf_s <= options.max_diff_s {
        return Ok(());
    }
    Err(EvaluateError::NoOverlap {
        truth_from_s: truth_from.as_secs(),
        truth_to_s: truth_to.as_secs(),
        track_from_s: track_from.as_secs(),
        track_to_s: track_to.as_secs(),
        offset_s: options.time_offset_s + truth_from.secs_since(track_from),
    })
}

fn nearest_pairs(track: &[Stamp], truth: &[Stamp], max_diff_s: f64) -> Vec<Match> {
    let near = |a: Stamp, b: Stamp| a.secs_since(b).abs() <= max_diff_s;
    if track.len() > truth.len() {
        let of_truth = |(i, t): (usize, &Stamp)| (nearest(track, *t), i);
        let pairs = truth.iter().enumerate().map(of_truth);
        return pairs.filter(|(e, t)| near(track[*e], truth[*t])).map(|(e, t)| Match::at(e, t)).collect();
    }
    let of_track = |(i, t): (usize, &Stamp)| (i, nearest(truth, *t));
    track.iter().enumerate().map(of_track).filter(|(e, t)| near(track[*e], truth[*t])).map(|(e, t)| Match::at(e, t)).collect()
}

/// Index of the nearest stamp, the earlier of two as near. There is at least one stamp.
fn nearest(stamps: &[Stamp], at: Stamp) -> usize {
    let later = stamps.partition_point(|s| *s <= at).min(stamps.len() - 1);
    let earlier = later.saturating_sub(1);
    if at.secs_since(stamps[earlier]).abs() <= stamps[later].secs_since(at).abs() { earlier } else { later }
}

/// Truth at each moment of the track, between neighbours at most `gap_s` apart; else the nearest within `max_diff_s`.
fn between(track: &[Stamp], truth: &[Stamp], gap_s: f64, max_diff_s: f64) -> Vec<Match> {
    let find = |(i, at): (usize, &Stamp)| {
        let after = truth.partition_point(|s| *s < *at);
        if after > 0 && after < truth.len() {
            let span_s = truth[after].secs_since(truth[after - 1]);
            if span_s <= gap_s {
                let share = at.secs_since(truth[after - 1]) / span_s;
                return Some(Match { estimate: i, before: after - 1, after, share });
            }
        }
        let near = nearest(truth, *at);
        (truth[near].secs_since(*at).abs() <= max_diff_s).then(|| Match::at(i, near))
    };
    track.iter().enumerate().filter_map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(seconds: &[f64]) -> Vec<Stamp> {
        seconds.iter().map(|s| Stamp::from_secs(*s).unwrap()).collect()
    }

    fn pairs(track: &[f64], truth: &[f64], options: &AssociateOptions) -> Vec<(usize, usize)> {
        let found = associate(&stamps(track), &stamps(truth), options, 0).unwrap();
        found.iter().map(|m| (m.estimate, m.before)).collect()
    }

    #[test]
    fn the_shorter_list_takes_the_nearest_of_the_longer() {
        let options = AssociateOptions { max_diff_s: 0.3, ..AssociateOptions::default() };
        assert_eq!(pairs(&[0.0, 1.0, 2.0, 9.0], &[0.1, 0.9, 1.2, 2.4, 3.0], &options), [(0, 0), (1, 1)]);
        assert_eq!(pairs(&[0.1, 0.9, 1.2, 2.4, 3.0], &[0.0, 1.0, 2.2], &options), [(0, 0), (1, 1), (3, 2)]);
        assert_eq!(pairs(&[0.5, 5.0], &[0.25, 0.75], &options), [(0, 0)], "the earlier of two as near");
    }

    #[test]
    fn a_coarse_truth_is_interpolated_but_not_over_its_gaps() {
        let options = AssociateOptions { max_gap_s: Some(1.5), ..AssociateOptions::default() };
        let track = stamps(&[0.0, 0.25, 1.0, 3.0, 4.0, 4.5]);
        let truth = stamps(&[0.0, 1.0, 4.0, 5.0]);
        let found = associate(&track, &truth, &options, 2).unwrap();
        assert_eq!(found.iter().map(|m| m.estimate).collect::<Vec<_>>(), [0, 1, 2, 4, 5], "3 s lies in a gap of 3 s");
        assert_eq!((found[1].before, found[1].after, found[1].share), (0, 1, 0.25));
        let poses: Vec<_> = truth.iter().zip([3.0, -3.0, 0.0, 0.0]).map(|(s, h)| (*s, PlanPose::new(s.as_secs(), 0.0, h))).collect();
        let pose = found[1].on_plan(&poses);
        let expected = 3.0 + 0.25 * (std::f64::consts::TAU - 6.0);
        assert!((pose.x - 0.25).abs() < 1e-12 && wrap_angle(pose.heading_rad - expected).abs() < 1e-12, "the shorter way round: {pose:?}");
    }

    #[test]
    fn another_clock_is_recognised_and_named() {
        let track = stamps(&[0.0, 1.0, 2.0]);
        let truth = stamps(&[1761.0, 1762.0, 1763.0]);
        let message = associate(&track, &truth, &AssociateOptions::default(), 2).unwrap_err().to_string();
        assert!(message.contains("1761.000 to 1763.000") && message.contains("--time-offset 1761.000"), "{message}");
        let options = AssociateOptions { time_offset_s: 1761.0, ..AssociateOptions::default() };
        assert_eq!(associate(&track, &truth, &options, 3).unwrap().len(), 3);
    }

    #[test]
    fn what_cannot_be_paired_says_why() {
        let of = |track: &[f64], truth: &[f64], options: &AssociateOptions| associate(&stamps(track), &stamps(truth), options, 2);
        let usual = AssociateOptions::default();
        assert!(matches!(of(&[0.0], &[0.0, 1.0], &usual), Err(EvaluateError::TooFewPoses { what: "track", got: 1 })));
        assert!(matches!(of(&[0.0, 1.0], &[], &usual), Err(EvaluateError::TooFewPoses { what: "truth", got: 0 })));
        assert!(matches!(of(&[0.0, 2.0, 1.0], &[0.0, 1.0], &usual), Err(EvaluateError::StampsGoBack { index: 2, .. })));
        let apart = of(&[0.4, 1.4], &[0.0, 1.0, 2.0], &usual).unwrap_err();
        assert!(apart.to_string().contains("0.400 s apart"), "{apart}");
        for options in [
            AssociateOptions { max_diff_s: f64::NAN, ..usual },
            AssociateOptions { max_gap_s: Some(0.0), ..usual },
            AssociateOptions { time_offset_s: f64::INFINITY, ..usual },
        ] {
            assert!(matches!(of(&[0.0, 1.0], &[0.0, 1.0], &options), Err(EvaluateError::BadOption { .. })));
        }
    }
}

//! When did the answer come, did it stay, and how long was it sure and wrong? What a walk shows to whoever follows it live.

use planwalk_types::{Stamp, Status};
use serde::{Deserialize, Serialize};

use super::curves::Moment;
use super::place::{AnswerScores, PlaceOptions, answer};
use super::statistics::{quantile, share};

/// The causal answer: as an answer, and when it came.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CausalScores {
    /// Errors and honesty.
    pub errors: AnswerScores,
    /// From when on it stays within [`PlaceOptions::right_m`]; `None` if it never does.
    pub converged_right: Option<Convergence>,
    /// From when on it stays within [`PlaceOptions::wrong_m`].
    pub converged_near: Option<Convergence>,
    /// Whether it stays right from a given distance on: each pair of [`STAYS_M`].
    #[serde(default)]
    pub stays: Vec<Stay>,
    /// Share of the moments that claim to be tracking while more than [`PlaceOptions::wrong_m`] off.
    pub false_confidence: f64,
    /// Longest such stretch, seconds.
    pub false_confidence_longest_s: f64,
    /// Share of the moments whose status is `tracking`.
    pub tracking: f64,
    /// Share of the moments whose status is `ambiguous`.
    pub ambiguous: f64,
    /// Share of the moments whose status is `lost`.
    pub lost: f64,
    /// Status at the last compared moment.
    pub end_status: Status,
}

/// From when on an answer is right and stays so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Metres.
    pub within_m: f64,
    /// Metres walked until then.
    pub distance_m: f64,
    /// Seconds until then.
    pub time_s: f64,
}

/// Whether every answer is right from so many metres walked to the end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stay {
    /// Largest error, metres.
    pub within_m: f64,
    /// Metres walked from which it counts.
    pub from_m: f64,
    /// Whether no later answer is farther off. Of a shorter walk: whether the last one is not.
    pub holds: bool,
    /// Median error from there on, metres.
    pub median_m: f64,
}

/// How a walker was found who was carried elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KidnapScores {
    /// Metres walked until then.
    pub after_m: f64,
    /// Error at the last moment before, metres.
    pub before_m: f64,
    /// Metres and seconds since then from which on the answer stays within [`PlaceOptions::right_m`]; `None` if it never does.
    pub found_again: Option<Convergence>,
}

/// Errors and distances of [`CausalScores::stays`], metres: a laser, a room, a clip, a walk, a phone's steps.
pub const STAYS_M: [(f64, f64); 5] = [(0.2, 5.0), (1.0, 5.0), (1.0, 30.0), (1.0, 40.0), (2.0, 60.0)];

/// The scores of an answer that knows no future; `None` where there is none.
pub(super) fn causal(moments: &[Moment], options: &PlaceOptions) -> Option<CausalScores> {
    let is = |status: Status| share(moments.iter().map(|m| m.status == status));
    let falsely = |m: &Moment| m.status == Status::Tracking && m.error_m > options.wrong_m;
    Some(CausalScores {
        errors: answer(moments, options)?,
        converged_right: convergence(moments, options.right_m),
        converged_near: convergence(moments, options.wrong_m),
        stays: STAYS_M.iter().filter_map(|(within_m, from_m)| stay(moments, *within_m, *from_m)).collect(),
        false_confidence: share(moments.iter().map(falsely)),
        false_confidence_longest_s: longest_s(moments, &falsely),
        tracking: is(Status::Tracking),
        ambiguous: is(Status::Ambiguous),
        lost: is(Status::Lost),
        end_status: moments.last()?.status,
    })
}

fn convergence(moments: &[Moment], within_m: f64) -> Option<Convergence> {
    let from = moments.iter().rposition(|m| !(m.error_m <= within_m)).map_or(0, |last_off| last_off + 1);
    let (first, then) = (moments.first()?, moments.get(from)?);
    Some(Convergence { within_m, distance_m: then.distance_m, time_s: then.stamp.secs_since(first.stamp) })
}

fn stay(moments: &[Moment], within_m: f64, from_m: f64) -> Option<Stay> {
    let from = moments.partition_point(|m| m.distance_m < from_m).min(moments.len().checked_sub(1)?);
    let errors: Vec<f64> = moments[from..].iter().map(|m| m.error_m).collect();
    Some(Stay { within_m, from_m, holds: errors.iter().all(|e| *e <= within_m), median_m: quantile(&errors, 0.5)? })
}

/// How soon the place is right again after the walker was carried elsewhere; `None` where no moment is left to tell.
pub(super) fn found_again(moments: &[Moment], carried_at: Stamp, right_m: f64) -> Option<KidnapScores> {
    let split = moments.partition_point(|m| m.stamp < carried_at);
    let (before, after) = moments.split_at(split);
    let (last, first) = (before.last()?, after.first()?);
    let since = |found: Convergence| Convergence { distance_m: found.distance_m - first.distance_m, ..found };
    Some(KidnapScores { after_m: first.distance_m, before_m: last.error_m, found_again: convergence(after, right_m).map(since) })
}

/// Longest time without a break in which `holds`; a moment lasts until the next one.
fn longest_s(moments: &[Moment], holds: &dyn Fn(&Moment) -> bool) -> f64 {
    let (mut longest, mut since) = (0.0f64, None);
    for (i, moment) in moments.iter().enumerate() {
        if !holds(moment) {
            since = None;
            continue;
        }
        let from = *since.get_or_insert(moment.stamp);
        let until = moments.get(i + 1).unwrap_or(moment).stamp;
        longest = longest.max(until.secs_since(from));
    }
    longest
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::place::tests::{scored, walk};
    use super::super::{CausalScores, PlaceOptions, place};
    use planwalk_types::PlanPose;

    /// Scores of an answer that is nowhere near.
    pub fn never_right() -> CausalScores {
        scored(&[9.0, 9.0, 9.0], 0.5).filter.unwrap()
    }

    #[test]
    fn convergence_counts_from_where_the_answer_stays_right() {
        let scores = scored(&[5.0, 0.5, 3.0, 1.5, 0.4, 0.2], 0.5);
        let filter = scores.filter.unwrap();
        assert_eq!(filter.converged_right.map(|c| (c.distance_m, c.time_s)), Some((4.0, 4.0)));
        assert_eq!(filter.converged_near.map(|c| c.distance_m), Some(3.0));
        let never = scored(&[0.1, 0.1, 1.2], 0.5).filter.unwrap();
        assert_eq!((never.converged_right, never.converged_near.map(|c| c.distance_m)), (None, Some(0.0)));
        assert!(!never.errors.end_right && (never.errors.end_m - 1.2).abs() < 1e-12);
    }

    #[test]
    fn staying_right_allows_no_slip_after_the_distance_and_any_before() {
        // A metre a moment.
        let of = |slip: usize| {
            let off: Vec<f64> = (0..=70).map(|i| if i == slip { 1.5 } else { 0.1 }).collect();
            let stays = scored(&off, 0.5).filter.unwrap().stays;
            stays.iter().map(|s| s.holds).collect::<Vec<_>>()
        };
        assert_eq!(of(29), [false, false, true, true, true]);
        assert_eq!(of(30), [false, false, false, true, true], "30 m walked count");
        assert_eq!(of(70), [false, false, false, false, true]);
        assert_eq!(of(4), [true; 5]);
        let median = scored(&[9.0, 9.0, 9.0, 9.0, 9.0, 0.5, 0.1, 0.3], 0.5).filter.unwrap().stays[1].median_m;
        assert!((median - 0.3).abs() < 1e-12, "{median}");
    }

    #[test]
    fn a_walk_that_ends_before_the_distance_is_judged_by_its_end() {
        let of = |off: &[f64]| scored(off, 0.5).filter.unwrap().stays[2];
        assert!(of(&[9.0, 9.0, 0.5]).holds && !of(&[0.1, 0.1, 1.5]).holds);
        assert_eq!(of(&[9.0, 9.0, 0.5]).median_m, 0.5);
    }

    #[test]
    fn confidence_that_is_false_is_told_with_its_longest_stretch() {
        let filter = scored(&[5.0, 5.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.5).filter.unwrap();
        assert_eq!((filter.false_confidence, filter.false_confidence_longest_s), (0.25, 1.0));
        assert_eq!((filter.tracking, filter.ambiguous, filter.lost), (0.5, 0.5, 0.0));
    }

    #[test]
    fn who_is_carried_is_found_again_by_metres_walked_since() {
        let (mut track, mut truth) = walk(&[0.1; 12], 0.5);
        // Carried 40 m to the side at 6 s; the answer follows at 9 s.
        for (_, pose) in &mut truth[6..] {
            *pose = PlanPose::new(pose.x, 40.0, 0.0);
        }
        for estimate in &mut track[9..] {
            estimate.pose = PlanPose::new(estimate.pose.x, 40.1, 0.1);
        }
        let carried = PlaceOptions { carried_at: Some(truth[6].0), ..PlaceOptions::default() };
        let scores = place::score(&track, &track, &truth, &carried).unwrap();
        let kidnap = scores.kidnap.unwrap();
        assert_eq!(kidnap.found_again.map(|f| (f.distance_m, f.time_s)), Some((3.0, 3.0)));
        assert!((kidnap.after_m - 5.0).abs() < 1e-9 && (kidnap.before_m - 0.1).abs() < 1e-9, "{kidnap:?}");
        assert!((scores.length_m - 10.0).abs() < 1e-9, "being carried is not walking: {} m", scores.length_m);
        let unmoved = place::score(&track[..9], &track[..9], &truth, &carried).unwrap();
        assert_eq!(unmoved.kidnap.unwrap().found_again, None);
    }
}

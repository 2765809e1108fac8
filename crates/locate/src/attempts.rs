//! Do independent filters agree? Several runs over one walk, merged into one answer.
//!
//! A filter starts with a million guesses and ends with thousands: now and then the right one is thinned out while another
//! place looks as good, and nothing brings it back. Another run, with other draws, makes another mistake, if any. What each
//! run's best track explains of the whole walk then says which is right, and how sure that is.

use planwalk_types::{Hypothesis, Status, wrap_angle};

use crate::run::Localization;
use crate::verdict::VerdictOptions;

/// One run and which it was.
#[derive(Debug, Clone)]
pub(crate) struct Attempt {
    pub index: usize,
    pub found: Localization,
}

impl Attempt {
    fn score(&self) -> f64 {
        self.found.quality.score_nats
    }
}

/// Tracks are the same place when they stay this close, metres, at both ends and in the middle.
const SAME_M: f64 = 1.5;
/// And look the same way within 30°.
const SAME_RAD: f64 = 0.52;

fn same(a: &Hypothesis, b: &Hypothesis) -> bool {
    if a.track.is_empty() || a.track.len() != b.track.len() {
        return false;
    }
    [0, a.track.len() / 2, a.track.len() - 1].iter().all(|i| {
        let (p, q) = (&a.track[*i].1, &b.track[*i].1);
        p.origin().distance(q.origin()) < SAME_M && wrap_angle(p.heading_rad - q.heading_rad).abs() < SAME_RAD
    })
}

fn agree(a: &Attempt, b: &Attempt) -> bool {
    match (a.found.hypotheses.first(), b.found.hypotheses.first()) {
        (Some(p), Some(q)) => same(p, q),
        _ => false,
    }
}

/// The run whose best track explains most.
fn best(runs: &[Attempt]) -> Option<&Attempt> {
    runs.iter().max_by(|a, b| a.score().total_cmp(&b.score()).then(b.index.cmp(&a.index)))
}

/// Whether the run's track both goes through walls and sees through them: a plan may lie, but so may the place.
fn contradicted(run: &Attempt, options: &VerdictOptions) -> bool {
    run.found.quality.wall_crossings > 0 && run.found.quality.seen_through_walls > options.through
}

fn confirmed(top: &Attempt, runs: &[Attempt]) -> bool {
    runs.iter().any(|r| r.index != top.index && agree(top, r))
}

/// Whether the best run is confirmed by another and nothing speaks against it: no further one is needed.
pub(crate) fn settled(runs: &[Attempt], options: &VerdictOptions) -> bool {
    best(runs).is_some_and(|top| confirmed(top, runs) && !contradicted(top, options))
}

/// One answer from all runs: the best run's track; every place that any run found, weighed by what its run's track explains.
///
/// Where no other run confirms the best one, or a rival explains nearly as much, or the track both crosses walls and sees
/// through them, the answer is not `tracking`.
pub(crate) fn merge(runs: Vec<Attempt>, options: &VerdictOptions) -> Option<Localization> {
    let count = runs.len();
    let filter = runs.first()?.found.filter.clone();
    let top = best(&runs)?.clone();
    let confirmed = count == 1 || confirmed(&top, &runs);
    let contradicted = contradicted(&top, options);
    let mut found = top.found.clone();
    let weight_of = |run: &Attempt| libm::exp((run.score() - top.score()).max(-700.0));
    let mut total = 1.0;
    for run in runs.iter().filter(|r| r.index != top.index) {
        let fresh = run.found.hypotheses.iter().filter(|h| !top.found.hypotheses.iter().any(|known| same(known, h)));
        for hypothesis in fresh {
            if found.hypotheses.iter().any(|known| same(known, hypothesis)) {
                continue;
            }
            let mut added = hypothesis.clone();
            added.probability *= weight_of(run);
            total += added.probability;
            found.hypotheses.push(added);
        }
    }
    for hypothesis in &mut found.hypotheses {
        hypothesis.probability /= total;
    }
    found.hypotheses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    // A place of another run stays in the list however small: it was somebody's best guess. Six are enough to look at.
    found.hypotheses.truncate(6);
    let share = found.hypotheses.first().map_or(0.0, |h| h.probability);
    if found.status == Status::Tracking && (!confirmed || contradicted || share < options.mass) {
        found.status = Status::Ambiguous;
    }
    for estimate in &mut found.track {
        (estimate.status, estimate.probability) = (found.status, share);
    }
    found.filter = filter;
    found.quality.attempts = count;
    found.quality.attempt = top.index;
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Quality;
    use nalgebra::Matrix3;
    use planwalk_types::{Estimate, PlanPose, ScaleEstimate, Stamp};

    fn attempt(index: usize, x: f64, score_nats: f64, status: Status) -> Attempt {
        let scale = ScaleEstimate { metres_per_unit: 1.0, relative_sigma: 0.1 };
        let track: Vec<_> = (0..5).map(|i| (Stamp(i), PlanPose::new(x + i as f64, 0.0, 0.0))).collect();
        let pose = track[4].1;
        let covariance = Matrix3::identity();
        let estimate = Estimate { stamp: Stamp(4), pose, covariance, radius95_m: 1.0, probability: 1.0, status, scale: Some(scale) };
        let hypothesis = Hypothesis { probability: 1.0, pose, covariance, radius95_m: 1.0, scale, track };
        let quality = Quality { score_nats, ..Quality::default() };
        let (filter, track) = (vec![estimate.clone()], vec![estimate]);
        Attempt {
            index,
            found: Localization {
                filter,
                track,
                hypotheses: vec![hypothesis],
                status,
                scale,
                quality,
                contradicted: Vec::new(),
                apart: Vec::new(),
            },
        }
    }

    #[test]
    fn a_track_through_walls_is_tried_again_and_not_believed() {
        let through = |index: usize| {
            let mut run = attempt(index, 0.0, 50.0, Status::Tracking);
            (run.found.quality.wall_crossings, run.found.quality.seen_through_walls) = (2, 0.12);
            run
        };
        let runs = vec![through(0), through(1)];
        assert!(!settled(&runs, &VerdictOptions::default()));
        assert_eq!(merge(runs, &VerdictOptions::default()).unwrap().status, Status::Ambiguous);
    }

    #[test]
    fn two_runs_that_agree_settle_it() {
        let settled = |runs: &[Attempt]| settled(runs, &VerdictOptions::default());
        let runs = vec![attempt(0, 0.0, 50.0, Status::Tracking), attempt(1, 0.2, 51.0, Status::Tracking)];
        assert!(settled(&runs) && !settled(&runs[..1]));
        let found = merge(runs, &VerdictOptions::default()).unwrap();
        assert_eq!((found.status, found.hypotheses.len(), found.quality.attempt), (Status::Tracking, 1, 1));
    }

    #[test]
    fn a_better_run_wins_and_the_other_place_is_still_named() {
        let settled = |runs: &[Attempt]| settled(runs, &VerdictOptions::default());
        let runs =
            vec![attempt(0, 9.0, 20.0, Status::Tracking), attempt(1, 0.0, 60.0, Status::Tracking), attempt(2, 0.1, 59.0, Status::Tracking)];
        assert!(!settled(&runs[..2]) && settled(&runs));
        let found = merge(runs, &VerdictOptions::default()).unwrap();
        assert_eq!(found.status, Status::Tracking);
        assert!(found.track[0].pose.x < 5.0 && found.hypotheses.len() == 2 && found.hypotheses[1].probability < 1e-10);
        assert!(found.filter[0].pose.x > 5.0, "what was known at each moment is the first run's");
    }

    #[test]
    fn rivals_that_explain_as_much_are_ambiguous_and_an_unconfirmed_place_too() {
        let equals =
            vec![attempt(0, 9.0, 50.0, Status::Tracking), attempt(1, 0.0, 50.5, Status::Tracking), attempt(2, 0.0, 50.2, Status::Tracking)];
        let found = merge(equals, &VerdictOptions::default()).unwrap();
        assert_eq!(found.status, Status::Ambiguous);
        assert!((found.hypotheses.iter().map(|h| h.probability).sum::<f64>() - 1.0).abs() < 1e-9);
        let alone = vec![attempt(0, 9.0, 10.0, Status::Tracking), attempt(1, 0.0, 50.0, Status::Tracking)];
        assert_eq!(merge(alone, &VerdictOptions::default()).unwrap().status, Status::Ambiguous);
        assert!(merge(Vec::new(), &VerdictOptions::default()).is_none());
    }
}

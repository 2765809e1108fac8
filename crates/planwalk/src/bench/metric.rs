//! Which numbers of a run are put into tables, and which way is better?

use planwalk_types::Status;

use super::record::Record;
use crate::evaluate::place::Calibration;
use crate::evaluate::{CausalScores, PlaceScores, Stay};

/// How the values of many walks become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Share of the walks for which it holds: values are 0 or 1.
    Share,
    /// Mean over walks.
    Mean,
    /// Median over walks; "never" is infinite.
    Median,
}

/// One column.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Head of the column, with its unit.
    pub head: &'static str,
    /// How many walks become one number.
    pub kind: Kind,
    /// Whether more is better.
    pub higher_is_better: bool,
    /// What the value is multiplied with for people: 100 for per cent.
    pub factor: f64,
    /// Digits after the point.
    pub decimals: usize,
    /// Whether it has a panel in the picture.
    pub drawn: bool,
    /// Whether it is a column only of benches that ask for it.
    pub extra: bool,
    /// The value of one run; `None` where it has none.
    pub of: fn(&Record) -> Option<f64>,
}

impl Metric {
    const fn new(head: &'static str, kind: Kind, of: fn(&Record) -> Option<f64>) -> Self {
        Self { head, kind, higher_is_better: false, factor: 1.0, decimals: 2, drawn: false, extra: false, of }
    }

    const fn percent(self) -> Self {
        Self { factor: 100.0, decimals: 0, ..self }
    }

    const fn higher(self) -> Self {
        Self { higher_is_better: true, ..self }
    }

    const fn drawn(self) -> Self {
        Self { drawn: true, ..self }
    }

    const fn extra(self) -> Self {
        Self { extra: true, ..self }
    }

    const fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }
}

/// The columns, in order. A record shows those that it has. A new metric goes to the end of its part, extra unless every
/// bench should show it.
pub const METRICS: &[Metric] = &[
    Metric::new("end right %", Kind::Share, |r| flag(place(r)?.track.end_right)).percent().higher().drawn(),
    Metric::new("tracking %", Kind::Share, |r| place(r).and(flag(r.status? == Status::Tracking))).percent().higher(),
    Metric::new("wrong yet tracking %", Kind::Share, |r| flag(r.status? == Status::Tracking && !place(r)?.track.end_right))
        .percent()
        .drawn(),
    Metric::new("track median m", Kind::Median, |r| Some(place(r)?.track.median_m)).drawn(),
    Metric::new("track end m", Kind::Median, |r| Some(place(r)?.track.end_m)),
    Metric::new("causal < 1 m after m", Kind::Median, |r| Some(causal(r)?.converged_right.map_or(f64::INFINITY, |c| c.distance_m)))
        .decimals(0)
        .drawn(),
    Metric::new("causal recall 1 m %", Kind::Mean, |r| {
        causal(r)?.errors.recall.iter().find(|recall| recall.within_m == 1.0).map(|recall| recall.of_moments)
    })
    .percent()
    .higher(),
    // From how many metres on the causal answer is right, and stays so.
    Metric::new("< 0.2 m from 5 m on %", Kind::Share, |r| flag(stay(r, 0.2, 5.0)?.holds)).percent().higher().extra(),
    Metric::new("< 1 m from 5 m on %", Kind::Share, |r| flag(stay(r, 1.0, 5.0)?.holds)).percent().higher().extra(),
    Metric::new("< 1 m from 30 m on %", Kind::Share, |r| flag(stay(r, 1.0, 30.0)?.holds)).percent().higher().extra(),
    Metric::new("< 1 m from 40 m on %", Kind::Share, |r| flag(stay(r, 1.0, 40.0)?.holds)).percent().higher().extra(),
    Metric::new("< 2 m from 60 m on %", Kind::Share, |r| flag(stay(r, 2.0, 60.0)?.holds)).percent().higher().extra(),
    Metric::new("median from 5 m on m", Kind::Median, |r| Some(stay(r, 1.0, 5.0)?.median_m)).extra(),
    Metric::new("median from 30 m on m", Kind::Median, |r| Some(stay(r, 1.0, 30.0)?.median_m)).extra(),
    Metric::new("median from 60 m on m", Kind::Median, |r| Some(stay(r, 2.0, 60.0)?.median_m)).extra(),
    Metric::new("right at last %", Kind::Share, |r| flag(causal(r)?.converged_right.is_some())).percent().higher().extra(),
    Metric::new("found again after m", Kind::Median, again_m).decimals(0).extra(),
    Metric::new("found again in 15 m %", Kind::Share, |r| flag(again_m(r)? <= 15.0)).percent().higher().extra(),
    // Doubt.
    Metric::new("false confidence %", Kind::Mean, |r| Some(causal(r)?.false_confidence)).percent().decimals(1),
    Metric::new("ever sure and wrong %", Kind::Share, |r| flag(causal(r)?.false_confidence > 0.0)).percent().extra(),
    Metric::new("sure and 2 m off at the end %", Kind::Share, |r| flag(r.status? == Status::Tracking && place(r)?.track.end_m > 2.0))
        .percent()
        .extra(),
    Metric::new("right or doubted %", Kind::Share, |r| {
        flag(r.status? != Status::Tracking || place(r)?.track.end_right && scale_within(r, 0.05))
    })
    .percent()
    .higher()
    .extra(),
    Metric::new("right or two-fold %", Kind::Share, |r| flag(place(r)?.track.end_right || two_fold(r))).percent().higher().extra(),
    Metric::new("truth among the places %", Kind::Share, |r| flag(place(r)?.hypotheses?.any_right)).percent().higher().extra(),
    Metric::new("places ≥ 20 %", Kind::Mean, |r| Some(place(r)?.hypotheses?.held as f64)).decimals(1).extra(),
    Metric::new("in 95 % region %", Kind::Mean, |r| Some(place(r)?.track.calibration.as_ref()?.radius95)).percent().higher(),
    Metric::new("in 90 % region %", Kind::Mean, |r| in90(place(r)?.track.calibration.as_ref())).percent().higher().extra(),
    Metric::new("in 90 %, tracking %", Kind::Mean, |r| in90(place(r)?.track.calibration_tracking.as_ref())).percent().higher().extra(),
    Metric::new("causal in 90 % %", Kind::Mean, |r| in90(causal(r)?.errors.calibration.as_ref())).percent().higher().extra(),
    Metric::new("causal in 90 %, tracking %", Kind::Mean, |r| in90(causal(r)?.errors.calibration_tracking.as_ref()))
        .percent()
        .higher()
        .extra(),
    // Scale.
    Metric::new("scale off %", Kind::Median, |r| Some(place(r)?.scale?.track_log_error)).percent().decimals(1).extra(),
    Metric::new("scale off at the end %", Kind::Median, |r| Some(place(r)?.scale?.end_log_error)).percent().decimals(1).extra(),
    Metric::new("scale within 3 % %", Kind::Share, |r| flag(place(r)?.scale?.track_log_error <= 1.03_f64.ln())).percent().higher().extra(),
    Metric::new("scale within 5 % %", Kind::Share, |r| flag(place(r)?.scale?.track_log_error <= 1.05_f64.ln())).percent().higher().extra(),
    Metric::new("least scale/true", Kind::Median, |r| Some(place(r)?.scale?.least_ratio)).higher().extra(),
    Metric::new("scale collapsed %", Kind::Share, |r| flag(place(r)?.scale?.collapsed)).percent().extra(),
    Metric::new("walls crossed", Kind::Median, |r| Some(r.wall_crossings? as f64)).decimals(0).extra(),
    // Odometry and time.
    Metric::new("ATE % of path", Kind::Median, |r| r.odometry.as_ref()?.ate_percent).drawn(),
    Metric::new("rotation RMSE °", Kind::Median, |r| Some(r.odometry.as_ref()?.rotation_deg.as_ref()?.rmse)).decimals(1).drawn(),
    Metric::new("frames posed %", Kind::Mean, |r| Some(r.odometry.as_ref()?.posed_share)).percent().higher(),
    Metric::new("odometry s/s", Kind::Median, |r| per_second(r.odometry_s?, r)).decimals(3),
    Metric::new("locate s/s", Kind::Median, |r| per_second(r.locate_s?, r)).decimals(3),
    Metric::new("locate s", Kind::Median, |r| r.locate_s).decimals(1).extra(),
];

/// The metric with this head.
pub fn named(head: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|metric| metric.head == head)
}

fn place(record: &Record) -> Option<&PlaceScores> {
    record.place.as_ref()
}

fn causal(record: &Record) -> Option<&CausalScores> {
    place(record)?.filter.as_ref()
}

fn stay(record: &Record, within_m: f64, from_m: f64) -> Option<Stay> {
    causal(record)?.stays.iter().find(|stay| stay.within_m == within_m && stay.from_m == from_m).copied()
}

/// Metres walked after a kidnapping until the place is right again; infinite for never.
fn again_m(record: &Record) -> Option<f64> {
    Some(place(record)?.kidnap?.found_again.map_or(f64::INFINITY, |found| found.distance_m))
}

/// Whether the verdict names two places as what it could be, and is right in that.
fn two_fold(record: &Record) -> bool {
    let places = place(record).and_then(|p| p.hypotheses);
    record.status == Some(Status::Ambiguous) && places.is_some_and(|places| places.held == 2 && places.held_right)
}

/// Whether the scale is off by less; where nothing is known of it, nothing is held against it.
fn scale_within(record: &Record, share: f64) -> bool {
    place(record).and_then(|p| p.scale).is_none_or(|scale| scale.track_log_error <= share.ln_1p())
}

/// Share of the moments whose truth lies in the Gaussian 90 % region.
fn in90(calibration: Option<&Calibration>) -> Option<f64> {
    calibration?.regions.iter().find(|region| region.nominal == 0.9).map(|region| region.empirical)
}

fn flag(holds: bool) -> Option<f64> {
    Some(if holds { 1.0 } else { 0.0 })
}

/// Seconds of work in a second of walk.
fn per_second(seconds: f64, record: &Record) -> Option<f64> {
    (record.walk_s > 0.0).then(|| seconds / record.walk_s)
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::{record, with_end};
    use super::*;
    use crate::evaluate::place::HypothesisScores;

    fn of(head: &str, record: &Record) -> Option<f64> {
        (named(head).unwrap().of)(record)
    }

    #[test]
    fn heads_are_names() {
        for (i, metric) in METRICS.iter().enumerate() {
            assert!(METRICS[..i].iter().all(|other| other.head != metric.head), "{} twice", metric.head);
        }
    }

    #[test]
    fn two_places_that_are_held_are_an_honest_answer_and_three_are_none() {
        let with = |held: usize, held_right: bool, status: Status| {
            let mut record = Record { status: Some(status), ..with_end(record("a", 1, "m"), 20.0) };
            let scores = HypothesisScores { listed: 4, nearest_m: 0.3, any_right: true, probability_right: 0.4, held, held_right };
            record.place.as_mut().unwrap().hypotheses = Some(scores);
            of("right or two-fold %", &record)
        };
        assert_eq!(with(2, true, Status::Ambiguous), Some(1.0));
        assert_eq!([with(3, true, Status::Ambiguous), with(2, false, Status::Ambiguous)], [Some(0.0); 2]);
        assert_eq!(with(2, true, Status::Tracking), Some(0.0), "who is sure of the wrong one is wrong");
        assert_eq!(of("right or two-fold %", &with_end(record("a", 1, "m"), 0.5)), Some(1.0));
    }

    #[test]
    fn doubt_is_right_where_the_answer_is_not() {
        let wrong = with_end(record("a", 1, "m"), 5.0);
        assert_eq!((of("right or doubted %", &wrong), of("sure and 2 m off at the end %", &wrong)), (Some(0.0), Some(1.0)));
        let doubted = Record { status: Some(Status::Ambiguous), ..wrong };
        assert_eq!((of("right or doubted %", &doubted), of("sure and 2 m off at the end %", &doubted)), (Some(1.0), Some(0.0)));
        let mut stretched = with_end(record("a", 1, "m"), 0.5);
        assert_eq!(of("right or doubted %", &stretched), Some(1.0));
        let off = crate::evaluate::ScaleScores { end_log_error: 0.1, track_log_error: 0.1, least_ratio: 0.9, collapsed: false };
        stretched.place.as_mut().unwrap().scale = Some(off);
        assert_eq!(of("right or doubted %", &stretched), Some(0.0), "at the right place, but 10 % too large");
    }
}

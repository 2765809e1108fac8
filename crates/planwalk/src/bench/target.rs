//! Is it good enough? Targets of a suite, each a metric of a group with its bounds, met or missed.
//!
//! The value decides, not its interval: that stands beside it and says how far another draw of walks might be off.

use serde::{Deserialize, Serialize};

use super::metric::{self, Metric};
use super::record::Record;
use super::statistics::Interval;
use super::table::{self, Table};

/// What a group of walks must reach. Bounds are in the unit of the table: per cent where the metric's head says so.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Row of the table: a group of walks, or `all`.
    pub group: String,
    /// Head of its column.
    pub metric: String,
    /// Least value that will do.
    pub at_least: Option<f64>,
    /// Largest value that will do.
    pub at_most: Option<f64>,
}

/// Why a target can never be told met from missed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// No such column.
    #[error("there is no metric \"{metric}\"; there are: {}", known())]
    NoSuchMetric {
        /// What was asked for.
        metric: String,
    },
    /// No such row.
    #[error("the target for \"{metric}\" is about \"{group}\", and no walks are called so")]
    NoSuchGroup {
        /// What was asked for.
        group: String,
        /// Of which metric.
        metric: String,
    },
    /// Nothing to reach.
    #[error("the target for \"{metric}\" of \"{group}\" has no bound that can be kept: give at_least or at_most, a number each, in order")]
    NoBound {
        /// Whose.
        group: String,
        /// Of which metric.
        metric: String,
    },
}

fn known() -> String {
    metric::METRICS.iter().map(|m| format!("\"{}\"", m.head)).collect::<Vec<_>>().join(", ")
}

/// What came of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// What was to be reached.
    pub target: Target,
    /// Walks in the group.
    pub walks: usize,
    /// Those of them that have no scores.
    pub failed: usize,
    /// What was reached, in the metric's own unit; `None` where no walk says it.
    pub got: Option<Interval>,
    /// The same for people.
    pub text: String,
    /// Whether that will do. Walks without scores miss every target.
    pub met: bool,
}

impl Target {
    /// Whether it can be judged, given the groups that there are.
    ///
    /// # Errors
    /// [`TargetError`]: an unknown metric or group, no bound, bounds that exclude each other.
    pub fn check<'a>(&self, mut groups: impl Iterator<Item = &'a str>) -> Result<(), TargetError> {
        let (group, metric) = (self.group.clone(), self.metric.clone());
        if metric::named(&metric).is_none() {
            return Err(TargetError::NoSuchMetric { metric });
        }
        if group != "all" && !groups.any(|known| known == group) {
            return Err(TargetError::NoSuchGroup { group, metric });
        }
        let (low, high) = (self.at_least.unwrap_or(f64::NEG_INFINITY), self.at_most.unwrap_or(f64::INFINITY));
        let bounded = (self.at_least.is_some() || self.at_most.is_some()) && low <= high;
        if bounded { Ok(()) } else { Err(TargetError::NoBound { group, metric }) }
    }

    /// Judges the records of one method.
    pub fn judge(&self, records: &[Record], method: &str) -> Verdict {
        let ours = |r: &&Record| r.method == method && (self.group == "all" || r.group == self.group);
        let records: Vec<&Record> = records.iter().filter(ours).collect();
        let failed = records.iter().filter(|r| r.error.is_some()).count();
        let metric = metric::named(&self.metric);
        let got = metric.and_then(|metric| table::value(metric, &records));
        let text = metric.map_or_else(String::new, |metric| table::cell(metric, &records));
        let kept = |metric: &Metric, got: Interval| {
            let value = got.value * metric.factor;
            // Round-off of a share: 0.29 · 100 is not quite 29. Taken from the bound, for a value may be infinite ("never").
            let slack = |bound: f64| 1e-9 * bound.abs().max(1.0);
            let high_enough = self.at_least.is_none_or(|least| value >= least - slack(least));
            high_enough && self.at_most.is_none_or(|most| value <= most + slack(most))
        };
        let met = failed == 0 && metric.zip(got).is_some_and(|(metric, got)| kept(metric, got));
        Verdict { target: self.clone(), walks: records.len(), failed, got, text, met }
    }

    fn bounds(&self) -> String {
        match (self.at_least, self.at_most) {
            (Some(least), Some(most)) => format!("{least} to {most}"),
            (Some(least), None) => format!("≥ {least}"),
            (None, Some(most)) => format!("≤ {most}"),
            (None, None) => String::new(),
        }
    }
}

/// The verdicts for people. Targets whose walks were not run say so: a part of a suite proves nothing of the rest.
pub fn table(verdicts: &[Verdict]) -> Table {
    let head = ["walks", "N", "metric", "target", "got", "verdict"].map(str::to_owned).to_vec();
    let row = |verdict: &Verdict| {
        let said = match verdict {
            Verdict { walks: 0, .. } => "not run".to_owned(),
            Verdict { failed, walks, .. } if *failed > 0 => format!("missed: {failed} of {walks} failed"),
            Verdict { got: None, .. } => "missed: no figure".to_owned(),
            Verdict { met: true, .. } => "met".to_owned(),
            _ => "missed".to_owned(),
        };
        let Target { group, metric, .. } = &verdict.target;
        vec![group.clone(), verdict.walks.to_string(), metric.clone(), verdict.target.bounds(), verdict.text.clone(), said]
    };
    Table { head, rows: verdicts.iter().map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::{record, with_end};
    use super::*;

    fn target(metric: &str, at_least: Option<f64>, at_most: Option<f64>) -> Target {
        Target { group: "walks".to_owned(), metric: metric.to_owned(), at_least, at_most }
    }

    fn bench(wrong: u64) -> Vec<Record> {
        (0..20).map(|seed| with_end(record("a", seed, "m"), if seed < wrong { 3.0 } else { 0.25 })).collect()
    }

    #[test]
    fn a_share_is_held_against_its_bound_in_per_cent() {
        let right = target("end right %", Some(95.0), None);
        assert!(right.judge(&bench(0), "m").met && right.judge(&bench(1), "m").met && !right.judge(&bench(2), "m").met);
        let median = target("track median m", None, Some(0.3));
        assert!(median.judge(&bench(9), "m").met && !median.judge(&bench(11), "m").met);
        let between = target("end right %", Some(86.0), Some(94.0));
        assert!(!between.judge(&bench(0), "m").met && between.judge(&bench(2), "m").met);
        assert!(table(&[right.judge(&bench(0), "m")]).rows[0].ends_with(&["met".to_owned()]));
    }

    #[test]
    fn walks_without_scores_miss_and_walks_that_were_not_run_prove_nothing() {
        let right = target("end right %", Some(50.0), None);
        let mut records = bench(0);
        records.push(Record { error: Some("gone".to_owned()), ..record("b", 0, "m") });
        let verdict = right.judge(&records, "m");
        assert!(!verdict.met && verdict.failed == 1 && table(&[verdict]).rows[0][5].contains("1 of 21 failed"));
        assert_eq!(table(&[right.judge(&bench(0), "other")]).rows[0][5], "not run");
        let never = target("causal < 1 m after m", None, Some(10.0));
        let mut lost = bench(0);
        for place in lost.iter_mut().filter_map(|r| r.place.as_mut()) {
            place.filter = Some(crate::evaluate::causal::tests::never_right());
        }
        assert!(!never.judge(&lost, "m").met, "never is later than 10 m");
        let silent = target("scale off %", None, Some(3.0)).judge(&bench(0), "m");
        assert!(!silent.met && table(&[silent]).rows[0][5].contains("no figure"));
        let all = Target { group: "all".to_owned(), ..right };
        assert_eq!(all.judge(&bench(0), "m").walks, 20);
    }

    #[test]
    fn targets_that_nothing_can_be_held_against_are_refused() {
        let groups = || ["walks"].into_iter();
        let refused = |t: Target| t.check(groups()).unwrap_err().to_string();
        assert_eq!(target("end right %", Some(95.0), None).check(groups()), Ok(()));
        assert!(refused(target("end wrong %", Some(95.0), None)).contains("end right %"));
        assert!(refused(target("end right %", None, None)).contains("at_least"));
        assert!(refused(target("end right %", Some(9.0), Some(2.0))).contains("at_least"));
        assert!(refused(target("end right %", Some(f64::NAN), None)).contains("at_least"));
        assert!(refused(Target { group: "castle".to_owned(), ..target("end right %", Some(1.0), None) }).contains("castle"));
    }
}

//! What changed between two benches, and is it noise?
//!
//! Records of the same case, seed and method are pairs. A metric's change is the mean (or median) of the paired differences with
//! its bootstrap interval: noise where that holds zero. What is right or wrong is counted by flips (exact sign test).

use super::metric::{Kind, METRICS, Metric};
use super::record::Record;
use super::statistics::{self, Interval};
use super::table::Table;

/// A metric's change in one group and method.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Group of walks.
    pub group: String,
    /// Method.
    pub method: String,
    /// Which metric: its head in the table.
    pub metric: &'static str,
    /// Pairs that both benches have.
    pub pairs: usize,
    /// Its value before, as in the table.
    pub before: f64,
    /// Its value now.
    pub after: f64,
    /// Mean or median of the paired differences, now less before, with a 95 % interval.
    pub difference: Interval,
    /// Whether the change is more than chance makes of nothing.
    pub real: bool,
    /// Whether it is for the better; `None` where nothing real changed.
    pub better: Option<bool>,
}

/// Every metric of every group and method that both benches have. `before` is the older one.
pub fn compare(before: &[Record], after: &[Record]) -> Vec<Change> {
    let mut changes = Vec::new();
    for (group, method) in super::table::groups(after) {
        let pairs: Vec<(&Record, &Record)> = after
            .iter()
            .filter(|r| r.group == group && r.method == method)
            .filter_map(|now| before.iter().find(|then| then.key() == now.key()).map(|then| (then, now)))
            .collect();
        changes.extend(METRICS.iter().filter_map(|metric| change(metric, &group, &method, &pairs)));
    }
    changes
}

fn change(metric: &Metric, group: &str, method: &str, pairs: &[(&Record, &Record)]) -> Option<Change> {
    let values: Vec<(f64, f64)> = pairs.iter().filter_map(|(then, now)| Some(((metric.of)(then)?, (metric.of)(now)?))).collect();
    let of = |pick: fn(&(f64, f64)) -> f64| {
        let side: Vec<f64> = values.iter().map(pick).collect();
        if metric.kind == Kind::Median { statistics::median(&side) } else { statistics::mean(&side) }
    };
    let (before, after) = (of(|v| v.0)?, of(|v| v.1)?);
    // Both never: nothing changed. One never: a change of any size; half of the other's fate cannot be told in metres.
    let differences: Vec<f64> = values.iter().map(|(then, now)| if then == now { 0.0 } else { now - then }).collect();
    let statistic = if metric.kind == Kind::Median { statistics::median } else { statistics::mean };
    let difference = statistics::bootstrap(&differences, statistic)?;
    let real = match metric.kind {
        Kind::Share => {
            let up = differences.iter().filter(|d| **d > 0.0).count();
            let down = differences.iter().filter(|d| **d < 0.0).count();
            statistics::sign_test(up, down) < 0.05
        }
        Kind::Mean | Kind::Median => differences.len() > 1 && difference.excludes_zero(),
    };
    let better = real.then_some((difference.value > 0.0) == metric.higher_is_better);
    let (group, method) = (group.to_owned(), method.to_owned());
    Some(Change { group, method, metric: metric.head, pairs: values.len(), before, after, difference, real, better })
}

/// The changes for people: real ones first within each group, noise said to be noise.
pub fn table(changes: &[Change]) -> Table {
    let head = ["walks", "method", "metric", "pairs", "before", "after", "change", "verdict"].map(str::to_owned).to_vec();
    let row = |change: &Change| {
        let metric = METRICS.iter().find(|m| m.head == change.metric);
        let (decimals, factor) = metric.map_or((3, 1.0), |m| (m.decimals, m.factor));
        let text = |v: f64| if v.is_infinite() { "never".to_owned() } else { format!("{:.decimals$}", v * factor) };
        let signed = |v: f64| if v.is_infinite() { "±∞".to_owned() } else { format!("{:+.decimals$}", v * factor) };
        let Interval { value, low, high } = change.difference;
        let verdict = match change.better {
            Some(true) => "better",
            Some(false) => "worse",
            None if low == 0.0 && high == 0.0 && value == 0.0 => "same",
            None => "noise",
        };
        vec![
            change.group.clone(),
            change.method.clone(),
            change.metric.to_owned(),
            change.pairs.to_string(),
            text(change.before),
            text(change.after),
            format!("{} [{}, {}]", signed(value), signed(low), signed(high)),
            verdict.to_owned(),
        ]
    };
    Table { head, rows: changes.iter().map(row).collect() }
}

/// Walks that ended right in one bench and not in the other: what to look at first.
pub fn flips<'a>(before: &[Record], after: &'a [Record]) -> Vec<(&'a Record, bool)> {
    let right = |r: &Record| r.place.as_ref().map(|p| p.track.end_right);
    let flipped = |now: &'a Record| {
        let then = before.iter().find(|then| then.key() == now.key())?;
        match (right(then)?, right(now)?) {
            (true, false) => Some((now, false)),
            (false, true) => Some((now, true)),
            _ => None,
        }
    };
    after.iter().filter_map(flipped).collect()
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::{record, with_end};
    use super::*;

    /// Twenty walks whose ends are off by this.
    fn bench(method: &str, end_m: impl Fn(u64) -> f64) -> Vec<Record> {
        (0..20).map(|seed| with_end(record("walk", seed, method), end_m(seed))).collect()
    }

    fn of<'a>(changes: &'a [Change], metric: &str) -> &'a Change {
        changes.iter().find(|c| c.metric == metric).unwrap()
    }

    #[test]
    fn what_changed_on_every_walk_is_told_from_what_fluctuates() {
        // Uneven over the seeds, but centred: the sign of the change alternates.
        let wobble = |seed: u64| if seed.is_multiple_of(2) { 0.05 } else { -0.05 } * (1.0 + seed as f64 / 20.0);
        let before = bench("m", |_| 0.5);
        let noisy = compare(&before, &bench("m", |seed| 0.5 + wobble(seed)));
        assert!(!of(&noisy, "track end m").real, "{noisy:?}");
        let better = compare(&before, &bench("m", |seed| 0.3 + wobble(seed)));
        let change = of(&better, "track end m");
        assert_eq!((change.pairs, change.better), (20, Some(true)));
        assert!((change.before - 0.5).abs() < 1e-12 && change.difference.high < 0.0, "{change:?}");
        let same = compare(&before, &before);
        assert!(same.iter().all(|c| !c.real), "{same:?}");
        assert!(table(&same).rows.iter().all(|row| row[7] == "same"));
    }

    #[test]
    fn walks_that_flip_are_counted_and_named() {
        // Six of twenty lost: 2 · 2⁻⁶ = 0.03 by chance.
        let (before, after) = (bench("m", |_| 0.5), bench("m", |seed| if seed < 6 { 9.0 } else { 0.5 }));
        let changes = compare(&before, &after);
        assert_eq!(of(&changes, "end right %").better, Some(false));
        let flips = flips(&before, &after);
        assert_eq!(flips.len(), 6);
        assert!(flips.iter().all(|(record, now_right)| record.seed < 6 && !now_right));
        // Five: 0.06.
        let five = compare(&before, &bench("m", |seed| if seed < 5 { 9.0 } else { 0.5 }));
        assert!(!of(&five, "end right %").real);
    }

    #[test]
    fn only_what_both_have_is_compared() {
        let (before, after) = (bench("old", |_| 0.5), bench("new", |_| 0.4));
        assert!(compare(&before, &after).is_empty());
    }
}

//! Which numbers of a run are put into tables, and which way is better?

use planwalk_types::Status;

use super::record::Record;

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
    /// The value of one run; `None` where it has none.
    pub of: fn(&Record) -> Option<f64>,
}

impl Metric {
    const fn new(head: &'static str, kind: Kind, of: fn(&Record) -> Option<f64>) -> Self {
        Self { head, kind, higher_is_better: false, factor: 1.0, decimals: 2, drawn: false, of }
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

    const fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }
}

/// The columns, in order. A record shows those that it has.
pub const METRICS: [Metric; 14] = [
    Metric::new("end right %", Kind::Share, |r| flag(r.place.as_ref()?.track.end_right)).percent().higher().drawn(),
    Metric::new("tracking %", Kind::Share, |r| r.place.as_ref().and(flag(r.status? == Status::Tracking))).percent().higher(),
    Metric::new("wrong yet tracking %", Kind::Share, |r| flag(r.status? == Status::Tracking && !r.place.as_ref()?.track.end_right))
        .percent()
        .drawn(),
    Metric::new("track median m", Kind::Median, |r| Some(r.place.as_ref()?.track.median_m)).drawn(),
    Metric::new("track end m", Kind::Median, |r| Some(r.place.as_ref()?.track.end_m)),
    Metric::new("causal < 1 m after m", Kind::Median, |r| {
        let causal = r.place.as_ref()?.filter.as_ref()?;
        Some(causal.converged_right.map_or(f64::INFINITY, |c| c.distance_m))
    })
    .decimals(0)
    .drawn(),
    Metric::new("causal recall 1 m %", Kind::Mean, |r| {
        let causal = r.place.as_ref()?.filter.as_ref()?;
        causal.errors.recall.iter().find(|recall| recall.within_m == 1.0).map(|recall| recall.of_moments)
    })
    .percent()
    .higher(),
    Metric::new("false confidence %", Kind::Mean, |r| Some(r.place.as_ref()?.filter.as_ref()?.false_confidence)).percent(),
    Metric::new("in 95 % region %", Kind::Mean, |r| Some(r.place.as_ref()?.track.calibration.as_ref()?.radius95)).percent().higher(),
    Metric::new("ATE % of path", Kind::Median, |r| r.odometry.as_ref()?.ate_percent).drawn(),
    Metric::new("rotation RMSE °", Kind::Median, |r| Some(r.odometry.as_ref()?.rotation_deg.as_ref()?.rmse)).decimals(1).drawn(),
    Metric::new("frames posed %", Kind::Mean, |r| Some(r.odometry.as_ref()?.posed_share)).percent().higher(),
    Metric::new("odometry s/s", Kind::Median, |r| per_second(r.odometry_s?, r)).decimals(3),
    Metric::new("locate s/s", Kind::Median, |r| per_second(r.locate_s?, r)).decimals(3),
];

fn flag(holds: bool) -> Option<f64> {
    Some(if holds { 1.0 } else { 0.0 })
}

/// Seconds of work in a second of walk.
fn per_second(seconds: f64, record: &Record) -> Option<f64> {
    (record.walk_s > 0.0).then(|| seconds / record.walk_s)
}

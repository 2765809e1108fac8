//! Which numbers of a run are put into tables, and which way is better?

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

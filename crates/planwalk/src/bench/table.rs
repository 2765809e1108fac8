//! How good was each method in each group? A table for the terminal and for Markdown.

use super::metric::{Kind, METRICS, Metric};
use super::record::Record;
use super::statistics::{self, Interval};

/// A table of text: a head and rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub head: Vec<String>,
    /// Cells by row.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// As Markdown, columns padded so that the text reads well as it is.
    pub fn markdown(&self) -> String {
        let width = |column: usize| {
            let cells = self.rows.iter().chain([&self.head]).filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0).max(3)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        let line = |cells: &[String]| {
            let padded: Vec<String> = cells.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
            format!("| {} |\n", padded.join(" | "))
        };
        let rule: Vec<String> = widths.iter().map(|width| "-".repeat(*width)).collect();
        let mut text = line(&self.head) + &line(&rule);
        self.rows.iter().for_each(|row| text.push_str(&line(row)));
        text
    }
}

/// Groups in the order in which they come, and within them methods.
pub fn groups(records: &[Record]) -> Vec<(String, String)> {
    let mut names: Vec<(String, String)> = Vec::new();
    let mut order: Vec<&str> = Vec::new();
    for record in records {
        if !order.contains(&record.group.as_str()) {
            order.push(&record.group);
        }
        let name = (record.group.clone(), record.method.clone());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.sort_by_key(|(group, method)| (order.iter().position(|g| g == group), method.clone()));
    names
}

/// The usual metrics that any of the records has.
pub fn present(records: &[Record]) -> Vec<&'static Metric> {
    METRICS.iter().filter(|metric| !metric.extra && has(records, metric)).collect()
}

fn has(records: &[Record], metric: &Metric) -> bool {
    records.iter().any(|r| (metric.of)(r).is_some())
}

/// One row a group and method, and one a method over all groups where there are several; the usual columns.
pub fn summary(records: &[Record]) -> Table {
    summary_of(records, &present(records))
}

/// The same with these columns; those that no record has are left out.
pub fn summary_of(records: &[Record], metrics: &[&'static Metric]) -> Table {
    let metrics: Vec<&Metric> = metrics.iter().copied().filter(|metric| has(records, metric)).collect();
    let mut table = Table { head: vec!["walks".to_owned(), "method".to_owned(), "N".to_owned()], rows: Vec::new() };
    let failed = records.iter().any(|r| r.error.is_some());
    table.head.extend(failed.then(|| "failed".to_owned()));
    table.head.extend(metrics.iter().map(|m| m.head.to_owned()));
    let names = groups(records);
    let mut row = |group: &str, method: &str, of: &[&Record]| {
        let mut cells = vec![group.to_owned(), method.to_owned(), of.len().to_string()];
        cells.extend(failed.then(|| of.iter().filter(|r| r.error.is_some()).count().to_string()));
        cells.extend(metrics.iter().map(|metric| cell(metric, of)));
        table.rows.push(cells);
    };
    for (group, method) in &names {
        let of: Vec<&Record> = records.iter().filter(|r| r.group == *group && r.method == *method).collect();
        row(group, method, &of);
    }
    let mut methods: Vec<&String> = names.iter().map(|(_, method)| method).collect();
    methods.sort();
    methods.dedup();
    if names.len() > methods.len() {
        for method in methods {
            let of: Vec<&Record> = records.iter().filter(|r| r.method == *method).collect();
            row("all", method, &of);
        }
    }
    table
}

/// What a metric says of some records, with its interval.
pub fn value(metric: &Metric, records: &[&Record]) -> Option<Interval> {
    let values: Vec<f64> = records.iter().filter_map(|r| (metric.of)(r)).collect();
    match metric.kind {
        Kind::Share => statistics::share(values.iter().filter(|v| **v > 0.5).count(), values.len()),
        Kind::Mean => statistics::bootstrap(&values, statistics::mean),
        Kind::Median => statistics::bootstrap(&values, statistics::median),
    }
}

/// The same as text, in the metric's unit for people.
pub fn cell(metric: &Metric, records: &[&Record]) -> String {
    let Some(Interval { value, low, high }) = value(metric, records) else { return "–".to_owned() };
    let text = |v: f64| if v.is_infinite() { "never".to_owned() } else { format!("{:.*}", metric.decimals, v * metric.factor) };
    // One walk has no spread.
    if records.len() < 2 { text(value) } else { format!("{} [{}, {}]", text(value), text(low), text(high)) }
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::{record, with_end};
    use super::*;

    #[test]
    fn groups_and_methods_have_rows_and_all_of_them_one_more() {
        let far = |seed: u64| if seed == 0 { 5.0 } else { 0.25 };
        let mut records: Vec<Record> = (0..4).map(|seed| with_end(record("a", seed, "one"), far(seed))).collect();
        records.extend((0..4).map(|seed| Record { group: "others".to_owned(), ..with_end(record("b", seed, "one"), 0.5) }));
        records.push(Record { error: Some("gone".to_owned()), status: None, locate_s: None, ..record("c", 0, "two") });
        let table = summary(&records);
        let column = |head: &str| table.head.iter().position(|h| h == head).unwrap();
        let names: Vec<(&str, &str)> = table.rows.iter().map(|row| (row[0].as_str(), row[1].as_str())).collect();
        assert_eq!(names, [("walks", "one"), ("walks", "two"), ("others", "one"), ("all", "one"), ("all", "two")]);
        assert!(table.rows[0][column("end right %")].starts_with("75 ["), "{table:?}");
        assert!(table.rows[0][column("track end m")].starts_with("0.25 ["), "{table:?}");
        assert_eq!((table.rows[1][column("failed")].as_str(), table.rows[1][column("track end m")].as_str()), ("1", "–"));
        assert!(!table.head.contains(&"ATE % of path".to_owned()), "what nobody has is no column");
        let text = table.markdown();
        assert_eq!(text.lines().count(), 2 + 5);
        let widths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
        assert!(widths.windows(2).all(|w| w[0] == w[1]), "columns line up");
    }
}

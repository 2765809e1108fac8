//! Which method is better on which walks, and is that more than chance? A panel a metric, a row a group, a dot a method with its
//! 95 % interval.

use super::colour;
use super::map::{multiples, round_step, tick_text};
use super::svg::{Anchor, Pen, Svg};
use crate::bench::metric::Metric;
use crate::bench::{Record, table};

/// The picture of a bench.
#[derive(Debug, Clone, Copy)]
pub struct BenchPicture<'a> {
    /// What is shown, e.g. the suite's name.
    pub title: &'a str,
    /// All runs.
    pub records: &'a [Record],
}

const LEFT_PX: f64 = 330.0;
const TOP_PX: f64 = 92.0;
const PANEL_PX: f64 = 250.0;
const GAP_PX: f64 = 34.0;
const ROW_PX: f64 = 34.0;
/// One colour a method; told apart also by those who see few colours.
const METHODS: [&str; 4] = ["#1565c0", "#ef6c00", "#2e7d32", "#8e24aa"];

impl BenchPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let names = table::groups(self.records);
        let mut groups: Vec<&str> = names.iter().map(|(group, _)| group.as_str()).collect();
        groups.dedup();
        let mut methods: Vec<&str> = names.iter().map(|(_, method)| method.as_str()).collect();
        methods.sort_unstable();
        methods.dedup();
        let metrics: Vec<&Metric> = table::present(self.records).into_iter().filter(|m| m.drawn).collect();
        let width = LEFT_PX + metrics.len().max(1) as f64 * (PANEL_PX + GAP_PX) + 10.0;
        let height = TOP_PX + groups.len() as f64 * ROW_PX + 60.0;
        let mut svg = Svg::new("bench", width, height, self.title);
        svg.bold(self.title, (20.0, 34.0), 12.5, Anchor::Left, colour::INK);
        self.legend(&mut svg, &methods);
        for (row, group) in groups.iter().enumerate() {
            let y = TOP_PX + (row as f64 + 0.5) * ROW_PX;
            let n = self.records.iter().filter(|r| r.group == **group && r.method == methods[0]).count();
            let label = format!("{} ({n})", super::track::shortened(group, 36));
            svg.text(&label, (LEFT_PX - 14.0, y + 4.5), 9.0, Anchor::Right, colour::INK);
        }
        for (index, metric) in metrics.iter().enumerate() {
            let left = LEFT_PX + index as f64 * (PANEL_PX + GAP_PX);
            self.panel(&mut svg, metric, left, &groups, &methods);
        }
        svg.finish()
    }

    fn legend(&self, svg: &mut Svg, methods: &[&str]) {
        let mut x = 20.0;
        for (i, method) in methods.iter().enumerate() {
            svg.circle((x + 5.0, 56.0), 5.0, METHODS[i % METHODS.len()], Pen::new("#ffffff", 1.0));
            svg.text(method, (x + 16.0, 60.5), 9.0, Anchor::Left, colour::INK);
            x += 34.0 + 9.0 * method.chars().count() as f64;
        }
    }

    fn panel(&self, svg: &mut Svg, metric: &Metric, left: f64, groups: &[&str], methods: &[&str]) {
        let of = |group: &str, method: &str| {
            let records: Vec<&Record> = self.records.iter().filter(|r| r.group == group && r.method == method).collect();
            table::value(metric, &records)
        };
        let all = groups.iter().flat_map(|group| methods.iter().filter_map(|method| of(group, method)));
        let finite = |v: f64| if v.is_finite() { v * metric.factor } else { 0.0 };
        let most = all.map(|i| finite(i.high).max(finite(i.value))).fold(0.0_f64, f64::max);
        // A share fills its panel; anything else ends a little right of its largest value.
        let span = if metric.factor == 100.0 { 100.0 } else { 1.06 * most.max(1e-9) };
        let x = |v: f64| left + PANEL_PX * (if v.is_finite() { v * metric.factor / span } else { 1.0 }).clamp(0.0, 1.0);
        let bottom = TOP_PX + groups.len() as f64 * ROW_PX;
        svg.text(metric.head, (left, TOP_PX - 10.0), 9.0, Anchor::Left, colour::INK);
        let step = round_step(span / 4.0);
        for tick in multiples(step, 0.0, span) {
            let u = left + PANEL_PX * tick / span;
            svg.line((u, TOP_PX), (u, bottom), Pen::new(colour::OUTSIDE, 1.0));
            svg.text(&tick_text(tick, step), (u, bottom + 16.0), 8.0, Anchor::Middle, colour::FAINT_INK);
        }
        svg.frame(left, TOP_PX, PANEL_PX, bottom - TOP_PX, Pen::new(colour::FAINT_INK, 1.0));
        for (row, group) in groups.iter().enumerate() {
            for (i, method) in methods.iter().enumerate() {
                let Some(interval) = of(group, method) else { continue };
                let share = (i as f64 + 1.0) / (methods.len() as f64 + 1.0);
                let y = TOP_PX + (row as f64 + 0.15 + 0.7 * share) * ROW_PX;
                let ink = METHODS[i % METHODS.len()];
                svg.line((x(interval.low), y), (x(interval.high), y), Pen::new(ink, 2.0).faint(0.55));
                svg.circle((x(interval.value), y), 4.0, ink, Pen::new("#ffffff", 1.0));
            }
        }
    }
}

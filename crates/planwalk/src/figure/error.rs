//! How far off was the answer along the walk, and did it know? Error over distance, claimed radius, status.

use planwalk_types::Status;

use super::chart::{Axis, Chart};
use super::colour;
use super::svg::{Anchor, Pen, Svg};
use super::track::shortened;
use crate::evaluate::{Curves, Moment};

/// Error over the distance walked.
#[derive(Debug, Clone, Copy)]
pub struct ErrorPicture<'a> {
    /// What is shown, e.g. the name of the walk.
    pub title: &'a str,
    /// The compared moments.
    pub curves: &'a Curves,
    /// Error up to which an answer is right, metres: a line.
    pub right_m: f64,
}

const CHART: (f64, f64, f64, f64) = (76.0, 112.0, 900.0, 420.0);
/// Errors below this are drawn at it: no truth is better than that.
const LEAST_M: f64 = 0.02;
/// Height of the band that tells the status, pixels.
const BAND_PX: f64 = 10.0;

impl ErrorPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let all = || self.curves.track.iter().chain(&self.curves.filter);
        let finite = |values: &mut dyn Iterator<Item = f64>| values.filter(|v| v.is_finite()).fold(0.0, f64::max);
        let far = finite(&mut all().map(|m| m.distance_m));
        let high = finite(&mut all().map(|m| m.error_m)).max(finite(&mut self.curves.filter.iter().map(|m| m.radius95_m)));
        let (left_px, top_px, width_px, height_px) = CHART;
        let y = Axis::log(LEAST_M, high.max(2.0 * self.right_m) * 1.15);
        let chart = Chart { left_px, top_px, width_px, height_px, x: Axis::linear(0.0, far), y };
        let mut svg = Svg::new("error", left_px + width_px + 30.0, top_px + height_px + 94.0, self.title);
        svg.bold(&shortened(self.title, 80), (30.0, 36.0), 13.0, Anchor::Left, colour::INK);
        svg.text(&self.summary(), (30.0, 62.0), 9.5, Anchor::Left, colour::FAINT_INK);
        chart.draw_axes(&mut svg, "walked / m", "error / m");
        self.status_bands(&mut svg, &chart);
        let right = Pen::new(colour::START, 1.2).dashed("2 4");
        chart.curve(&mut svg, [(0.0, self.right_m), (far, self.right_m)].into_iter(), right);
        let points = |moments: &[Moment], of: &dyn Fn(&Moment) -> f64| moments.iter().map(|m| (m.distance_m, of(m))).collect::<Vec<_>>();
        let claimed = points(&self.curves.filter, &|m| m.radius95_m).into_iter().filter(|p| p.1 > 0.0);
        chart.curve(&mut svg, claimed, Pen::new(colour::DOUBT, 1.6).dashed("6 4"));
        chart.curve(&mut svg, points(&self.curves.filter, &|m| m.error_m).into_iter(), Pen::new(colour::OTHERS[1], 2.2));
        chart.curve(&mut svg, points(&self.curves.track, &|m| m.error_m).into_iter(), Pen::new(colour::PATH, 2.2));
        self.legend(&mut svg, top_px + height_px + 72.0);
        svg.finish()
    }

    fn summary(&self) -> String {
        let median =
            |moments: &[Moment]| crate::evaluate::statistics::quantile(&moments.iter().map(|m| m.error_m).collect::<Vec<_>>(), 0.5);
        let (track, filter) = (median(&self.curves.track), median(&self.curves.filter));
        let of = |name: &str, median: Option<f64>| median.map(|m| format!("{name} {m:.2} m"));
        let parts: Vec<String> = [of("median error of the whole walk", track), of("as it went", filter)].into_iter().flatten().collect();
        parts.join(", ")
    }

    /// A band above the chart in the colours of the causal status.
    fn status_bands(&self, svg: &mut Svg, chart: &Chart) {
        let moments = &self.curves.filter;
        let mut start = 0;
        while start < moments.len() {
            let status = moments[start].status;
            let end = (start..moments.len()).find(|i| moments[*i].status != status).unwrap_or(moments.len());
            let until = moments.get(end).unwrap_or(&moments[end - 1]);
            let (from_px, to_px) = (chart.px(moments[start].distance_m, LEAST_M).0, chart.px(until.distance_m, LEAST_M).0);
            let (width, fill) = ((to_px - from_px).max(0.0), colour::of_status(status));
            svg.rect(from_px, chart.top_px, width, chart.height_px, fill, 0.06);
            svg.rect(from_px, chart.top_px, width, BAND_PX, fill, 0.85);
            start = end;
        }
    }

    fn legend(&self, svg: &mut Svg, y: f64) {
        let mut x = 34.0;
        let mut item = |svg: &mut Svg, text: &str, pen: Pen| {
            svg.line((x, y - 4.0), (x + 28.0, y - 4.0), pen);
            svg.text(text, (x + 36.0, y), 9.0, Anchor::Left, colour::INK);
            x += 62.0 + super::font::width_px(text, 9.0);
        };
        item(svg, "whole walk", Pen::new(colour::PATH, 2.2));
        if self.curves.filter.is_empty() {
            return;
        }
        item(svg, "as it went", Pen::new(colour::OTHERS[1], 2.2));
        item(svg, "claimed 95 % radius", Pen::new(colour::DOUBT, 1.6).dashed("6 4"));
        item(svg, "right", Pen::new(colour::START, 1.2).dashed("2 4"));
        for status in [Status::Tracking, Status::Ambiguous, Status::Lost] {
            item(svg, &status.to_string(), Pen::new(colour::of_status(status), 8.0));
        }
    }
}

//! Was the doubt honest? Claimed against real share of the truth inside Gaussian regions: the diagonal is honest.

use super::chart::{Axis, Chart};
use super::colour;
use super::svg::{Anchor, Pen, Svg};
use super::track::shortened;
use crate::evaluate::curves::coverage;
use crate::evaluate::{Curves, Moment};

/// Claimed against real coverage.
#[derive(Debug, Clone, Copy)]
pub struct CalibrationPicture<'a> {
    /// What is shown, e.g. the name of the walk.
    pub title: &'a str,
    /// The compared moments.
    pub curves: &'a Curves,
}

const CHART: (f64, f64, f64) = (84.0, 96.0, 440.0);

impl CalibrationPicture<'_> {
    /// The drawing; without any covariance, an empty chart that says so.
    pub fn svg(&self) -> String {
        let (left_px, top_px, side_px) = CHART;
        let axis = Axis::linear(0.0, 100.0);
        let chart = Chart { left_px, top_px, width_px: side_px, height_px: side_px, x: axis, y: axis };
        let mut svg = Svg::new("calibration", left_px + side_px + 40.0, top_px + side_px + 96.0, self.title);
        svg.bold(&shortened(self.title, 46), (30.0, 36.0), 12.0, Anchor::Left, colour::INK);
        svg.text("below the diagonal: too sure; above: too shy", (30.0, 60.0), 9.0, Anchor::Left, colour::FAINT_INK);
        chart.draw_axes(&mut svg, "claimed / %", "truth inside / %");
        chart.curve(&mut svg, [(0.0, 0.0), (100.0, 100.0)].into_iter(), Pen::new(colour::FAINT_INK, 1.2).dashed("5 5"));
        let y = top_px + side_px + 72.0;
        let mut x = 40.0;
        let answers = [("whole walk", &self.curves.track, colour::PATH), ("as it went", &self.curves.filter, colour::OTHERS[1])];
        for (name, moments, colour) in answers {
            let points = points(moments);
            if points.is_empty() {
                continue;
            }
            chart.curve(&mut svg, points.iter().copied(), Pen::new(colour, 2.2));
            // The regions that people quote.
            for nominal in [50.0, 90.0, 95.0] {
                if let Some(point) = points.iter().find(|p| p.0 == nominal) {
                    svg.circle(chart.px(point.0, point.1), 4.0, colour, Pen::new("#ffffff", 1.2));
                }
            }
            svg.line((x, y - 4.0), (x + 28.0, y - 4.0), Pen::new(colour, 2.2));
            svg.text(name, (x + 36.0, y), 9.0, Anchor::Left, colour::INK);
            x += 150.0;
        }
        if x == 40.0 {
            svg.text("no region was claimed", (x, y), 9.0, Anchor::Left, colour::INK);
        }
        svg.finish()
    }
}

/// Per cent claimed and real, every 5 % and at 99 %.
fn points(moments: &[Moment]) -> Vec<(f64, f64)> {
    let claimed = (0..20).map(|i| 5.0 * f64::from(i)).chain([99.0]);
    claimed.filter_map(|percent| Some((percent, 100.0 * coverage(moments, percent / 100.0)?))).collect()
}

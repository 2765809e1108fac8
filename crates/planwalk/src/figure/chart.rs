//! How does a curve lie on the sheet? Two axes, linear or logarithmic, with ticks and a grid.

use super::colour;
use super::map::{multiples, round_step, tick_text};
use super::svg::{Anchor, Pen, Svg};

/// An axis: its range, and whether it is logarithmic.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    log: bool,
}

impl Axis {
    /// From `low` to `high`, which is kept above it.
    pub(super) fn linear(low: f64, high: f64) -> Self {
        let high = if high.is_finite() { high.max(low + 1e-6) } else { low + 1.0 };
        Self { low, high, log: false }
    }

    /// Both above 0.
    pub(super) fn log(low: f64, high: f64) -> Self {
        let low = low.max(1e-9);
        let high = if high.is_finite() { high.max(2.0 * low) } else { 10.0 * low };
        Self { low, high, log: true }
    }

    /// 0 at the low end, 1 at the high one; what lies beyond is put on the end.
    fn share(&self, value: f64) -> f64 {
        let share = if self.log {
            (value.max(self.low) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        share.clamp(0.0, 1.0)
    }

    fn ticks(&self, room_px: f64) -> Vec<(f64, String)> {
        if !self.log {
            let step = round_step((self.high - self.low) * 60.0 / room_px.max(60.0));
            return multiples(step, self.low, self.high).into_iter().map(|v| (v, tick_text(v, step))).collect();
        }
        let powers = (self.low.log10().floor() as i32)..=(self.high.log10().ceil() as i32);
        let all = powers.flat_map(|p| [1.0, 2.0, 5.0].map(|f| (f * 10f64.powi(p), 10f64.powi(p))));
        let held = all.filter(|(v, _)| *v >= 0.999 * self.low && *v <= 1.001 * self.high);
        held.map(|(v, step)| (v, tick_text(v, step))).collect()
    }
}

/// A chart's place on the sheet and its axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chart {
    pub left_px: f64,
    pub top_px: f64,
    pub width_px: f64,
    pub height_px: f64,
    pub x: Axis,
    pub y: Axis,
}

impl Chart {
    /// Where a value is on the sheet.
    pub(super) fn px(&self, x: f64, y: f64) -> (f64, f64) {
        (self.left_px + self.width_px * self.x.share(x), self.top_px + self.height_px * (1.0 - self.y.share(y)))
    }

    /// Grid, frame, ticks and the axes' names.
    pub(super) fn draw_axes(&self, svg: &mut Svg, x_name: &str, y_name: &str) {
        let bottom = self.top_px + self.height_px;
        let grid = Pen::new(colour::OUTSIDE, 1.0);
        for (value, text) in self.x.ticks(self.width_px) {
            let u = self.px(value, 0.0).0;
            svg.line((u, self.top_px), (u, bottom), grid);
            svg.text(&text, (u, bottom + 18.0), 9.0, Anchor::Middle, colour::FAINT_INK);
        }
        for (value, text) in self.y.ticks(self.height_px) {
            let v = self.px(0.0, value).1;
            svg.line((self.left_px, v), (self.left_px + self.width_px, v), grid);
            svg.text(&text, (self.left_px - 9.0, v + 4.5), 9.0, Anchor::Right, colour::FAINT_INK);
        }
        svg.frame(self.left_px, self.top_px, self.width_px, self.height_px, Pen::new(colour::FAINT_INK, 1.0));
        svg.text(x_name, (self.left_px + self.width_px, bottom + 40.0), 9.5, Anchor::Right, colour::INK);
        svg.text(y_name, (self.left_px - 46.0, self.top_px - 12.0), 9.5, Anchor::Left, colour::INK);
    }

    /// A curve, without points that fall on the one before.
    pub(super) fn curve(&self, svg: &mut Svg, points: impl Iterator<Item = (f64, f64)>, pen: Pen) {
        let mut line: Vec<(f64, f64)> = Vec::new();
        for (x, y) in points.filter(|p| p.0.is_finite() && p.1.is_finite()) {
            let at = self.px(x, y);
            if line.last().is_none_or(|b| (at.0 - b.0).hypot(at.1 - b.1) >= 0.5) {
                line.push(at);
            }
        }
        svg.polyline(&line, pen);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_ticks_are_one_two_five() {
        let ticks: Vec<String> = Axis::log(0.05, 20.0).ticks(400.0).into_iter().map(|t| t.1).collect();
        assert_eq!(ticks, ["0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(Axis::log(0.05, 20.0).share(0.0), 0.0, "nothing is below the low end");
    }

    #[test]
    fn an_axis_of_no_length_still_has_a_scale() {
        assert!(Axis::linear(0.0, 0.0).share(0.0).is_finite() && Axis::linear(0.0, f64::NAN).share(0.5) == 0.5);
        assert!(Axis::log(0.0, f64::INFINITY).share(1.0).is_finite());
    }
}

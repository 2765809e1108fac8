//! How long, thick and straight is a stroke? The rectangle with the same moments says so.

use super::blobs::Run;

/// A straight stroke is at least this many times longer than thick.
const BAR: f64 = 2.5;
/// What deviates from both axes by more than this, radians, leans: a pixel in 25.
const LEANING: f64 = 0.04;

/// The rectangle that has the moments of some pixels; pixels.
pub(super) struct Strip {
    pub centre: [f64; 2],
    /// Unit, along its longer side.
    pub way: [f64; 2],
    pub length: f64,
    pub thickness: f64,
    /// Pixels.
    pub area: f64,
}

impl Strip {
    /// Of the pixels of some runs.
    pub fn of(runs: impl Iterator<Item = Run>) -> Self {
        let (mut sum, mut squares, mut area) = ([0.0; 2], [0.0; 3], 0u64);
        for run in runs {
            let v = f64::from(run.row) + 0.5;
            area += u64::from(run.end - run.start);
            for u in (run.start..run.end).map(|u| f64::from(u) + 0.5) {
                sum = [sum[0] + u, sum[1] + v];
                squares = [squares[0] + u * u, squares[1] + u * v, squares[2] + v * v];
            }
        }
        let n = area.max(1) as f64;
        let centre = sum.map(|s| s / n);
        // A pixel is no point: it spreads over its square.
        let spread = 1.0 / 12.0;
        let (uu, vv) = (squares[0] / n - centre[0] * centre[0] + spread, squares[2] / n - centre[1] * centre[1] + spread);
        let uv = squares[1] / n - centre[0] * centre[1];
        let angle = 0.5 * libm::atan2(2.0 * uv, uu - vv);
        let root = (0.25 * (uu - vv).powi(2) + uv * uv).sqrt();
        let (along, across) = (0.5 * (uu + vv) + root, (0.5 * (uu + vv) - root).max(spread));
        let side = |variance: f64| (12.0 * variance).sqrt();
        Self { centre, way: [libm::cos(angle), libm::sin(angle)], length: side(along), thickness: side(across), area: n }
    }

    /// Whether it is a straight stroke: an L or a curve is half as wide as long.
    pub fn is_bar(&self) -> bool {
        self.length >= BAR * self.thickness
    }

    /// Whether it leans: a line that is neither upright nor level, as "l" and "-" are.
    pub fn is_oblique(&self) -> bool {
        self.way[0].abs().min(self.way[1].abs()) > LEANING
    }
}

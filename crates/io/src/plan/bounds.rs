//! Which upright box holds some points? Of drawings, whose corners are those of the paper or of the building.

use super::sketch::SketchPoint;

/// An upright box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub low: SketchPoint,
    pub high: SketchPoint,
}

impl Bounds {
    /// Holds everything.
    pub(super) const ALL: Self = Self { low: [f64::NEG_INFINITY; 2], high: [f64::INFINITY; 2] };

    /// The smallest that holds the points; `None` without points, or where one is not finite.
    pub(super) fn of<'a>(points: impl IntoIterator<Item = &'a SketchPoint>) -> Option<Self> {
        let mut bounds = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        for point in points {
            if !point.iter().all(|v| v.is_finite()) {
                return None;
            }
            bounds.low = [0, 1].map(|k| bounds.low[k].min(point[k]));
            bounds.high = [0, 1].map(|k| bounds.high[k].max(point[k]));
        }
        (bounds.low[0] <= bounds.high[0]).then_some(bounds)
    }

    /// What both hold; may be empty.
    pub(super) fn both(self, other: Self) -> Self {
        Self { low: [0, 1].map(|k| self.low[k].max(other.low[k])), high: [0, 1].map(|k| self.high[k].min(other.high[k])) }
    }

    /// Width and height.
    pub(super) fn size(self) -> [f64; 2] {
        [0, 1].map(|k| self.high[k] - self.low[k])
    }

    /// From corner to corner.
    pub(super) fn diagonal(self) -> f64 {
        let [width, height] = self.size();
        width.hypot(height)
    }

    /// Width times height.
    pub(super) fn area(self) -> f64 {
        let [width, height] = self.size();
        width * height
    }

    pub(super) fn is_empty(self) -> bool {
        !(self.low[0] <= self.high[0] && self.low[1] <= self.high[1])
    }

    pub(super) fn contains(self, other: Self) -> bool {
        (0..2).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }

    /// Whether the point is inside.
    pub(super) fn holds(self, point: SketchPoint) -> bool {
        self.contains(Self { low: point, high: point })
    }
}

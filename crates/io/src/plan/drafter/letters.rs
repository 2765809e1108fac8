//! Which letters make one text? Those that follow each other on a base line.

use super::SketchPoint;

/// Letters farther from those before are another text, font sizes: columns of a table are.
const JOINED: f64 = 0.6;

/// Letters in a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::plan) struct Letters {
    /// Left end of their base line.
    pub at: SketchPoint,
    /// One font size along it.
    pub em: SketchPoint,
    /// How far they go along it, font sizes.
    pub width_em: f64,
    pub text: String,
    pub layer: String,
}

/// The last letters that were written.
pub(super) struct Written {
    pub end: SketchPoint,
    pub em: SketchPoint,
    /// Whether a blank comes before what follows.
    pub spaced: bool,
}

impl Written {
    /// Font sizes from its end to letters that go on with it, on its base line or as an exponent.
    pub(super) fn gap_to(&self, piece: &Letters) -> Option<f64> {
        let square = self.em[0] * self.em[0] + self.em[1] * self.em[1];
        let step = [0, 1].map(|k| piece.at[k] - self.end[k]);
        let along = (step[0] * self.em[0] + step[1] * self.em[1]) / square;
        let raised = (step[1] * self.em[0] - step[0] * self.em[1]) / square;
        let alike = (piece.em[0] * self.em[0] + piece.em[1] * self.em[1]) / square;
        let turned = (piece.em[1] * self.em[0] - piece.em[0] * self.em[1]).abs() / square;
        let same_line = raised.abs() < 0.1 && (0.9..1.1).contains(&alike);
        let exponent = (0.1..0.6).contains(&raised) && (0.4..0.9).contains(&alike);
        (turned < 0.02 && (same_line || exponent) && (-JOINED..JOINED).contains(&along)).then_some(along)
    }
}

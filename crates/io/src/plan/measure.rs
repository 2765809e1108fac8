//! How long is something in the picture? `u1,v1,u2,v2=3.6m`: two points in pixels, and the length between them.

use std::str::FromStr;

/// Two points of a picture and the true length between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// Column and row of one point, pixels from the top left corner.
    pub from_px: (f64, f64),
    /// Column and row of the other.
    pub to_px: (f64, f64),
    /// Length between them, metres.
    pub length_m: f64,
}

impl Measure {
    /// The scale that follows.
    pub fn metres_per_pixel(&self) -> f64 {
        self.length_m / (self.to_px.0 - self.from_px.0).hypot(self.to_px.1 - self.from_px.1)
    }
}

/// Measures that differ by more than this share are told: hands and drawings are better.
const DISAGREE: f64 = 0.03;

/// The scale that several measures give together, the longer ones counting more; `None` where there are none. With a note where they
/// disagree.
pub(super) fn together(measures: &[Measure], notes: &mut Vec<String>) -> Option<f64> {
    let scales = || measures.iter().map(Measure::metres_per_pixel);
    let (least, most) = scales().fold((f64::INFINITY, 0.0), |(l, m): (f64, f64), s| (l.min(s), m.max(s)));
    let difference = most / least - 1.0;
    if difference > DISAGREE {
        let all: Vec<String> = scales().map(|scale| format!("{scale:.5}")).collect();
        notes.push(format!(
            "the measured lengths disagree by {:.0} % ({} m a pixel): is one mistaken, or is the picture stretched?",
            100.0 * difference,
            all.join(" and ")
        ));
    }
    let metres: f64 = measures.iter().map(|measure| measure.length_m).sum();
    let pixels: f64 = measures.iter().map(|measure| measure.length_m / measure.metres_per_pixel()).sum();
    (!measures.is_empty()).then_some(metres / pixels)
}

/// Why a text is no [`Measure`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// Not the form that is understood.
    #[error("\"{text}\" is no measure: write u1,v1,u2,v2=3.6m, four pixel coordinates and a length in m, cm, mm, ft or in")]
    Form {
        /// What was given.
        text: String,
    },
    /// Two points that are one, or a length that is none.
    #[error("a length of {length_m} m over {pixels} px gives no scale: both must be above zero")]
    NoLength {
        /// The length.
        length_m: f64,
        /// Distance of the points.
        pixels: f64,
    },
}

/// Names and metres of the units that are understood; longer names first where one ends like another.
const UNITS: [(&str, f64); 8] =
    [("mm", 0.001), ("cm", 0.01), ("m", 1.0), ("ft", 0.3048), ("feet", 0.3048), ("'", 0.3048), ("in", 0.0254), ("\"", 0.0254)];

impl std::fmt::Display for Measure {
    /// As it can be given again.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ((u1, v1), (u2, v2)) = (self.from_px, self.to_px);
        write!(f, "{u1},{v1},{u2},{v2}={}m", self.length_m)
    }
}

impl FromStr for Measure {
    type Err = MeasureError;

    fn from_str(text: &str) -> Result<Self, MeasureError> {
        let form = || MeasureError::Form { text: text.to_owned() };
        let (points, length) = text.split_once('=').ok_or_else(form)?;
        let number = |s: &str| s.trim().parse().ok().filter(|v: &f64| v.is_finite());
        let points: Vec<f64> = points.split(',').map(number).collect::<Option<_>>().ok_or_else(form)?;
        let [u1, v1, u2, v2] = points[..] else { return Err(form()) };
        let length = length.trim();
        let in_unit = |(name, metres): &(&str, f64)| Some(number(length.strip_suffix(name)?)? * metres);
        let length_m = UNITS.iter().find_map(in_unit).ok_or_else(form)?;
        let pixels = (u2 - u1).hypot(v2 - v1);
        if !(length_m > 0.0 && pixels > 0.0) {
            return Err(MeasureError::NoLength { length_m, pixels });
        }
        Ok(Self { from_px: (u1, v1), to_px: (u2, v2), length_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_come_in_the_units_of_drawings() {
        let scale = |text: &str| text.parse::<Measure>().unwrap().metres_per_pixel();
        for text in ["0,0,30,40=5m", "0,0,30,40=500 cm", "0,0,30,40 = 5000mm", "30,40,0,0=5.0m"] {
            assert!((scale(text) - 0.1).abs() < 1e-15, "{text}");
        }
        for text in ["0,0,100,0=10ft", "0,0,100,0=10'", "0,0,100,0=10 feet", "0,0,100,0=120in", "0,0,0,100=120\""] {
            assert!((scale(text) - 0.03048).abs() < 1e-15, "{text}");
        }
    }

    #[test]
    fn what_is_no_measure_is_refused() {
        for text in ["", "3.6m", "1,2,3=4m", "1,2,3,4=5", "1,2,3,4=m", "1,2,3,x=4m", "1,2,3,nan=4m", "1,2,3,4,5=4m"] {
            assert!(matches!(text.parse::<Measure>(), Err(MeasureError::Form { .. })), "{text}");
        }
        assert!(matches!("1,2,1,2=4m".parse::<Measure>(), Err(MeasureError::NoLength { .. })));
        assert!(matches!("1,2,3,4=-4m".parse::<Measure>(), Err(MeasureError::NoLength { .. })));
    }
}

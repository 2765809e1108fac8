//! Which scale is written on a drawing? "Scale 1:100", if it is the only one.

use super::super::sketch::Sketch;
use super::Witness;

/// Floor plans are drawn to these scales; others on a sheet are dates, ratios or details.
const USUAL_SCALES: [f64; 8] = [20.0, 25.0, 50.0, 75.0, 100.0, 200.0, 250.0, 500.0];
/// Prints and exports stretch by as much, as a share.
const SIGMA: f64 = 0.005;

pub(super) fn witness(sketch: &Sketch, paper_m: f64) -> Option<Witness> {
    let scale = written_scale(sketch)?;
    Some(Witness {
        metres: scale * paper_m,
        sigma: SIGMA,
        from: "the drawing's own words",
        says: format!("its own words, 1:{scale}, say"),
        remark: ", if it was never enlarged or reduced",
    })
}

/// As 100 of 1:100; `None` where there is none, or several.
fn written_scale(sketch: &Sketch) -> Option<f64> {
    let mut found: Vec<f64> = sketch.texts.iter().flat_map(|text| scales_in(&text.text)).collect();
    found.sort_by(f64::total_cmp);
    found.dedup();
    if let [scale] = found[..] { Some(scale) } else { None }
}

/// All "1:100", "1 : 50", "1/200" in a text that are usual scales of floor plans.
fn scales_in(text: &str) -> Vec<f64> {
    let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    // No other digit goes before the 1, nor a decimal point with one before it.
    let is_digit = |c: char| c.is_ascii_digit();
    let ends_alone = |before: &str| {
        before
            .strip_suffix('1')
            .is_some_and(|rest| !rest.ends_with(is_digit) && !rest.strip_suffix('.').is_some_and(|r| r.ends_with(is_digit)))
    };
    let scale = |(at, _): (usize, &str)| {
        let digits: String = bare[at + 1..].chars().take_while(|c| is_digit(*c)).collect();
        digits.parse().ok().filter(|scale: &f64| ends_alone(&bare[..at]) && USUAL_SCALES.contains(scale))
    };
    bare.match_indices([':', '/']).filter_map(scale).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::sketch::SketchText;
    use super::*;

    #[test]
    fn a_scale_that_is_written_on_a_drawing_is_understood_if_it_is_the_only_one() {
        let saying = |texts: &[&str]| {
            let text = |text: &&str| SketchText { at: [0.0; 2], height: 1.0, text: (*text).to_owned(), layer: String::new() };
            written_scale(&Sketch { texts: texts.iter().map(text).collect(), ..Sketch::default() })
        };
        for (texts, scale) in [
            (&["Scale 1:100"][..], Some(100.0)),
            (&["M 1 : 50 (A1)", "Erdgeschoss", "1:50"], Some(50.0)),
            (&["ech. 1/200"], Some(200.0)),
            (&["1:100", "Detail 1:20"], None),
            (&["11:50 h", "21/25", "4.1:100", "1:37", "1:", "x1", ""], None),
        ] {
            assert_eq!(saying(texts), scale, "{texts:?}");
        }
    }
}

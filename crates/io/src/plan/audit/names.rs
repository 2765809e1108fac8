//! Which of the texts on a drawing are names of rooms? Words and numbers that stand in one; no dimensions, areas or scales.

use planwalk_types::{Element, ElementKind, Form, Plan, Pt2};

use super::super::sketch::{Sketch, SketchText};

/// Longest name, characters; longer texts are notes.
const LONGEST: usize = 40;
/// Most texts that make up a name: a number, a use, a second line.
const PARTS: usize = 3;
/// More bare numbers in a room than this are dimensions.
const NUMBERS: usize = 2;
/// A letter's width, in letter heights, as fonts have it.
const LETTER_WIDTH: f64 = 0.6;
/// Endings and marks of measures.
const MEASURES: [&str; 10] = ["m²", "m2", "qm", "m³", "sq", "sf", "ft", " m", "mm", "cm"];

/// A text in a room.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::plan) struct Written {
    pub at: Pt2<Plan>,
    pub text: String,
}

/// The drawing's texts that could be names, as rooms of which only a place is known: the middle of each text.
pub(in crate::plan) fn labels(sketch: &Sketch, metres_per_unit: f64) -> Vec<Element> {
    let label = |text: &SketchText| {
        let words = text.text.split_whitespace().collect::<Vec<_>>().join(" ");
        let half = 0.5 * LETTER_WIDTH * text.height * words.chars().count() as f64;
        let at = Pt2::new((text.at[0] + half) * metres_per_unit, (text.at[1] + 0.5 * text.height) * metres_per_unit);
        let could_be = Sort::of(&words) != Sort::Other && at.x.is_finite() && at.y.is_finite();
        could_be.then(|| Element { name: Some(words), ..Element::new(ElementKind::Room, Form::Spot(at)) })
    };
    sketch.texts.iter().filter_map(label).collect()
}

/// What a text could be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sort {
    /// Has letters: a use, or a number such as A135.
    Words,
    /// A whole number.
    Number,
    /// A number with a point: a room's (1.05), or a dimension.
    Decimal,
    Other,
}

impl Sort {
    fn of(text: &str) -> Self {
        let text = text.trim();
        let lower = text.to_lowercase();
        let count = text.chars().count();
        let has = |is: fn(char) -> bool| text.chars().any(is);
        let is_measure = has(|c| c.is_ascii_digit()) && MEASURES.iter().any(|m| lower.ends_with(m) || lower.contains(&format!("{m} ")));
        if count == 0 || count > LONGEST || is_measure || has(|c| matches!(c, '=' | '%' | '°' | 'Ø' | '±' | '²')) {
            return Self::Other;
        }
        // An axis of the grid has a letter, and so has everything that was abbreviated beyond recognition.
        if has(char::is_alphabetic) {
            return if count > 1 && !is_ratio(text) { Self::Words } else { Self::Other };
        }
        let parts: Vec<&str> = text.split(['.', ',']).collect();
        let digits = parts.iter().all(|part| !part.is_empty() && part.chars().all(|c| c.is_ascii_digit()));
        match (digits, parts.len()) {
            (true, 1) if count <= 4 => Self::Number,
            (true, 2) => Self::Decimal,
            // 0.01.15: building, storey, room.
            (true, 3) => Self::Words,
            _ => Self::Other,
        }
    }
}

/// A scale: 1:100.
fn is_ratio(text: &str) -> bool {
    text.split(':').count() == 2 && text.split(':').all(|part| part.trim().chars().any(|c| c.is_ascii_digit()))
}

/// The name of each room, of what is written in each.
pub(super) fn choose(written: Vec<Vec<Written>>) -> Vec<Option<String>> {
    let decimals_are_names = are_names(&written);
    written
        .into_iter()
        .map(|mut texts| {
            let numbers = texts.iter().filter(|w| Sort::of(&w.text) == Sort::Number).count();
            texts.retain(|w| match Sort::of(&w.text) {
                Sort::Words => true,
                Sort::Number => numbers <= NUMBERS,
                Sort::Decimal => decimals_are_names,
                Sort::Other => false,
            });
            // As one reads: from the top, and from the left.
            texts.sort_by(|a, b| b.at.y.total_cmp(&a.at.y).then(a.at.x.total_cmp(&b.at.x)));
            texts.dedup_by(|a, b| a.text == b.text);
            let parts: Vec<String> = texts.into_iter().take(PARTS).map(|w| w.text).collect();
            (!parts.is_empty()).then(|| parts.join(" "))
        })
        .collect()
}

/// Whether numbers with a point name rooms on this storey: at most one a room, all different, all beginning alike, with two digits or
/// three behind the point.
fn are_names(written: &[Vec<Written>]) -> bool {
    let decimals = |texts: &[Written]| -> Vec<String> {
        texts.iter().filter(|w| Sort::of(&w.text) == Sort::Decimal).map(|w| w.text.replace(',', ".")).collect()
    };
    let by_room: Vec<Vec<String>> = written.iter().map(|texts| decimals(texts)).collect();
    let mut all: Vec<&str> = by_room.iter().flatten().map(String::as_str).collect();
    let before = |text: &&str| text.split('.').next().unwrap_or("").to_owned();
    let behind = |text: &&str| text.split('.').nth(1).unwrap_or("").len();
    let alike = all.windows(2).all(|pair| before(&pair[0]) == before(&pair[1]) && behind(&pair[0]) == behind(&pair[1]));
    let count = all.len();
    let usual = all.iter().all(|text| (2..=3).contains(&behind(text)));
    all.sort_unstable();
    all.dedup();
    by_room.iter().all(|texts| texts.len() <= 1) && alike && usual && all.len() == count && count > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(rooms: &[&[&str]]) -> Vec<Option<String>> {
        let texts = |texts: &&[&str]| {
            let written = |(n, text): (usize, &&str)| Written { at: Pt2::new(0.0, -(n as f64)), text: (*text).to_owned() };
            texts.iter().enumerate().map(written).collect()
        };
        choose(rooms.iter().map(texts).collect())
    }

    #[test]
    fn a_room_is_called_by_its_number_and_its_use() {
        for (texts, name) in [
            (&["A135"][..], Some("A135")),
            (&["101", "Küche"], Some("101 Küche")),
            (&["Office", "Office"], Some("Office")),
            (&["EG.01.15"], Some("EG.01.15")),
            (&["Lager", "12.5 m²", "3.60", "1:100", "h=2.50", "B"], Some("Lager")),
            (&["12,50 qm", "24 m2"], None),
            (&["3600", "2400", "885"], None),
            (&[], None),
        ] {
            assert_eq!(named(&[texts]), [name.map(str::to_owned)], "{texts:?}");
        }
    }

    #[test]
    fn numbers_with_a_point_are_names_only_where_all_of_them_look_so() {
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(named(&[&["1.01"], &["1.02"], &[]]), [some("1.01"), some("1.02"), None]);
        // Dimensions: two in a room, or of rooms that are not numbered through.
        assert_eq!(named(&[&["1.01", "1.26"], &["1.02"]]), [None, None]);
        assert_eq!(named(&[&["3.60"], &["2.40"]]), [None, None]);
        assert_eq!(named(&[&["3.60"], &["3.60"]]), [None, None]);
    }

    #[test]
    fn texts_stand_where_their_middles_are() {
        let text = |text: &str| SketchText { at: [100.0, 50.0], height: 10.0, text: text.to_owned(), layer: String::new() };
        let sketch = Sketch { texts: vec![text("A  135"), text("3.60 m"), text("")], ..Sketch::default() };
        let labels = labels(&sketch, 0.01);
        assert_eq!(labels.len(), 1);
        assert_eq!(labels[0].name.as_deref(), Some("A 135"));
        // Five letters of 6 units each: their middle is 15 units on.
        assert_eq!(labels[0].form, Form::Spot(Pt2::new((100.0 + 0.5 * 0.6 * 10.0 * 5.0) * 0.01, 0.55)));
    }
}

//! How does a written plan spell numbers, texts and objects? Few decimals, JSON's escapes, one line each.
//!
//! The same values always give the same bytes: versions of a plan can be compared line by line.

use std::fmt::Write;

use planwalk_types::{Element, Plan, Pt2};

/// Decimals of metres: 0.1 mm, a tenth of what a laser distance meter tells.
pub(super) const METRE_DECIMALS: usize = 4;
/// Farthest coordinate that is written or read, metres: as of drawing. Doubles still tell 0.1 µm there.
pub(super) const FARTHEST_M: f64 = 1e9;

/// Appends a number with at most so many decimals; neither `-0` nor zeros at the end.
pub(super) fn push_decimal(out: &mut String, value: f64, decimals: usize) {
    let start = out.len();
    // Writing to a string does not fail.
    let _ = write!(out, "{value:.decimals$}");
    if out.get(start..).is_some_and(|digits| digits.contains('.')) {
        out.truncate(out.trim_end_matches('0').trim_end_matches('.').len());
    }
    if out.get(start..) == Some("-0") {
        out.truncate(start);
        out.push('0');
    }
}

/// Such a number alone.
pub(super) fn decimal(value: f64, decimals: usize) -> String {
    let mut out = String::new();
    push_decimal(&mut out, value, decimals);
    out
}

/// A text as JSON has it, with its quotes.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A JSON object on one line, of those members that have a value; values are JSON already.
pub(super) fn object<const N: usize>(members: [(&str, Option<String>); N]) -> String {
    let present = members.into_iter().filter_map(|(key, value)| value.map(|value| format!("\"{key}\": {value}")));
    format!("{{{}}}", present.collect::<Vec<_>>().join(", "))
}

/// A JSON list of what `push` appends for each.
pub(super) fn push_list<T>(out: &mut String, items: &[T], mut push: impl FnMut(&mut String, &T)) {
    out.push('[');
    for (i, item) in items.iter().enumerate() {
        if i > 0 {
            out.push(',');
        }
        push(out, item);
    }
    out.push(']');
}

/// Appends `[x,y]`.
pub(super) fn push_position(out: &mut String, at: [f64; 2], decimals: usize) {
    push_list(out, &at, |out, value| push_decimal(out, *value, decimals));
}

/// Whether this can be written: finite, and no farther than [`FARTHEST_M`].
pub(super) fn is_near(point: Pt2<Plan>) -> bool {
    point.x.abs() <= FARTHEST_M && point.y.abs() <= FARTHEST_M
}

/// Whether all of an element can be written.
pub(super) fn can_be_written(element: &Element) -> bool {
    element.form.points().all(is_near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_have_no_more_digits_than_they_need() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (-0.00004, "0"),
            (4.0, "4"),
            (100.0, "100"),
            (1.5, "1.5"),
            (-2.25, "-2.25"),
            (0.1 + 0.2, "0.3"),
            (5_932_800.123_44, "5932800.1234"),
        ] {
            assert_eq!(decimal(value, METRE_DECIMALS), text);
        }
        assert_eq!(decimal(1200.0, 0), "1200");
    }

    #[test]
    fn objects_leave_out_what_is_not_there_and_texts_are_escaped() {
        let line = object([("kind", Some(quoted("door"))), ("name", None), ("source", Some(quoted("a \"b\"\n")))]);
        assert_eq!(line, r#"{"kind": "door", "source": "a \"b\"\n"}"#);
    }

    proptest! {
        #[test]
        fn metres_are_rounded_to_a_tenth_of_a_millimetre(value in -FARTHEST_M..FARTHEST_M) {
            let read: f64 = decimal(value, METRE_DECIMALS).parse().unwrap();
            // Half a unit of the last decimal, and the doubles' own spacing at 1e9.
            prop_assert!((read - value).abs() < 0.5e-4 + 2e-7);
        }
    }
}

//! What do the dictionaries of a page say? Metres of a measure, names of layers.

use hayro_interpret::hayro_syntax::object::{Array, Dict, Object, String as PdfString};

/// Metres in a point, where all measuring viewports of the page say the same (ISO 32000-1, 12.9: rectilinear measures).
pub(super) fn metres_per_point(page: &Dict) -> Option<f64> {
    let viewports = page.get::<Array>(b"VP")?;
    let mut scales = viewports.iter::<Dict>().filter_map(|viewport| {
        let measure = viewport.get::<Dict>(b"Measure")?;
        let along_x = measure.get::<Array>(b"X")?.iter::<Dict>().next()?;
        let metres = match text_of(&along_x.get::<PdfString>(b"U")?).trim() {
            "mm" => 1e-3,
            "cm" => 1e-2,
            "m" => 1.0,
            "km" => 1e3,
            "in" | "\"" => 0.0254,
            "ft" | "'" => 0.3048,
            "yd" => 0.9144,
            _ => return None,
        };
        along_x.get::<f64>(b"C").map(|per_point| per_point * metres).filter(|scale| *scale > 0.0 && scale.is_finite())
    });
    let first = scales.next()?;
    // Viewports of one scale differ by what was rounded.
    scales.all(|scale| (scale / first - 1.0).abs() < 1e-3).then_some(first)
}

/// Text of a name or a unit: UTF-16 with its mark, else what is taken as UTF-8.
fn text_of(bytes: &[u8]) -> String {
    match bytes.strip_prefix(b"\xfe\xff") {
        Some(wide) => {
            let units = wide.chunks_exact(2).map(|pair| pair.iter().fold(0, |unit, byte| (unit << 8) | u16::from(*byte)));
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
        }
        None => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// Names of a content group, or of the groups of a membership.
pub(super) fn group_names(properties: &Dict) -> Vec<String> {
    let name = |group: &Dict| group.get::<PdfString>(b"Name").map(|name| text_of(&name));
    match properties.get::<Object>(b"OCGs") {
        Some(Object::Dict(group)) => name(&group).into_iter().collect(),
        Some(Object::Array(groups)) => groups.iter::<Dict>().filter_map(|group| name(&group)).take(8).collect(),
        _ => name(properties).into_iter().collect(),
    }
}

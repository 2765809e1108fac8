//! What does an element of the XML say? Its name, attributes and links, lengths in pixels, and numbers too large to be drawn.

use usvg::roxmltree::Node;

use super::{SVG, XLINK};

/// Name of an element of SVG, else nothing.
pub(super) fn name<'a>(node: Node<'a, '_>) -> &'a str {
    let tag = node.tag_name();
    if node.is_element() && tag.namespace().is_none_or(|space| space == SVG) { tag.name() } else { "" }
}

/// An attribute without a namespace.
pub(super) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attributes().find(|a| a.name() == name && a.namespace().is_none()).map(|a| a.value())
}

/// What a `use` or a gradient links to, if it is in this file.
pub(super) fn link<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let old = || node.attributes().find(|a| a.name() == "href" && a.namespace() == Some(XLINK)).map(|a| a.value());
    attribute(node, "href").or_else(old)?.trim().strip_prefix('#')
}

/// A length as pixels of 96 an inch; shares of something and sizes of fonts are none.
pub(super) fn pixels(length: &str) -> Option<f64> {
    let length = length.trim();
    let digits = length.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E') || c == '%').unwrap_or(length.len());
    let (number, unit) = length.split_at_checked(digits)?;
    let scale = match unit {
        "" | "px" => 1.0,
        "in" => 96.0,
        "cm" => 96.0 / 2.54,
        "mm" => 96.0 / 25.4,
        "pt" => 96.0 / 72.0,
        "pc" => 16.0,
        _ => return None,
    };
    number.trim().parse::<f64>().ok().map(|v| v * scale).filter(|v| v.is_finite())
}

/// Whether a shape has numbers of 1e9 and more. usvg makes millions of curves of an arc of 1e38, and there is no such plan.
pub(super) fn is_far(shape: Node) -> bool {
    const GEOMETRY: [&str; 15] = ["d", "points", "x", "y", "width", "height", "r", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2"];
    shape.attributes().filter(|a| GEOMETRY.contains(&a.name())).any(|a| has_far_number(a.value()))
}

/// Ten digits before the point, or an exponent of 9 and more.
pub(super) fn has_far_number(text: &str) -> bool {
    let (mut digits, mut fraction, mut exponent) = (0, false, false);
    let mut power = 0u32;
    for c in text.chars() {
        match c {
            '0'..='9' if exponent => power = power.saturating_mul(10).saturating_add(u32::from(c) - u32::from('0')),
            '0' if digits == 0 => {}
            '0'..='9' if !fraction => digits += 1,
            '0'..='9' => {}
            'e' | 'E' => exponent = true,
            '+' if exponent && power == 0 => {}
            c => (digits, fraction, exponent, power) = (0, c == '.', false, 0),
        }
        if digits > 9 || power > 8 {
            return true;
        }
    }
    false
}

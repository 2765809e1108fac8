//! How do texts of a drawing get into a picture where there are no fonts? They become strokes, as all of our letters are.

use super::font;

/// Height of capitals, of a font's size.
const CAPITALS: f64 = 0.7;
/// Width of a stroke, of a font's size.
const STROKE: f64 = 0.06;

/// The drawing with its texts as strokes. Understood are texts on a line of their own with `x`, `y`, `font-size` and `fill`, and
/// `text-anchor` where it is not `start`; other texts stay as they are.
pub fn lettered(svg: &str) -> String {
    let mut out = String::with_capacity(2 * svg.len());
    for line in svg.split_inclusive('\n') {
        match strokes(line.trim()) {
            Some(strokes) => out.push_str(&strokes),
            None => out.push_str(line),
        }
    }
    out
}

fn strokes(line: &str) -> Option<String> {
    let (head, rest) = line.strip_prefix("<text ")?.split_once('>')?;
    let text = plain(rest.strip_suffix("</text>")?);
    let attribute = |name: &str| {
        let begin = format!("{name}=\"");
        head.split_whitespace().find_map(|part| part.strip_prefix(begin.as_str()).and_then(|value| value.strip_suffix('"')))
    };
    let number = |name: &str| attribute(name)?.parse::<f64>().ok().filter(|value| value.is_finite());
    let (x, y, size, fill) = (number("x")?, number("y")?, number("font-size")?, attribute("fill")?);
    let width = font::width_px(&text, CAPITALS * size);
    let left = match attribute("text-anchor") {
        Some("middle") => x - 0.5 * width,
        Some("end") => x - width,
        _ => x,
    };
    let data = font::path_data(&text, left, y, CAPITALS * size);
    let (round, stroke) = ("stroke-linecap=\"round\" stroke-linejoin=\"round\"", STROKE * size);
    Some(format!("<path d=\"{data}\" fill=\"none\" stroke=\"{fill}\" stroke-width=\"{stroke:.3}\" {round}/>\n"))
}

/// What XML's marks stand for.
fn plain(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_becomes_strokes_where_it_stood() {
        let text = |anchor: &str| {
            lettered(&format!("<svg>\n<text x=\"100\" y=\"50\" font-size=\"20\"{anchor} fill=\"#222222\">A&amp;B</text>\n</svg>\n"))
        };
        let at_start = text("");
        assert!(at_start.starts_with("<svg>\n<path d=\"M") && at_start.ends_with("</svg>\n") && !at_start.contains("<text"), "{at_start}");
        assert_ne!(text(" text-anchor=\"middle\""), at_start);
        assert_eq!(text(" text-anchor=\"start\""), at_start);
    }

    #[test]
    fn other_texts_stay_as_they_are() {
        for svg in ["<text>a</text>\n", "<text x=\"a\" y=\"0\" font-size=\"1\" fill=\"red\">a</text>", "<g><text x=\"1\"/></g>", ""] {
            assert_eq!(lettered(svg), svg);
        }
    }
}

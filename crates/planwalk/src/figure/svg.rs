//! How does a drawing become SVG? A small writer: shapes go in, text comes out; numbers have two decimals.

use std::fmt::Write as _;

use super::font;

/// Which side of its anchor a text stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    /// The anchor is at its left end.
    Left,
    /// The anchor is at its middle.
    Middle,
    /// The anchor is at its right end.
    Right,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen<'a> {
    /// Any SVG colour.
    pub colour: &'a str,
    /// Pixels.
    pub width_px: f64,
    /// 0..=1.
    pub opacity: f64,
    /// SVG dash pattern; empty for a whole line.
    pub dash: &'a str,
}

impl<'a> Pen<'a> {
    /// A whole, opaque line.
    pub(super) const fn new(colour: &'a str, width_px: f64) -> Self {
        Self { colour, width_px, opacity: 1.0, dash: "" }
    }

    /// The same, seen through.
    pub(super) const fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The same, dashed.
    pub(super) const fn dashed(self, dash: &'a str) -> Self {
        Self { dash, ..self }
    }

    fn attributes(&self) -> String {
        let mut out = format!(r#"fill="none" stroke="{}" stroke-width="{}""#, self.colour, number(self.width_px));
        if self.opacity < 1.0 {
            let _ = write!(out, r#" stroke-opacity="{}""#, number(self.opacity));
        }
        if !self.dash.is_empty() {
            let _ = write!(out, r#" stroke-dasharray="{}""#, self.dash);
        }
        out
    }
}

/// A drawing in the making. Pixels, x right, y down.
#[derive(Debug)]
pub(super) struct Svg {
    name: &'static str,
    width_px: f64,
    height_px: f64,
    title: String,
    body: String,
    clips: usize,
}

impl Svg {
    /// An empty white sheet. `name` goes into ids, so that drawings can stand on one page.
    pub(super) fn new(name: &'static str, width_px: f64, height_px: f64, title: &str) -> Self {
        let mut svg = Self { name, width_px, height_px, title: escape(title), body: String::new(), clips: 0 };
        svg.rect(0.0, 0.0, width_px, height_px, "#ffffff", 1.0);
        svg
    }

    /// A filled rectangle.
    pub(super) fn rect(&mut self, x: f64, y: f64, width: f64, height: f64, fill: &str, opacity: f64) {
        let opacity = if opacity < 1.0 { format!(r#" fill-opacity="{}""#, number(opacity)) } else { String::new() };
        let (x, y, w, h) = (number(x), number(y), number(width), number(height));
        let _ = writeln!(self.body, r#"<rect x="{x}" y="{y}" width="{w}" height="{h}" fill="{fill}"{opacity}/>"#);
    }

    /// A rectangle's outline.
    pub(super) fn frame(&mut self, x: f64, y: f64, width: f64, height: f64, pen: Pen) {
        self.polyline(&[(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)], pen);
    }

    /// A line through points.
    pub(super) fn polyline(&mut self, points: &[(f64, f64)], pen: Pen) {
        if points.len() < 2 {
            return;
        }
        let _ = writeln!(self.body, r#"<path d="{}" {}/>"#, line_data(points), pen.attributes());
    }

    /// A straight line.
    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), pen: Pen) {
        self.polyline(&[from, to], pen);
    }

    /// A filled shape with an outline.
    pub(super) fn polygon(&mut self, points: &[(f64, f64)], fill: &str, fill_opacity: f64, pen: Pen) {
        let line = pen.attributes().replace(r#"fill="none""#, &format!(r#"fill="{fill}" fill-opacity="{}""#, number(fill_opacity)));
        let _ = writeln!(self.body, r#"<path d="{}Z" {line}/>"#, line_data(points));
    }

    /// A filled disc with an outline.
    pub(super) fn circle(&mut self, centre: (f64, f64), radius: f64, fill: &str, pen: Pen) {
        let line = pen.attributes().replace(r#"fill="none""#, &format!(r#"fill="{fill}""#));
        let (x, y, r) = (number(centre.0), number(centre.1), number(radius));
        let _ = writeln!(self.body, r#"<circle cx="{x}" cy="{y}" r="{r}" {line}/>"#);
    }

    /// Filled path data in other coordinates: `transform` is SVG's own.
    pub(super) fn filled(&mut self, data: &str, transform: &str, fill: &str, opacity: f64) {
        if !data.is_empty() {
            let _ = writeln!(self.body, r#"<path d="{data}" transform="{transform}" fill="{fill}" fill-opacity="{}"/>"#, number(opacity));
        }
    }

    /// Small squares around points, all in one shape: thousands of them stay a small file.
    pub(super) fn dots(&mut self, centres: impl Iterator<Item = (f64, f64)>, side: f64, fill: &str, opacity: f64) {
        let mut data = String::new();
        let width = number(side);
        for (x, y) in centres.filter(|c| c.0.is_finite() && c.1.is_finite()) {
            let _ = write!(data, "M{:.1} {:.1}h{width}v{width}h-{width}z", x - 0.5 * side, y - 0.5 * side);
        }
        self.filled(&data, "translate(0 0)", fill, opacity);
    }

    /// One line of text, its baseline at `y`; capitals are `size_px` high. Readers that cannot see hear the same words.
    pub(super) fn text(&mut self, text: &str, at: (f64, f64), size_px: f64, anchor: Anchor, colour: &str) {
        self.text_with_weight(text, at, size_px, anchor, colour, 0.125);
    }

    /// The same, with heavy strokes.
    pub(super) fn bold(&mut self, text: &str, at: (f64, f64), size_px: f64, anchor: Anchor, colour: &str) {
        self.text_with_weight(text, at, size_px, anchor, colour, 0.2);
    }

    /// Text on a white halo, for labels on top of lines.
    pub(super) fn label(&mut self, text: &str, at: (f64, f64), size_px: f64, anchor: Anchor, colour: &str) {
        let data = font::path_data(text, left_end(text, at.0, size_px, anchor), at.1, size_px);
        let halo = number(0.6 * size_px);
        let _ = writeln!(self.body, r##"<path d="{data}" fill="none" stroke="#ffffff" stroke-opacity="0.85" stroke-width="{halo}"/>"##);
        self.text_with_weight(text, at, size_px, anchor, colour, 0.14);
    }

    fn text_with_weight(&mut self, text: &str, at: (f64, f64), size_px: f64, anchor: Anchor, colour: &str, weight: f64) {
        let data = font::path_data(text, left_end(text, at.0, size_px, anchor), at.1, size_px);
        let (words, width) = (escape(text), number(weight * size_px));
        let _ = writeln!(
            self.body,
            r#"<g role="img" aria-label="{words}"><path d="{data}" fill="none" stroke="{colour}" stroke-width="{width}"/></g>"#
        );
    }

    /// What follows, up to [`Svg::end_clip`], shows inside this rectangle only.
    pub(super) fn begin_clip(&mut self, x: f64, y: f64, width: f64, height: f64) {
        self.clips += 1;
        let id = format!("{}-clip{}", self.name, self.clips);
        let (x, y, w, h) = (number(x), number(y), number(width), number(height));
        let _ = writeln!(self.body, r#"<clipPath id="{id}"><rect x="{x}" y="{y}" width="{w}" height="{h}"/></clipPath>"#);
        let _ = writeln!(self.body, r#"<g clip-path="url(#{id})">"#);
    }

    /// Ends the clip.
    pub(super) fn end_clip(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// The whole drawing.
    pub(super) fn finish(self) -> String {
        let (w, h) = (number(self.width_px), number(self.height_px));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<title>{}</title>\n{}</svg>\n",
            self.title, self.body
        )
    }
}

fn left_end(text: &str, x: f64, size_px: f64, anchor: Anchor) -> f64 {
    match anchor {
        Anchor::Left => x,
        Anchor::Middle => x - 0.5 * font::width_px(text, size_px),
        Anchor::Right => x - font::width_px(text, size_px),
    }
}

fn line_data(points: &[(f64, f64)]) -> String {
    let mut data = String::with_capacity(12 * points.len());
    for (i, (x, y)) in points.iter().enumerate() {
        let command = if i == 0 { 'M' } else { 'L' };
        let _ = write!(data, "{command}{} {}", number(*x), number(*y));
    }
    data
}

/// A number with at most two decimals; what is not finite is 0, so that a drawing stays a drawing.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "0".to_owned();
    }
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text that can stand in XML and HTML, between tags and in attributes. Control characters, which XML forbids, become spaces.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if c.is_control() && c != '\n' && c != '\t' => out.push(' '),
            '\u{fffe}' | '\u{ffff}' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let pairs = [(1.0, "1"), (1.005, "1"), (0.125, "0.12"), (-0.001, "0"), (12.5, "12.5"), (f64::NAN, "0"), (100.0, "100")];
        for (value, text) in pairs {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn hostile_text_stays_text() {
        assert_eq!(escape("<script>'\"&\u{1}"), "&lt;script&gt;&#39;&quot;&amp; ");
    }

    #[test]
    fn a_drawing_reads_like_this() {
        let mut svg = Svg::new("test", 40.0, 20.0, "a & b");
        svg.line((0.0, 0.0), (10.5, 5.0), Pen::new("#123456", 1.5).dashed("4 2").faint(0.5));
        svg.circle((5.0, 5.0), 2.0, "#ff0000", Pen::new("#ffffff", 1.0));
        svg.text("1", (3.0, 18.0), 14.0, Anchor::Left, "#000000");
        let expected = concat!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"20\" viewBox=\"0 0 40 20\" ",
            "stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<title>a &amp; b</title>\n",
            "<rect x=\"0\" y=\"0\" width=\"40\" height=\"20\" fill=\"#ffffff\"/>\n",
            "<path d=\"M0 0L10.5 5\" fill=\"none\" stroke=\"#123456\" stroke-width=\"1.5\" stroke-opacity=\"0.5\" ",
            "stroke-dasharray=\"4 2\"/>\n",
            "<circle cx=\"5\" cy=\"5\" r=\"2\" fill=\"#ff0000\" stroke=\"#ffffff\" stroke-width=\"1\"/>\n",
            "<g role=\"img\" aria-label=\"1\"><path d=\"M4 7L7 4L7 18\" fill=\"none\" stroke=\"#000000\" stroke-width=\"1.75\"/></g>\n",
            "</svg>\n"
        );
        assert_eq!(svg.finish(), expected);
    }
}

//! What was taken for what? A storey for people to look at: rooms in pale colours with names, doors, findings as numbered marks, a
//! legend and a scale bar.
//!
//! Frame: SVG units are millimetres, y down, as in [`super::svg`]; but this drawing is not meant to be read again.

use std::fmt::Write;

use planwalk_types::{Element, ElementKind, Form, Level};

use super::super::audit::{Audit, Finding};
use super::super::notation::decimal;
use super::svg::{LETTER_WIDTH, Sheet, escaped, label_place};

/// Kinds from below to above, with the colours of insides and lines.
const KINDS: [(ElementKind, &str, &str); 7] = [
    (ElementKind::Floor, "#f1eee8", "#c9c3b6"),
    (ElementKind::Room, "#e4ecf7", "#b0b8c4"),
    (ElementKind::Stairs, "#bfe3b4", "#6fa65e"),
    (ElementKind::Lift, "#d9c2ee", "#8e6bb0"),
    (ElementKind::Wall, "#222222", "#222222"),
    (ElementKind::Window, "#2f7fc4", "#2f7fc4"),
    (ElementKind::Door, "#f08c1a", "#f08c1a"),
];
/// Rooms next to each other in the list differ by this much in hue, degrees: the golden angle, by which none comes back soon.
const HUE_STEP: f64 = 137.508;
const FINDING: &str = "#d4152b";
/// Marks that are drawn; more of them hide the plan. All are listed elsewhere.
const MOST_MARKS: usize = 99;
/// Names are at most so long, letters; rooms too small for their names go without.
const LONGEST: usize = 40;

/// The picture; `title` stands above it.
pub fn picture(level: &Level, audit: &Audit, title: &str) -> String {
    let sheet = Sheet::around(level);
    let page = Page::of(&sheet, level, audit);
    let mut out = page.head(title);
    for (kind, fill, line) in KINDS {
        let elements = super::elements(level).filter(|element| element.kind == kind);
        for (n, element) in elements.enumerate() {
            let pale = pale(n);
            page.push_element(&mut out, &sheet, element, if kind == ElementKind::Room { &pale } else { fill }, line);
        }
    }
    page.push_names(&mut out, &sheet, level);
    for (n, finding) in audit.findings.iter().enumerate().take(MOST_MARKS) {
        page.push_mark(&mut out, &sheet, n + 1, finding);
    }
    page.push_legend(&mut out, level, audit);
    out.push_str("</svg>\n");
    out
}

/// A pale colour for the n-th room.
fn pale(n: usize) -> String {
    let hue = (n as f64 * HUE_STEP) % 360.0;
    // Hue, chroma and a lightness near white, as red, green and blue.
    let channel = |shift: f64| {
        let k = (hue / 60.0 + shift) % 6.0;
        (255.0 * (0.97 - 0.17 * k.min(4.0 - k).clamp(0.0, 1.0))).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(5.0), channel(3.0), channel(1.0))
}

/// The paper, millimetres of the building.
struct Page {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    /// Height of a line of the legend; everything else that does not belong to the building is measured by it.
    line: f64,
    /// Thinnest line that is still seen.
    hair: f64,
}

impl Page {
    fn of(sheet: &Sheet, level: &Level, audit: &Audit) -> Self {
        let [left, lower, right, upper] = sheet.edges.map(|metres| 1e3 * metres);
        let (width, height) = (right - left, upper - lower);
        let line = width.max(height) / 55.0;
        let rows = legend(level, audit).len().div_ceil(columns(width, line)) as f64;
        Self { left, top: -upper - 1.6 * line, width, height: height + (rows + 4.2) * line, line, hair: width.max(height) / 2000.0 }
    }

    fn head(&self, title: &str) -> String {
        let [x, y, width, height] = [self.left, self.top, self.width, self.height].map(mm);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"{x} {y} {width} {height}\" \
             font-family=\"sans-serif\">\n<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
        );
        self.push_text(&mut out, [self.left + 0.5 * self.line, self.top + 1.1 * self.line], self.line, "start", "#222222", title);
        out
    }

    fn push_text(&self, out: &mut String, at: [f64; 2], size: f64, anchor: &str, colour: &str, text: &str) {
        let [x, y, size] = [at[0], at[1], size].map(mm);
        let text = escaped(text);
        let _ = writeln!(out, "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{text}</text>");
    }

    fn push_element(&self, out: &mut String, sheet: &Sheet, element: &Element, fill: &str, line: &str) {
        let is_ground = element.kind.is_ground();
        let stroke = if is_ground { self.hair } else { self.hair.max(30.0) };
        match &element.form {
            Form::Area(rings) => {
                let Some(rings) = super::rings(rings) else { return };
                out.push_str("<path d=\"");
                rings.iter().for_each(|ring| sheet.push_chain(out, ring, true));
                // Walls keep their thickness; a hair around them makes thin ones seen.
                let _ = writeln!(
                    out,
                    "\" fill=\"{fill}\" fill-rule=\"evenodd\" stroke=\"{line}\" stroke-width=\"{}\"/>",
                    mm(if is_ground { stroke } else { 0.5 * self.hair })
                );
            }
            Form::Line(chain) if chain.len() > 1 => {
                out.push_str("<path d=\"");
                sheet.push_chain(out, chain, false);
                let broad = if element.kind == ElementKind::Door { 2.0 } else { 1.0 };
                let _ = writeln!(out, "\" fill=\"none\" stroke=\"{line}\" stroke-width=\"{}\"/>", mm(broad * stroke.max(50.0)));
            }
            Form::Line(_) => {}
            Form::Spot(spot) => {
                let [x, y] = sheet.place(*spot).map(mm);
                let radius = mm(self.hair.max(if element.kind == ElementKind::Door { 1e3 * super::SPOT_RADIUS_M } else { 100.0 }));
                let _ = writeln!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{fill}\" fill-opacity=\"0.8\"/>");
            }
        }
    }

    /// Names of rooms, stairs and lifts, as large as fits, where they can be read at all.
    fn push_names(&self, out: &mut String, sheet: &Sheet, level: &Level) {
        for element in super::elements(level).filter(|element| element.kind.is_ground()) {
            let Some(name) = element.name.as_deref().map(str::trim).filter(|name| !name.is_empty()) else { continue };
            let name: String = name.chars().take(LONGEST).collect();
            let Some((at, width_m)) = label_place(&element.form) else { continue };
            let fits = 0.9e3 * width_m / (LETTER_WIDTH * name.chars().count() as f64);
            let size = fits.min(0.8 * self.line);
            if size >= 0.22 * self.line {
                let [x, y] = sheet.place(at);
                self.push_text(out, [x, y + 0.35 * size], size, "middle", "#5b3a1e", &name);
            }
        }
    }

    /// A ring with the finding's number beside it.
    fn push_mark(&self, out: &mut String, sheet: &Sheet, number: usize, finding: &Finding) {
        let Some(at) = finding.at() else { return };
        let [x, y] = sheet.place(at);
        let (radius, width) = (0.45 * self.line, 0.12 * self.line);
        let [cx, cy, r, w] = [x, y, radius, width].map(mm);
        let _ = writeln!(out, "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{r}\" fill=\"none\" stroke=\"{FINDING}\" stroke-width=\"{w}\"/>");
        self.push_text(out, [x + 1.3 * radius, y - 0.6 * radius], 0.75 * self.line, "start", FINDING, &number.to_string());
    }

    fn push_legend(&self, out: &mut String, level: &Level, audit: &Audit) {
        let entries = legend(level, audit);
        let columns = columns(self.width, self.line);
        let rows = entries.len().div_ceil(columns);
        let column_mm = self.width / columns as f64;
        let top = self.top + self.height - (rows as f64 + 0.7) * self.line;
        for (n, (colour, words)) in entries.iter().enumerate() {
            let (x, y) = (self.left + 0.5 * self.line + (n / rows) as f64 * column_mm, top + (n % rows) as f64 * self.line);
            let [left, upper, side] = [x, y, 0.6 * self.line].map(mm);
            let _ = writeln!(
                out,
                "<rect x=\"{left}\" y=\"{upper}\" width=\"{side}\" height=\"{side}\" fill=\"{colour}\" stroke=\"#888888\" stroke-width=\"{}\"/>",
                mm(self.hair)
            );
            self.push_text(out, [x + 0.9 * self.line, y + 0.55 * self.line], 0.62 * self.line, "start", "#222222", words);
        }
        let length_m = bar_m(1e-3 * self.width);
        let (x, y) = (self.left + 0.5 * self.line, top - 0.9 * self.line);
        let [left, upper, length, thick] = [x, y, 1e3 * length_m, 0.18 * self.line].map(mm);
        let _ = writeln!(out, "<rect x=\"{left}\" y=\"{upper}\" width=\"{length}\" height=\"{thick}\" fill=\"#222222\"/>");
        let after = [x + 1e3 * length_m + 0.4 * self.line, y + 0.3 * self.line];
        self.push_text(out, after, 0.62 * self.line, "start", "#222222", &format!("{length_m} m"));
    }
}

/// Columns of the legend: an entry is some twenty letters long.
fn columns(width: f64, line: f64) -> usize {
    ((width / (13.0 * line)) as usize).clamp(1, 8)
}

/// What there is on the storey, with its colour and number.
fn legend(level: &Level, audit: &Audit) -> Vec<(&'static str, String)> {
    let count = |kind: ElementKind| super::elements(level).filter(|element| element.kind == kind).count();
    let kinds = KINDS.iter().rev().map(|(kind, fill, _)| (count(*kind), *kind, *fill)).filter(|(count, ..)| *count > 0);
    let words = |(count, kind, fill): (usize, ElementKind, &'static str)| {
        let many = if count == 1 || kind == ElementKind::Stairs { "" } else { "s" };
        let colours = if kind == ElementKind::Room { " (pale colours)" } else { "" };
        (fill, format!("{count} {}{many}{colours}", kind.word()))
    };
    let findings = audit.findings.len();
    let marks = (findings > 0).then(|| (FINDING, format!("{findings} finding{}", if findings == 1 { "" } else { "s" })));
    kinds.map(words).chain(marks).collect()
}

/// A round length of about a fifth of the width, metres.
fn bar_m(width_m: f64) -> f64 {
    let wanted = (0.2 * width_m).max(1e-3);
    let power = power_of_ten(wanted.log10().floor() as i32);
    [5.0, 2.0, 1.0].into_iter().map(|k| k * power).find(|length| *length <= wanted).unwrap_or(power)
}

/// A whole power of ten, as exact as it can be.
fn power_of_ten(power: i32) -> f64 {
    if power >= 0 { 10f64.powi(power) } else { 1.0 / 10f64.powi(-power) }
}

fn mm(value: f64) -> String {
    decimal(value, 1)
}

#[cfg(test)]
mod tests {
    use super::super::tests::flat;
    use super::*;
    use planwalk_types::Pt2;

    fn audited() -> (Level, Audit) {
        let level = flat();
        let audit = Audit::of(&level).unwrap();
        (level, audit)
    }

    #[test]
    fn rooms_differ_in_colour_and_wear_their_names() {
        let (level, audit) = audited();
        let text = picture(&level, &audit, "a <flat>");
        assert!(text.contains("a &lt;flat&gt;") && text.contains(">Küche &lt;1&gt; &amp; \"2\"</text>"), "{text}");
        let colours: Vec<String> = (0..30).map(pale).collect();
        let mut distinct = colours.clone();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), colours.len());
        assert!(text.contains(&colours[0]) && text.contains(&colours[1]));
    }

    #[test]
    fn the_legend_counts_what_was_taken_for_what() {
        let (level, mut audit) = audited();
        audit.findings = vec![Finding::OutlineGap { at: Pt2::new(1.0, 0.0), width_m: 1.0, places: 1 }];
        let text = picture(&level, &audit, "");
        for words in ["2 walls", "3 doors", "1 window", "2 rooms (pale colours)", "1 finding", "2 m"] {
            assert!(text.contains(&format!(">{words}</text>")), "{words}: {text}");
        }
        assert!(text.contains("<circle cx=\"1000\" cy=\"0\""), "{text}");
    }

    #[test]
    fn the_scale_bar_is_a_round_length_of_a_fifth_at_most() {
        for (width_m, bar) in [(10.0, 2.0), (24.0, 2.0), (26.0, 5.0), (600.0, 100.0), (4.0, 0.5)] {
            assert!((bar_m(width_m) - bar).abs() < 1e-12, "{width_m}: {}", bar_m(width_m));
        }
    }
}

//! How does a storey look as a drawing? SVG, one group a kind, to look at, to edit and to read again.
//!
//! 1 unit is 1 mm of the building, so coordinates are millimetres of the plan with y turned down; width and height say it too, and
//! a browser fits it into its window all the same; and two attributes of its root say scale and origin to this program, which reads
//! its groups as they are meant. Groups are called after their kinds (`<g id="wall">`), ground first and doors
//! last; names are titles, and those of ground are written on it.
//!
//! | kind | colour | |
//! |---|---|---|
//! | floor, room, stairs, lift | sand, cream, light green, light violet | grey outlines |
//! | wall, window | nearly black, dark blue | what stops people is darker than mid-grey |
//! | door | orange | lies on walls, as it wins over them |
//! | names | brown | lighter than mid-grey too |
//!
//! Read as a picture, it is a plan as well: dark is wall. Lines are 5 cm wide, doors given as points as wide as they open.
//! Pitfall: programs that show SVG count in single precision, 1 mm at 17 km: sites farther from the origin are moved, and
//! `<desc>` says by how much.

use std::fmt::Write;

use planwalk_types::{Element, ElementKind, Form, Level, Plan, Pt2};

use super::super::notation::{decimal, push_decimal};

/// Kinds from below to above, with the colours of their insides and outlines.
const LAYERS: [(ElementKind, &str, &str); 7] = [
    (ElementKind::Floor, "#ece7dc", "#9a9a9a"),
    (ElementKind::Room, "#fdf6e3", "#9a9a9a"),
    (ElementKind::Stairs, "#dcefd9", "#9a9a9a"),
    (ElementKind::Lift, "#e6dcf2", "#9a9a9a"),
    (ElementKind::Wall, "#222222", "none"),
    (ElementKind::Window, "#1f4e79", "none"),
    (ElementKind::Door, "#f0932b", "none"),
];
/// Colour of names.
const LETTERS: &str = "#a0522d";
/// Width of lines, mm: a cell.
const LINE_MM: f64 = 50.0;
/// Width of outlines, mm.
const OUTLINE_MM: f64 = 20.0;
/// A place that is no door, mm from its middle to its rim.
const DOT_MM: f64 = 50.0;
/// Paper around the drawing, metres.
const MARGIN_M: f64 = 1.0;
/// Farthest from the origin that coordinates are kept, metres: single precision tells millimetres there.
const NEAR_M: f64 = 16_000.0;
/// Decimals of millimetres.
const MM_DECIMALS: usize = 1;
/// Letters of names, mm: as large as fits, but not over or under this.
const LETTERS_MM: (f64, f64) = (60.0, 300.0);
/// A letter is this wide at most, in letter heights, in common faces.
pub(super) const LETTER_WIDTH: f64 = 0.65;
/// Lines across a room on which a place for its name is looked for.
const LABEL_ROWS: u32 = 7;

/// The drawing.
pub fn svg(level: &Level) -> String {
    let sheet = Sheet::around(level);
    let mut out = sheet.head(level);
    for (kind, fill, outline) in LAYERS {
        let mut any = false;
        for element in super::elements(level).filter(|element| element.kind == kind) {
            let Some(mark) = sheet.mark(element, fill) else { continue };
            if !any {
                let width = if outline == "none" { String::new() } else { format!(" stroke-width=\"{OUTLINE_MM}\"") };
                let _ = writeln!(out, "<g id=\"{}\" fill=\"{fill}\" fill-rule=\"evenodd\" stroke=\"{outline}\"{width}>", kind.word());
                any = true;
            }
            out.push_str(&mark);
        }
        if any {
            out.push_str("</g>\n");
        }
    }
    sheet.push_labels(&mut out, level);
    out.push_str("</svg>\n");
    out
}

/// Where the drawing lies on its paper.
pub(super) struct Sheet {
    /// What is taken from the plan's coordinates, metres.
    moved: [f64; 2],
    /// Left, lower, right and upper edge, metres, moved.
    pub(super) edges: [f64; 4],
}

impl Sheet {
    pub(super) fn around(level: &Level) -> Self {
        let points = || super::elements(level).flat_map(|e| e.form.points());
        let low = points().fold([f64::INFINITY; 2], |l, p| [l[0].min(p.x), l[1].min(p.y)]);
        let high = points().fold([f64::NEG_INFINITY; 2], |h, p| [h[0].max(p.x), h[1].max(p.y)]);
        // Nothing is drawn: an empty sheet.
        let (low, high) = if low[0] <= high[0] { (low, high) } else { ([0.0; 2], [0.0; 2]) };
        let near = low.iter().chain(&high).all(|v| v.abs() <= NEAR_M);
        let moved = if near { [0.0; 2] } else { low.map(f64::floor) };
        let [left, lower] = [0, 1].map(|k| low[k] - moved[k] - MARGIN_M);
        let [right, upper] = [0, 1].map(|k| high[k] - moved[k] + MARGIN_M);
        Self { moved, edges: [left, lower, right, upper] }
    }

    /// In millimetres, y down.
    pub(super) fn place(&self, point: Pt2<Plan>) -> [f64; 2] {
        [1e3 * (point.x - self.moved[0]), -1e3 * (point.y - self.moved[1])]
    }

    fn head(&self, level: &Level) -> String {
        let [left, lower, right, upper] = self.edges.map(|metres| 1e3 * metres);
        let [x, y, width, height] = [left, -upper, right - left, upper - lower].map(|mm| decimal(mm, MM_DECIMALS));
        let [moved_x, moved_y] = self.moved.map(|metres| decimal(metres, 0));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" viewBox=\"{x} {y} {width} {height}\" \
             style=\"width:100%;height:100%\" data-planwalk-metres-per-unit=\"0.001\" data-planwalk-origin=\"{moved_x},{moved_y}\">\n\
             <title>{}</title>\n\
             <desc>1 unit is 1 mm of the building; the plan's metres are x = {moved_x} + u / 1000, y = {moved_y} - v / 1000</desc>\n",
            escaped(&level.name)
        )
    }

    /// An element's line of SVG.
    fn mark(&self, element: &Element, colour: &str) -> Option<String> {
        let mut out = String::new();
        match &element.form {
            Form::Area(rings) => {
                out.push_str("<path d=\"");
                super::rings(rings)?.iter().for_each(|ring| self.push_chain(&mut out, ring, true));
                out.push('"');
            }
            Form::Line(line) if line.len() < 2 => return None,
            Form::Line(line) => {
                out.push_str("<path d=\"");
                self.push_chain(&mut out, line, false);
                let _ = write!(out, "\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{LINE_MM}\"");
            }
            Form::Spot(spot) => {
                let [x, y] = self.place(*spot).map(|mm| decimal(mm, MM_DECIMALS));
                let radius = if element.kind == ElementKind::Door { 1e3 * super::SPOT_RADIUS_M } else { DOT_MM };
                let _ = write!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"");
            }
        }
        match &element.name {
            Some(name) => {
                let _ = writeln!(
                    out,
                    "><title>{}</title></{}>",
                    escaped(name),
                    if matches!(element.form, Form::Spot(_)) { "circle" } else { "path" }
                );
            }
            None => out.push_str("/>\n"),
        }
        Some(out)
    }

    pub(super) fn push_chain(&self, out: &mut String, chain: &[Pt2<Plan>], closed: bool) {
        for (i, point) in chain.iter().enumerate() {
            let [x, y] = self.place(*point);
            out.push(if i == 0 { 'M' } else { 'L' });
            push_decimal(out, x, MM_DECIMALS);
            out.push(' ');
            push_decimal(out, y, MM_DECIMALS);
        }
        if closed {
            out.push('Z');
        }
    }

    /// The names of ground, above all else.
    fn push_labels(&self, out: &mut String, level: &Level) {
        let mut any = false;
        for element in super::elements(level).filter(|element| element.kind.is_ground()) {
            let Some(name) = element.name.as_deref().map(str::trim).filter(|name| !name.is_empty()) else { continue };
            let Some((at, width_m)) = label_place(&element.form) else { continue };
            let letters = 1e3 * width_m / (LETTER_WIDTH * name.chars().count() as f64);
            let [x, y] = self.place(at).map(|mm| decimal(mm, MM_DECIMALS));
            let size = decimal(letters.clamp(LETTERS_MM.0, LETTERS_MM.1), MM_DECIMALS);
            if !any {
                let face = "font-family=\"sans-serif\" text-anchor=\"middle\" dominant-baseline=\"central\"";
                let _ = writeln!(out, "<g id=\"labels\" fill=\"{LETTERS}\" {face}>");
                any = true;
            }
            let _ = writeln!(out, "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\">{}</text>", escaped(name));
        }
        if any {
            out.push_str("</g>\n");
        }
    }
}

/// Where a name goes, and how wide it may be, metres: the widest of some lines across an area; the middle one of equals.
pub(super) fn label_place(form: &Form) -> Option<(Pt2<Plan>, f64)> {
    let rings = match form {
        Form::Area(rings) => super::rings(rings)?,
        Form::Line(_) => return None,
        Form::Spot(spot) => return Some((*spot, f64::INFINITY)),
    };
    let ys = || rings.iter().flatten().map(|p| p.y);
    let (low, high) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
    let middle = LABEL_ROWS.div_ceil(2);
    let mut rows: Vec<u32> = (1..=LABEL_ROWS).collect();
    rows.sort_by_key(|row| row.abs_diff(middle));
    let mut best: Option<(Pt2<Plan>, f64)> = None;
    for row in rows {
        let y = low + (high - low) * f64::from(row) / f64::from(LABEL_ROWS + 1);
        for [left, right] in spans(&rings, y) {
            // A name moves up or down for a tenth more, not for a hair.
            if best.is_none_or(|(_, width)| right - left > 1.1 * width) {
                best = Some((Pt2::new(0.5 * (left + right), y), right - left));
            }
        }
    }
    best
}

/// What of the line at height `y` is inside, by the even-odd rule.
fn spans(rings: &[Vec<Pt2<Plan>>], y: f64) -> Vec<[f64; 2]> {
    let mut crossings = Vec::new();
    for ring in rings {
        let next = ring.iter().cycle().skip(1);
        for (a, b) in ring.iter().zip(next) {
            if (a.y > y) != (b.y > y) {
                crossings.push(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings.chunks_exact(2).filter_map(|pair| pair.try_into().ok()).collect()
}

/// A text as XML has it; what XML has no way to write becomes U+FFFD.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::tests::{flat, ring};
    use super::*;

    fn one(kind: ElementKind, form: Form) -> Level {
        Level { elements: vec![Element::new(kind, form)], ..Level::default() }
    }

    #[test]
    fn the_drawing_is_in_millimetres_with_y_turned() {
        let text = svg(&flat());
        // The outer walls reach from -0.2 m to 8.2 m and 4.2 m, and a metre of paper is around them.
        assert!(text.contains("width=\"10400mm\" height=\"6400mm\" viewBox=\"-1200 -5200 10400 6400\""), "{text}");
        assert!(text.contains("x = 0 + u / 1000, y = 0 - v / 1000"), "{text}");
        let walls = "<path d=\"M-200 200L8200 200L8200 -4200L-200 -4200ZM0 0L8000 0L8000 -4000L0 -4000Z\"/>\n";
        assert!(text.contains(walls), "{text}");
        assert!(text.contains("<path d=\"M5000 0L5000 -4000\" fill=\"none\" stroke=\"#222222\" stroke-width=\"50\"/>"), "{text}");
        assert!(text.contains("<circle cx=\"5000\" cy=\"-2000\" r=\"450\"/>"), "{text}");
    }

    #[test]
    fn each_kind_is_a_group_and_doors_lie_on_walls() {
        let text = svg(&flat());
        let groups: Vec<&str> = text.split("<g id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert_eq!(groups, ["room", "wall", "window", "door", "labels"]);
        assert_eq!(text.matches("</g>").count(), groups.len());
        for kind in ElementKind::ALL {
            assert!(LAYERS.iter().any(|layer| layer.0 == kind), "{kind:?}");
        }
    }

    #[test]
    fn what_stops_people_is_dark_and_all_else_is_light() {
        // As pictures are read: by the brightest of red, green and blue.
        let brightest = |colour: &str| [1, 3, 5].map(|k| u8::from_str_radix(&colour[k..k + 2], 16).unwrap()).into_iter().max();
        for (kind, fill, outline) in LAYERS {
            let stops = matches!(kind, ElementKind::Wall | ElementKind::Window);
            assert_eq!(brightest(fill) < Some(128), stops, "{kind:?}");
            assert!(outline == "none" || brightest(outline) >= Some(128), "{kind:?}");
        }
        assert!(brightest(LETTERS) >= Some(128));
    }

    #[test]
    fn names_are_titles_and_rooms_wear_them() {
        let text = svg(&flat());
        let name = "Küche &lt;1&gt; &amp; \"2\"";
        assert!(text.contains(&format!("Z\"><title>{name}</title></path>")), "{text}");
        assert!(text.contains(&format!("<text x=\"2500\" y=\"-2000\" font-size=\"300\">{name}</text>")), "{text}");
        assert!(text.contains("<title>front</title>") && !text.contains(">front</text>"), "{text}");
        assert_eq!(escaped("a\u{1}b\nc"), "a\u{fffd}b c");
        let lift = Element { name: Some("L1".to_owned()), ..Element::new(ElementKind::Lift, Form::Spot(Pt2::new(1.0, 2.0))) };
        let text = svg(&Level { elements: vec![lift], ..Level::default() });
        assert!(text.contains("<text x=\"1000\" y=\"-2000\" font-size=\"300\">L1</text>"), "{text}");
    }

    #[test]
    fn the_name_of_a_bent_corridor_lies_in_it() {
        // An L, 2 m wide: its centre of mass lies outside.
        let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 2.0), (2.0, 2.0), (2.0, 10.0), (0.0, 10.0)].map(|(x, y)| Pt2::new(x, y)).to_vec();
        let (at, width_m) = label_place(&Form::Area(vec![corners])).unwrap();
        assert!(at.y > 0.0 && at.y < 2.0 && (width_m - 10.0).abs() < 1e-9, "{at:?}");
        // A court with a hole: beside it.
        let (at, _) = label_place(&Form::Area(vec![ring(0.0, 0.0, 9.0, 9.0), ring(2.0, 0.5, 8.0, 8.5)])).unwrap();
        assert!(at.x < 2.0 || at.x > 8.0, "{at:?}");
    }

    #[test]
    fn far_sites_are_moved_so_that_no_millimetre_is_lost() {
        let site = one(ElementKind::Wall, Form::Area(vec![ring(566_600.25, 5_932_800.5, 566_604.25, 5_932_803.5)]));
        let text = svg(&site);
        assert!(text.contains("M250 -500L4250 -500L4250 -3500L250 -3500Z"), "{text}");
        assert!(text.contains("x = 566600 + u / 1000, y = 5932800 - v / 1000"), "{text}");
    }

    #[test]
    fn an_empty_storey_is_an_empty_sheet() {
        let text = svg(&Level::default());
        assert!(text.contains("viewBox=\"-1000 -1000 2000 2000\"") && !text.contains("<g"), "{text}");
    }
}

//! How does a drawing become one that usvg reads as it was meant? `use` written out, shapes numbered, resources simplified.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;

use usvg::roxmltree::{self, Node, NodeId};

use super::super::{PlanFileError, drafter};
use super::frame::Frame;
use super::letters::{Cursor, Run, anchored};
use super::xml::{attribute, is_far, link, name, pixels};
use super::{INKSCAPE, NUMBERED, SVG, refused};

/// Most elements, with every `use` written out: ten times a large office floor with its furniture. They take some seconds.
const MOST_ELEMENTS: usize = 500_000;
/// Deepest nesting, with every `use` written out; editors stay under 20. usvg calls itself for each level.
pub(super) const DEEPEST: usize = 150;
/// What `use` may add to the text, bytes.
const LONGEST_COPIES: usize = 256 << 20;
/// Most rules of style sheets times elements, as each is tried on each: less than a minute. Illustrator's have a thousandth of it.
const MOST_STYLING: f64 = 2e9;
/// Most gradients in a row that take their colours from the next.
const LONGEST_CHAIN: usize = 16;
const SHAPES: [&str; 7] = ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon"];
/// What texts become: a link, which usvg takes as a group, so that the style sheets' rules keep their order of precedence.
pub(super) const TEXT: &str = "a";
/// Class of the groups that parts of texts become.
pub(super) const SPAN: &str = "was-tspan";

/// The same drawing, as usvg shall have it.
pub(super) struct Redraft<'a, 'input> {
    by_id: HashMap<&'a str, Node<'a, 'input>>,
    /// Ids that style sheets name.
    styled: HashSet<String>,
    pub out: String,
    longest: usize,
    elements: usize,
    deepest: usize,
    pub layers: Vec<String>,
    pub runs: HashMap<usize, Run>,
    /// Targets of the `use` elements that are being written out.
    open: Vec<NodeId>,
    pub bitmaps: usize,
    pub far: usize,
    pub loops: usize,
}

impl<'a, 'input> Redraft<'a, 'input> {
    pub(super) fn of(document: &'a roxmltree::Document<'input>, length: usize, frame: Frame) -> Result<Self, PlanFileError> {
        let root = document.root_element();
        let mut by_id = HashMap::new();
        let mut styles = String::new();
        for node in document.descendants() {
            if let Some(id) = attribute(node, "id") {
                by_id.entry(id).or_insert(node);
            }
            if name(node) == "style" {
                node.children().filter_map(|n| n.text()).for_each(|text| styles.push_str(text));
            }
        }
        let styled = styles.split('#').skip(1).map(|rest| rest.chars().take_while(|c| c.is_alphanumeric() || "-_".contains(*c)).collect());
        let mut draft = Self {
            by_id,
            styled: styled.collect(),
            out: String::new(),
            longest: length.saturating_mul(2) + LONGEST_COPIES,
            elements: 0,
            deepest: 1,
            layers: Vec::new(),
            runs: HashMap::new(),
            open: Vec::new(),
            bitmaps: 0,
            far: 0,
            loops: 0,
        };
        let _ = write!(draft.out, "<svg xmlns=\"{SVG}\"");
        if let Some([x, y, width, height]) = frame.view_box {
            let _ = write!(draft.out, " viewBox=\"{x} {y} {width} {height}\"");
        }
        draft.attributes(root, &["width", "height", "viewBox", "preserveAspectRatio", "x", "y"]);
        draft.out.push_str("><style>");
        escape(&styles_of_groups(&styles), &mut draft.out);
        draft.out.push_str("</style><defs>");
        for node in document.descendants() {
            draft.resource(node)?;
        }
        draft.out.push_str("</defs>");
        draft.children(root, "", &Cursor::default(), 0)?;
        draft.out.push_str("</svg>");
        draft.check_styles(&styles)?;
        Ok(draft)
    }

    /// Whether the style sheets are tried on the elements in bounded time: for `a b c`, on each pair of what an element lies in.
    fn check_styles(&self, styles: &str) -> Result<(), PlanFileError> {
        let rules = styles.split('}').filter_map(|rule| rule.split_once('{'));
        let parts = rules.flat_map(|(selectors, _)| selectors.split(',')).map(|selector| {
            selector.split(|c: char| c.is_whitespace() || matches!(c, '>' | '+')).filter(|part| !part.is_empty()).count().max(1)
        });
        let tries: f64 = parts.map(|parts| (self.deepest as f64).powi(parts.min(100) as i32 - 1)).sum();
        if tries * self.elements as f64 > MOST_STYLING {
            let elements = self.elements;
            return Err(refused(&format!(
                "its style sheets are too intricate for its {elements} elements: save it as plain SVG in Inkscape"
            )));
        }
        Ok(())
    }

    /// Counts one element more.
    pub(super) fn spend(&mut self, depth: usize) -> Result<(), PlanFileError> {
        self.elements += 1;
        self.deepest = self.deepest.max(depth);
        if self.elements > MOST_ELEMENTS || self.out.len() > self.longest {
            let elements = self.elements;
            return Err(refused(&format!(
                "with its copies (<use>) it has more than {elements} elements or {} MB: leave furniture and hatches away, or simplify it",
                self.longest >> 20
            )));
        }
        if depth > DEEPEST {
            return Err(refused(&format!("its groups are nested deeper than {DEEPEST}: ungroup them, e.g. by saving it anew in Inkscape")));
        }
        Ok(())
    }

    pub(super) fn attributes(&mut self, node: Node, without: &[&str]) {
        for attribute in node.attributes() {
            let kept = attribute.namespace().is_none() && !without.contains(&attribute.name()) && !attribute.name().starts_with("on");
            if kept {
                self.out.push(' ');
                self.out.push_str(attribute.name());
                self.out.push_str("=\"");
                escape(attribute.value(), &mut self.out);
                self.out.push('"');
            }
        }
    }

    /// What others refer to: gradients, patterns as a grey one, clips.
    fn resource(&mut self, node: Node<'a, 'input>) -> Result<(), PlanFileError> {
        match name(node) {
            "linearGradient" | "radialGradient" => {
                let stop = self.first_stop(node);
                self.paint(attribute(node, "id"), stop)?;
            }
            "pattern" => self.paint(attribute(node, "id"), None)?,
            "clipPath" => {
                let before = self.out.len();
                self.out.push_str("<clipPath");
                self.attributes(node, &["clip-path"]);
                self.out.push('>');
                let empty = self.out.len();
                for child in node.children() {
                    self.clip_shape(child)?;
                }
                // A clip by texts or groups alone is not understood: better no clip than nothing.
                if self.out.len() == empty && node.has_children() {
                    self.out.truncate(before);
                } else {
                    self.out.push_str("</clipPath>");
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// A gradient's first colour, or that of the gradient that it takes its colours from.
    fn first_stop(&self, gradient: Node<'a, 'input>) -> Option<Node<'a, 'input>> {
        let next = |node: &Node<'a, 'input>| link(*node).and_then(|id| self.by_id.get(id).copied());
        let chain = std::iter::successors(Some(gradient), next).take(LONGEST_CHAIN);
        chain.flat_map(|node| node.children()).find(|node| name(*node) == "stop")
    }

    /// A gradient of one colour: grey without one.
    fn paint(&mut self, id: Option<&str>, stop: Option<Node>) -> Result<(), PlanFileError> {
        self.spend(0)?;
        // Not of the shape's own box: those of straight lines are empty, and would lose their paint.
        self.out.push_str("<linearGradient gradientUnits=\"userSpaceOnUse\" id=\"");
        escape(id.unwrap_or_default(), &mut self.out);
        self.out.push_str("\"><stop");
        match stop {
            Some(stop) => self.attributes(stop, &["id"]),
            None => self.out.push_str(" stop-color=\"#808080\""),
        }
        self.out.push_str("/></linearGradient>");
        Ok(())
    }

    /// A shape of a clip, or a `use` of one.
    fn clip_shape(&mut self, node: Node<'a, 'input>) -> Result<(), PlanFileError> {
        let used = if name(node) == "use" { link(node).and_then(|id| self.by_id.get(id).copied()) } else { None };
        let shape = used.unwrap_or(node);
        if !SHAPES.contains(&name(shape)) || is_far(shape) {
            return Ok(());
        }
        self.spend(0)?;
        let _ = write!(self.out, "<{}", name(shape));
        let place = |axis: &str| used.and(attribute(node, axis)).and_then(pixels).unwrap_or(0.0);
        let outer = used.and(attribute(node, "transform")).unwrap_or_default();
        let inner = attribute(shape, "transform").unwrap_or_default();
        self.out.push_str(" transform=\"");
        escape(&format!("{outer} translate({} {}) {inner}", place("x"), place("y")), &mut self.out);
        self.out.push('"');
        self.attributes(shape, &["transform", "id", "clip-path"]);
        self.out.push_str("/>");
        Ok(())
    }

    fn children(&mut self, node: Node<'a, 'input>, layer: &str, cursor: &Cursor, depth: usize) -> Result<(), PlanFileError> {
        for child in node.children() {
            self.element(child, layer, cursor, depth + 1)?;
        }
        Ok(())
    }

    fn element(&mut self, node: Node<'a, 'input>, layer: &str, cursor: &Cursor, depth: usize) -> Result<(), PlanFileError> {
        let tag = name(node);
        match tag {
            "g" | "a" | "switch" | "svg" => {
                self.spend(depth)?;
                let layer = within(layer, node);
                let tag = if tag == "a" { "g" } else { tag };
                let _ = write!(self.out, "<{tag}");
                self.attributes(node, &["href"]);
                self.out.push('>');
                self.children(node, &layer, &anchored(cursor, node), depth)?;
                let _ = write!(self.out, "</{tag}>");
            }
            "use" => self.copy(node, layer, cursor, depth)?,
            "text" => {
                let mut cursor = anchored(cursor, node);
                self.text(node, &within(layer, node), &mut cursor, depth)?;
            }
            "image" => self.bitmaps += 1,
            _ if SHAPES.contains(&tag) && is_far(node) => self.far += 1,
            _ if SHAPES.contains(&tag) => {
                self.spend(depth)?;
                let number = self.number(within(layer, node));
                // A style sheet may know it by its id, which then has to stay.
                let known = attribute(node, "id").is_some_and(|id| self.styled.contains(id));
                if known {
                    let _ = write!(self.out, "<g id=\"{NUMBERED}{number}\"><{tag}");
                    self.attributes(node, &[]);
                    self.out.push_str("/></g>");
                } else {
                    let _ = write!(self.out, "<{tag} id=\"{NUMBERED}{number}\"");
                    self.attributes(node, &["id"]);
                    self.out.push_str("/>");
                }
            }
            _ => {}
        }
        Ok(())
    }

    pub(super) fn number(&mut self, layer: String) -> usize {
        self.layers.push(layer);
        self.layers.len() - 1
    }

    /// A `use`: its target as a drawing within the drawing, which is what the standard makes of it.
    fn copy(&mut self, node: Node<'a, 'input>, layer: &str, cursor: &Cursor, depth: usize) -> Result<(), PlanFileError> {
        let Some(target) = link(node).and_then(|id| self.by_id.get(id).copied()) else { return Ok(()) };
        let inside = node.ancestors().any(|n| n == target) || self.open.contains(&target.id());
        if inside {
            self.loops += 1;
            return Ok(());
        }
        self.spend(depth)?;
        let own_frame = matches!(name(target), "symbol" | "svg");
        self.out.push_str("<g");
        self.attributes(node, &["x", "y", "width", "height", "href"]);
        self.out.push_str("><svg");
        for place in ["x", "y", "width", "height"] {
            let sized = matches!(place, "width" | "height");
            let own = || attribute(target, place).filter(|_| own_frame && sized);
            if let Some(value) = attribute(node, place).filter(|_| own_frame || !sized).or_else(own) {
                let _ = write!(self.out, " {place}=\"");
                escape(value, &mut self.out);
                self.out.push('"');
            }
        }
        let (layer, cursor) = (within(layer, node), anchored(cursor, node));
        self.open.push(target.id());
        if own_frame {
            self.attributes(target, &["x", "y", "width", "height", "id"]);
            self.out.push('>');
            self.children(target, &within(&layer, target), &cursor, depth)?;
        } else {
            self.out.push_str(" overflow=\"visible\">");
            self.element(target, &layer, &cursor, depth + 1)?;
        }
        self.open.pop();
        self.out.push_str("</svg></g>");
        Ok(())
    }
}

/// The layer of an element inside of another: its label or id, Illustrator's own name, classes, and Visio's title.
pub(super) fn within(layer: &str, node: Node) -> String {
    let label = node.attribute((INKSCAPE, "label")).or_else(|| attribute(node, "data-name")).or_else(|| attribute(node, "id"));
    let title = node.children().find(|n| name(*n) == "title").and_then(|n| n.text());
    let classes = attribute(node, "class").unwrap_or_default().split_whitespace();
    drafter::layer_within(layer, label.into_iter().chain(classes).chain(title))
}

pub(super) fn escape(text: &str, out: &mut String) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\r' | '\t' => out.push(' '),
            c => out.push(c),
        }
    }
}

/// Style sheets whose selectors name `text` and `tspan` name what these became.
pub(super) fn styles_of_groups(styles: &str) -> String {
    let mut out = String::with_capacity(styles.len());
    let (mut depth, mut before) = (0usize, ' ');
    let mut rest = styles;
    while let Some(c) = rest.chars().next() {
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '-' && c != '_').unwrap_or(rest.len());
        let (token, tail) = rest.split_at(word.max(c.len_utf8()));
        match token {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 && matches!(token, "text" | "tspan") && !matches!(before, '.' | '#' | ':' | '[' | '=' | '"') {
            match token {
                "text" => out.push_str(TEXT),
                _ => out.extend([".", SPAN]),
            }
        } else {
            out.push_str(token);
        }
        before = c;
        rest = tail;
    }
    out
}

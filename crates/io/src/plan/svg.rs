//! What is drawn in an SVG? Its paths with all transforms, styles and copies applied, and its texts.
//!
//! XML ─▶ redrafted: `use` written out, numbered, texts as squares of their size ─▶ usvg: styles, transforms, clips ─▶ [`Sketch`]
//!
//! Units are those of the root's viewBox, as editors show them, or pixels where there is none; x right, y up, the origin at the
//! viewBox's bottom-left, or at that of all that is drawn. usvg keeps ids only, so each shape's id becomes a number that leads back
//! to its layer: Inkscape's label or the id, classes, and Visio's title, of it and of all that it lies in.
//! Pitfalls: width and height in mm are of the paper, so no metres; only Visio's drawing scale is one. usvg recurses and computes
//! with 24 bits: depth is checked before, and plans in national coordinates lose what is below 1e-7 of them.
//! Not read: bitmaps, masks, filters and markers (arrow heads); gradients count as their first colour, patterns as grey.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;

use usvg::roxmltree::{self, Node, NodeId, ParsingOptions};
use usvg::tiny_skia_path::{PathSegment, Point, Transform};

use super::PlanFileError;
use super::pen::{self, Bounds, FAINTEST, Look, Pen, Piece, Step};
use super::sketch::{Sketch, SketchPoint};
use crate::text as files;

/// Most elements, with every `use` written out: ten times a large office floor with its furniture. They take some seconds.
const MOST_ELEMENTS: usize = 500_000;
/// Most nodes of the XML, comments and blanks between elements among them.
const MOST_NODES: u32 = 4_000_000;
/// Deepest nesting, with every `use` written out; editors stay under 20. usvg calls itself for each level.
const DEEPEST: usize = 150;
/// What `use` may add to the text, bytes.
const LONGEST_COPIES: usize = 256 << 20;
/// What entities may add to it, bytes.
const LONGEST_ENTITIES: usize = 64 << 20;
/// References that the XML parser follows within one reference to an entity.
const REFERENCES_WITHIN: usize = 255;
/// Most rules of style sheets times elements, as each is tried on each: less than a minute. Illustrator's have a thousandth of it.
const MOST_STYLING: f64 = 2e9;
/// Most gradients in a row that take their colours from the next.
const LONGEST_CHAIN: usize = 16;
/// A number that leads back begins with this: no file has such an id.
const NUMBERED: &str = "\u{b6}";
/// Applies to all: usvg would leave out what has a broken filter, and follow links without end.
const STYLE: &str = "* { filter: none !important; mask: none !important; marker-start: none !important; marker-mid: none !important; \
                     marker-end: none !important } clipPath, clipPath * { clip-path: none !important }";

const SVG: &str = "http://www.w3.org/2000/svg";
const XLINK: &str = "http://www.w3.org/1999/xlink";
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
const VISIO: &str = "http://schemas.microsoft.com/visio/2003/SVGExtensions/";

const SHAPES: [&str; 7] = ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon"];
/// What texts become: a link, which usvg takes as a group, so that the style sheets' rules keep their order of precedence.
const TEXT: &str = "a";
/// Class of the groups that parts of texts become.
const SPAN: &str = "was-tspan";
/// Attributes that place a text's letters.
const PLACES: [&str; 7] = ["x", "y", "dx", "dy", "rotate", "textLength", "class"];

/// Reads a drawing.
///
/// # Errors
/// [`PlanFileError::Svg`] for what is no SVG or too much of one, [`PlanFileError::DrawingTooIntricate`], and
/// [`PlanFileError::NothingDrawn`].
pub(super) fn read(text: &str) -> Result<Sketch, PlanFileError> {
    check_entities(text)?;
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, entity_resolver: None };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|why| match why {
        roxmltree::Error::NodesLimitReached => {
            refused(&format!("it has more than {MOST_NODES} nodes: leave furniture away, or simplify it"))
        }
        why => refused(&format!("{why}; open it in Inkscape and save it as plain SVG")),
    })?;
    let root = document.root_element();
    if name(root) != "svg" {
        return Err(refused(&format!("its outermost element is <{}>, not <svg>", files::short(root.tag_name().name()))));
    }
    let frame = Frame::of(root);
    let draft = Redraft::of(&document, text.len(), frame)?;
    let tree = usvg::Tree::from_str(&draft.out, &usvg_options()).map_err(|why| refused(&format!("{why}; save it as plain SVG")))?;
    let sketch = draft.read(&tree, frame, metres_per_unit(root, frame))?;
    Ok(Sketch { exported_from: exported_from(root, frame), ..sketch })
}

fn refused(why: &str) -> PlanFileError {
    PlanFileError::Svg { why: why.to_owned() }
}

fn usvg_options() -> usvg::Options<'static> {
    let nothing = usvg::ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) };
    usvg::Options { image_href_resolver: nothing, style_sheet: Some(STYLE.to_owned()), ..usvg::Options::default() }
}

/// The parser bounds how deep entities go, but not how long a long one becomes when it is named a thousand times.
fn check_entities(text: &str) -> Result<(), PlanFileError> {
    let (mut longest, mut within) = (0usize, 1);
    let mut names = HashSet::new();
    for declared in text.split("<!ENTITY").skip(1) {
        names.extend(declared.split_whitespace().next());
        let Some((_, value)) = declared.split_once(['"', '\'']) else { continue };
        let value = value.split(['"', '\'']).next().unwrap_or_default();
        longest = longest.max(value.len());
        if value.contains('&') {
            within = REFERENCES_WITHIN;
        }
    }
    if names.is_empty() {
        return Ok(());
    }
    let named = text.split('&').skip(1).filter_map(|rest| rest.split_once(';')).filter(|(name, _)| names.contains(name)).count();
    let grown = named.saturating_mul(longest).saturating_mul(within);
    if grown > LONGEST_ENTITIES {
        let limit = LONGEST_ENTITIES >> 20;
        return Err(refused(&format!(
            "its entities may grow to {} MB, over {limit} MB: save it as plain SVG without <!ENTITY>",
            grown >> 20
        )));
    }
    Ok(())
}

/// Name of an element of SVG, else nothing.
fn name<'a>(node: Node<'a, '_>) -> &'a str {
    let tag = node.tag_name();
    if node.is_element() && tag.namespace().is_none_or(|space| space == SVG) { tag.name() } else { "" }
}

/// An attribute without a namespace.
fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attributes().find(|a| a.name() == name && a.namespace().is_none()).map(|a| a.value())
}

/// What a `use` or a gradient links to, if it is in this file.
fn link<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let old = || node.attributes().find(|a| a.name() == "href" && a.namespace() == Some(XLINK)).map(|a| a.value());
    attribute(node, "href").or_else(old)?.trim().strip_prefix('#')
}

/// A length as pixels of 96 an inch; shares of something and sizes of fonts are none.
fn pixels(length: &str) -> Option<f64> {
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

/// The root's viewBox, or its size as one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Frame {
    /// x, y, width, height; `None` where the file has no valid one.
    view_box: Option<[f64; 4]>,
    /// Width of the paper in pixels.
    paper_px: Option<f64>,
}

impl Frame {
    fn of(root: Node) -> Self {
        let positive = |v: &f64| *v > 0.0;
        let size = |name: &str| attribute(root, name).and_then(pixels).filter(positive);
        let (width, height) = (size("width"), size("height"));
        let numbers: Option<Vec<f64>> = attribute(root, "viewBox")
            .map(|text| text.split([',', ' ', '\t', '\n', '\r']).filter(|t| !t.is_empty()).map(|t| t.parse().ok()).collect())
            .unwrap_or_default();
        let stated = numbers.and_then(|n| <[f64; 4]>::try_from(n).ok());
        let stated = stated.filter(|[x, y, w, h]| x.is_finite() && y.is_finite() && (1e-6..1e12).contains(w) && (1e-6..1e12).contains(h));
        let sized = || width.zip(height).map(|(w, h)| [0.0, 0.0, w, h]);
        Self { view_box: stated.or_else(sized), paper_px: width }
    }
}

/// Of a drawing that this program exported, the plan's metres at the lower left corner of its view box.
fn exported_from(root: Node, frame: Frame) -> Option<[f64; 2]> {
    let metres = own_scale(root)?;
    let (x, y) = root.attribute("data-planwalk-origin")?.split_once(',')?;
    let [left, top, _, height] = frame.view_box?;
    let origin = [x.trim().parse::<f64>().ok()? + metres * left, y.trim().parse::<f64>().ok()? - metres * (top + height)];
    origin.iter().all(|v| v.is_finite()).then_some(origin)
}

fn own_scale(root: Node) -> Option<f64> {
    root.attribute("data-planwalk-metres-per-unit")?.parse().ok().filter(|metres: &f64| *metres > 0.0 && metres.is_finite())
}

/// This program says it; else Visio alone says how far its drawing's inches are from its page's.
fn metres_per_unit(root: Node, frame: Frame) -> Option<f64> {
    if let Some(metres) = own_scale(root) {
        return Some(metres);
    }
    let page = root.descendants().find(|n| n.has_tag_name((VISIO, "pageProperties")))?;
    let number = |name: &str| page.attribute((VISIO, name))?.parse::<f64>().ok().filter(|v| *v > 0.0);
    let scale = number("drawingScale")? / number("pageScale")?;
    let [_, _, width, _] = frame.view_box?;
    // 1:1 is what it says when nobody set a scale.
    let metres = scale * frame.paper_px? / 96.0 * 0.0254 / width;
    (scale != 1.0 && metres.is_finite() && metres > 0.0).then_some(metres)
}

/// Where a text begins: at an attribute's word, and so many font sizes and units on from it.
#[derive(Debug, Clone, Default)]
struct Cursor {
    x: String,
    y: String,
    shift_em: SketchPoint,
    shift: SketchPoint,
    /// Share of its width that it begins left of there: `text-anchor`.
    anchor: f64,
    run: Option<usize>,
}

/// A text that is drawn as a square.
struct Run {
    text: String,
    shift_em: SketchPoint,
    shift: SketchPoint,
    anchor: f64,
}

/// The same drawing, as usvg shall have it.
struct Redraft<'a, 'input> {
    by_id: HashMap<&'a str, Node<'a, 'input>>,
    /// Ids that style sheets name.
    styled: HashSet<String>,
    out: String,
    longest: usize,
    elements: usize,
    deepest: usize,
    layers: Vec<String>,
    runs: HashMap<usize, Run>,
    /// Targets of the `use` elements that are being written out.
    open: Vec<NodeId>,
    bitmaps: usize,
    far: usize,
    loops: usize,
}

impl<'a, 'input> Redraft<'a, 'input> {
    fn of(document: &'a roxmltree::Document<'input>, length: usize, frame: Frame) -> Result<Self, PlanFileError> {
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
    fn spend(&mut self, depth: usize) -> Result<(), PlanFileError> {
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

    fn attributes(&mut self, node: Node, without: &[&str]) {
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

    fn number(&mut self, layer: String) -> usize {
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

    /// A text or a part of it: groups with the same styles, and a square of the font's size where a piece begins.
    fn text(&mut self, node: Node<'a, 'input>, layer: &str, cursor: &mut Cursor, depth: usize) -> Result<(), PlanFileError> {
        self.spend(depth)?;
        cursor.step(node);
        let tag = if name(node) == "text" { TEXT } else { "g" };
        let _ = write!(self.out, "<{tag} class=\"");
        escape(attribute(node, "class").unwrap_or_default(), &mut self.out);
        let _ = write!(self.out, " {SPAN}\"");
        self.attributes(node, &PLACES);
        self.out.push('>');
        for child in node.children() {
            if let Some(words) = child.text().filter(|_| child.is_text()) {
                self.words(words, layer, cursor, depth)?;
            } else if matches!(name(child), "tspan" | "textPath" | "a") {
                let layer = within(layer, child);
                let outer = cursor.anchor;
                cursor.anchor = anchored(cursor, child).anchor;
                self.text(child, &layer, cursor, depth + 1)?;
                cursor.anchor = outer;
            }
        }
        let _ = write!(self.out, "</{tag}>");
        Ok(())
    }

    fn words(&mut self, words: &str, layer: &str, cursor: &mut Cursor, depth: usize) -> Result<(), PlanFileError> {
        if cursor.run.is_none() && words.trim().is_empty() {
            return Ok(());
        }
        let number = match cursor.run {
            Some(number) => number,
            None => {
                self.spend(depth)?;
                let number = self.number(layer.to_owned());
                let _ = write!(self.out, "<rect id=\"{NUMBERED}{number}\" width=\"1em\" height=\"1em\" x=\"");
                escape(&cursor.x, &mut self.out);
                self.out.push_str("\" y=\"");
                escape(&cursor.y, &mut self.out);
                self.out.push_str("\"/>");
                let Cursor { shift_em, shift, anchor, .. } = *cursor;
                self.runs.insert(number, Run { text: String::new(), shift_em, shift, anchor });
                number
            }
        };
        cursor.run = Some(number);
        if let Some(run) = self.runs.get_mut(&number) {
            run.text.push_str(words);
        }
        Ok(())
    }

    /// What usvg made of it, as a sketch.
    fn read(&self, tree: &usvg::Tree, frame: Frame, metres_per_unit: Option<f64>) -> Result<Sketch, PlanFileError> {
        let all = tree.root().abs_bounding_box();
        let side = match frame.view_box {
            Some([_, _, width, height]) => width.max(height),
            None => f64::from(all.width().max(all.height())),
        };
        let origin = match frame.view_box {
            Some([_, _, _, height]) => [0.0, height],
            None => [f64::from(all.left()), f64::from(all.bottom())],
        };
        let mut reader = Reader { draft: self, pen: Pen::new(side), origin, uncoloured: 0 };
        reader.group(tree.root(), None, Bounds::ALL, 1.0)?;
        let Reader { mut pen, uncoloured, .. } = reader;
        if pen.sketch.paths.is_empty() {
            let why = match (self.bitmaps, uncoloured) {
                (0, 0) => "is it empty, or is all of it hidden?".to_owned(),
                (0, _) => format!("its {uncoloured} shapes have neither a fill nor a stroke"),
                (bitmaps, _) => format!("it only holds {bitmaps} bitmaps: save them as PNG and read these"),
            };
            return Err(PlanFileError::NothingDrawn { format: "SVG", why });
        }
        let notes = &mut pen.sketch.notes;
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        };
        note(self.bitmaps, "bitmaps in the SVG are not read");
        note(uncoloured, "shapes without fill and stroke are invisible and left out");
        note(self.loops, "copies (<use>) that hold themselves are left out");
        note(self.far, "shapes with coordinates over a thousand million are left out");
        note(pen.broken, "shapes with coordinates that are no numbers are left out");
        if frame.view_box.is_none() {
            notes.push("the SVG has neither a valid viewBox nor a size: the origin is the bottom-left of what is drawn".to_owned());
        }
        pen.sketch.metres_per_unit = metres_per_unit;
        Ok(pen.sketch)
    }
}

impl Cursor {
    /// To where an element of a text puts its words.
    fn step(&mut self, node: Node) {
        let first = |name: &str| attribute(node, name).and_then(|list| list.split([' ', ',', '\n', '\t']).find(|t| !t.is_empty()));
        let (x, y) = (first("x"), first("y"));
        if x.is_some() || y.is_some() {
            self.run = None;
        }
        if let Some(x) = x {
            (self.x, self.shift[0], self.shift_em[0]) = (x.to_owned(), 0.0, 0.0);
        }
        if let Some(y) = y {
            (self.y, self.shift[1], self.shift_em[1]) = (y.to_owned(), 0.0, 0.0);
        }
        for (k, name) in ["dx", "dy"].into_iter().enumerate() {
            let Some(length) = first(name) else { continue };
            match length.strip_suffix("em") {
                Some(sizes) => self.shift_em[k] += sizes.parse().unwrap_or(0.0),
                None => self.shift[k] += pixels(length).unwrap_or(0.0),
            }
        }
    }
}

/// The cursor inside of an element that may say where texts begin. Style sheets are not asked for that.
fn anchored(cursor: &Cursor, node: Node) -> Cursor {
    let styled = || {
        let style = attribute(node, "style")?;
        style.split(';').filter_map(|part| part.split_once(':')).find(|(key, _)| key.trim() == "text-anchor").map(|(_, value)| value.trim())
    };
    let anchor = match styled().or_else(|| attribute(node, "text-anchor")) {
        Some("start") => 0.0,
        Some("middle") => 0.5,
        Some("end") => 1.0,
        _ => cursor.anchor,
    };
    Cursor { anchor, ..cursor.clone() }
}

/// The layer of an element inside of another: its label or id, Illustrator's own name, classes, and Visio's title.
fn within(layer: &str, node: Node) -> String {
    let label = node.attribute((INKSCAPE, "label")).or_else(|| attribute(node, "data-name")).or_else(|| attribute(node, "id"));
    let title = node.children().find(|n| name(*n) == "title").and_then(|n| n.text());
    let classes = attribute(node, "class").unwrap_or_default().split_whitespace();
    pen::layer_within(layer, label.into_iter().chain(classes).chain(title))
}

fn escape(text: &str, out: &mut String) {
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
fn styles_of_groups(styles: &str) -> String {
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

/// Font sizes that a text is wide, where no font is at hand: as in Arial, on the whole.
fn width_em(text: &str) -> f64 {
    let letter = |c: char| match c {
        'i' | 'j' | 'l' | 'I' | 'f' | 't' | 'r' | ' ' | '.' | ',' | ':' | ';' | '|' | '!' | '\'' | '/' | '-' | '(' | ')' => 0.29,
        'm' | 'w' | 'M' | 'W' => 0.83,
        c if c.is_uppercase() => 0.68,
        _ => 0.54,
    };
    text.chars().map(letter).sum()
}

/// Whether a shape has numbers of 1e9 and more. usvg makes millions of curves of an arc of 1e38, and there is no such plan.
fn is_far(shape: Node) -> bool {
    const GEOMETRY: [&str; 15] = ["d", "points", "x", "y", "width", "height", "r", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2"];
    shape.attributes().filter(|a| GEOMETRY.contains(&a.name())).any(|a| has_far_number(a.value()))
}

/// Ten digits before the point, or an exponent of 9 and more.
fn has_far_number(text: &str) -> bool {
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

/// The number that leads back, if this id is one.
fn numbered(id: &str) -> Option<usize> {
    id.strip_prefix(NUMBERED)?.parse().ok()
}

fn colour(paint: &usvg::Paint) -> [u8; 3] {
    let first = |stops: &[usvg::Stop]| stops.first().map_or([128; 3], |stop| rgb(stop.color()));
    match paint {
        usvg::Paint::Color(colour) => rgb(*colour),
        usvg::Paint::LinearGradient(gradient) => first(gradient.stops()),
        usvg::Paint::RadialGradient(gradient) => first(gradient.stops()),
        usvg::Paint::Pattern(_) => [128; 3],
    }
}

fn rgb(colour: usvg::Color) -> [u8; 3] {
    [colour.red, colour.green, colour.blue]
}

/// From a shape's own coordinates to the sketch's.
#[derive(Clone, Copy)]
struct Placing {
    transform: Transform,
    /// The sketch's origin: x, and y (down) of the bottom.
    origin: SketchPoint,
}

impl Placing {
    fn at(&self, x: f64, y: f64) -> SketchPoint {
        let [sx, kx, tx] = [self.transform.sx, self.transform.kx, self.transform.tx].map(f64::from);
        let [ky, sy, ty] = [self.transform.ky, self.transform.sy, self.transform.ty].map(f64::from);
        [sx * x + kx * y + tx - self.origin[0], self.origin[1] - (ky * x + sy * y + ty)]
    }

    fn point(&self, point: Point) -> SketchPoint {
        self.at(f64::from(point.x), f64::from(point.y))
    }

    /// Length of what was 1 long, on average over directions.
    fn scale(&self) -> f64 {
        let [a, b, c, d] = [self.transform.sx, self.transform.kx, self.transform.ky, self.transform.sy].map(f64::from);
        (a * d - b * c).abs().sqrt()
    }
}

/// Walks what usvg made.
struct Reader<'a, 'b, 'input> {
    draft: &'a Redraft<'b, 'input>,
    pen: Pen,
    origin: SketchPoint,
    uncoloured: usize,
}

impl Reader<'_, '_, '_> {
    fn group(&mut self, group: &usvg::Group, number: Option<usize>, clip: Bounds, opacity: f64) -> Result<(), PlanFileError> {
        let opacity = opacity * f64::from(group.opacity().get());
        if opacity < FAINTEST {
            return Ok(());
        }
        let number = numbered(group.id()).or(number);
        let clip = match group.clip_path() {
            Some(path) => {
                let placing = self.placing(group.abs_transform().pre_concat(path.transform()));
                let rect = path.root().bounding_box();
                let corners =
                    [(rect.left(), rect.top()), (rect.right(), rect.top()), (rect.right(), rect.bottom()), (rect.left(), rect.bottom())];
                let corners = corners.map(|(x, y)| placing.at(f64::from(x), f64::from(y)));
                clip.both(Bounds::of(&corners).unwrap_or(Bounds::ALL))
            }
            None => clip,
        };
        for node in group.children() {
            match node {
                usvg::Node::Group(inner) => self.group(inner, number, clip, opacity)?,
                usvg::Node::Path(path) => self.path(path, number, clip, opacity)?,
                usvg::Node::Image(_) | usvg::Node::Text(_) => {}
            }
        }
        Ok(())
    }

    fn placing(&self, transform: Transform) -> Placing {
        Placing { transform, origin: self.origin }
    }

    fn path(&mut self, path: &usvg::Path, number: Option<usize>, clip: Bounds, opacity: f64) -> Result<(), PlanFileError> {
        let number = numbered(path.id()).or(number);
        let run = number.and_then(|n| self.draft.runs.get(&n));
        let shown = |own: usvg::Opacity| opacity * f64::from(own.get()) >= FAINTEST;
        let fill = path.fill().filter(|fill| shown(fill.opacity()));
        let stroke = path.stroke().filter(|stroke| shown(stroke.opacity()));
        if !path.is_visible() || (fill.is_none() && stroke.is_none()) {
            self.uncoloured += usize::from(run.is_none() && path.fill().is_none() && path.stroke().is_none());
            return Ok(());
        }
        let placing = self.placing(path.abs_transform());
        let layer = number.and_then(|n| self.draft.layers.get(n)).cloned().unwrap_or_default();
        if let Some(run) = run {
            return self.pen.write(run.piece(path.data().bounds(), placing, layer));
        }
        let look = Look {
            fill: fill.map(|fill| colour(fill.paint())),
            stroke: stroke.map(|stroke| colour(stroke.paint())),
            width: stroke.map_or(0.0, |stroke| f64::from(stroke.width().get()) * placing.scale()),
            dashed: stroke.is_some_and(|stroke| stroke.dasharray().is_some()),
            layer,
        };
        let steps = path.data().segments().map(|segment| match segment {
            PathSegment::MoveTo(p) => Step::Move(placing.point(p)),
            PathSegment::LineTo(p) => Step::Line(placing.point(p)),
            PathSegment::QuadTo(a, p) => Step::Quadratic(placing.point(a), placing.point(p)),
            PathSegment::CubicTo(a, b, p) => Step::Cubic(placing.point(a), placing.point(b), placing.point(p)),
            PathSegment::Close => Step::Close,
        });
        self.pen.draw(steps, clip, &look)
    }
}

impl Run {
    /// The text where its square is: that begins at the text's x and y, and its side is the font's size.
    fn piece(&self, square: usvg::Rect, placing: Placing, layer: String) -> Piece {
        let em = f64::from(square.width());
        let width_em = width_em(self.text.trim());
        let x = f64::from(square.left()) + self.shift[0] + em * (self.shift_em[0] - self.anchor * width_em);
        let y = f64::from(square.top()) + self.shift[1] + em * self.shift_em[1];
        let (at, on) = (placing.at(x, y), placing.at(x + em, y));
        Piece { at, em: [0, 1].map(|k| on[k] - at[k]), width_em, text: self.text.clone(), layer }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(head: &str, body: &str) -> String {
        format!("<svg xmlns=\"{SVG}\" xmlns:xlink=\"{XLINK}\" xmlns:inkscape=\"{INKSCAPE}\" xmlns:v=\"{VISIO}\" {head}>{body}</svg>")
    }

    /// A drawing of 200 × 100 units.
    fn drawn(body: &str) -> Sketch {
        read(&svg("viewBox=\"0 0 200 100\"", body)).unwrap()
    }

    fn error(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    const LINE: &str = "<path d='M10 10H30' stroke='black'/>";

    #[test]
    fn y_is_turned_up_and_the_papers_size_is_none_of_the_plans() {
        for head in ["viewBox='0 0 200 100'", "viewBox='0 0 200 100' width='420mm' height='297mm'", "width='200' height='100px'"] {
            let sketch = read(&svg(head, LINE)).unwrap();
            assert_eq!(sketch.paths[0].points, [[10.0, 90.0], [30.0, 90.0]], "{head}");
            assert_eq!((sketch.metres_per_unit, sketch.notes.len()), (None, 0), "{head}");
        }
        let shifted = read(&svg("viewBox='-50 5 200 100'", LINE)).unwrap();
        assert_eq!(shifted.paths[0].points, [[60.0, 95.0], [80.0, 95.0]]);
    }

    #[test]
    fn without_a_size_what_is_drawn_gives_the_origin() {
        for head in ["", "viewBox='0 0 0 0'", "viewBox='a b' width='100%'", "viewBox='0 0 nan 5'", "width='-3' height='0'"] {
            let sketch = read(&svg(head, "<path d='M10 10V30H50' stroke='black' fill='none'/>")).unwrap();
            assert_eq!(sketch.paths[0].points, [[0.0, 20.0], [0.0, 0.0], [40.0, 0.0]], "{head}");
            assert!(sketch.notes[0].contains("neither a valid viewBox nor a size"), "{head}");
        }
    }

    #[test]
    fn transforms_copies_and_symbols_are_applied() {
        let sketch = drawn(
            "<defs><symbol id='door' viewBox='0 0 10 10'><line id='leaf' x2='10' stroke='#f00'/></symbol><g id='w'><path d='M0 0H5' stroke='#000'/></g></defs>
             <g id='A-DOOR' transform='translate(100 0) scale(2)'><use xlink:href='#door' x='5' y='5' width='20' height='20'/></g>
             <use href='#w' x='7' transform='rotate(90)'/>",
        );
        let [door, wall] = &sketch.paths[..] else { panic!("{:?}", sketch.paths) };
        assert_eq!(door.points, [[110.0, 90.0], [150.0, 90.0]]);
        assert_eq!((door.stroke, door.layer.as_str(), door.width), (Some([255, 0, 0]), "A-DOOR/door/leaf", 4.0));
        let near = |a: SketchPoint, b: SketchPoint| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-4;
        assert!(near(wall.points[0], [0.0, 93.0]) && near(wall.points[1], [0.0, 88.0]), "{:?}", wall.points);
        assert_eq!((wall.layer.as_str(), door.group, wall.group), ("w", 0, 1));
    }

    #[test]
    fn layers_have_labels_classes_and_titles() {
        let sketch = drawn(
            "<style>.st1 { stroke: #00ff00; stroke-width: 3; stroke-dasharray: 4 } #odd { fill: #0000ff }</style>
             <g id='layer1' inkscape:label='Walls' inkscape:groupmode='layer'>
               <g class='a b'><title>Exterior wall.12</title><path id='p1' class='st1' fill='none' d='M0 0H9'/></g>
             </g><rect id='odd' width='9' height='9'/>",
        );
        let [wall, odd] = &sketch.paths[..] else { panic!("{:?}", sketch.paths) };
        assert_eq!(wall.layer, "Walls/a/b/Exterior wall.12/p1/st1");
        assert_eq!((wall.stroke, wall.width, wall.dashed, wall.fill), (Some([0, 255, 0]), 3.0, true, None));
        assert_eq!((odd.layer.as_str(), odd.fill, odd.closed, odd.points.len()), ("odd", Some([0, 0, 255]), true, 4));
    }

    #[test]
    fn hidden_things_are_left_out_and_clips_cut() {
        let sketch = drawn(
            "<style>.off { display: none }</style><clipPath id='c'><rect x='10' width='20' height='100'/></clipPath>
             <g style='display:none'><path d='M0 0H9' stroke='red'/></g><path class='off' d='M0 0H9' stroke='red'/>
             <g visibility='hidden'><path d='M0 0H9' stroke='red'/></g><g opacity='0'><path d='M0 0H9' stroke='red'/></g>
             <path d='M0 0H9' stroke='red' stroke-opacity='0'/><path d='M0 0h9v9z' fill='none'/><text class='off'>no</text>
             <g clip-path='url(#c)'><path d='M0 50H100' stroke='black'/><path d='M50 50H100' stroke='red'/></g>",
        );
        assert_eq!((sketch.paths.len(), sketch.texts.len()), (1, 0));
        assert_eq!(sketch.paths[0].points, [[10.0, 50.0], [30.0, 50.0]]);
        assert!(sketch.notes[0].starts_with("1 shapes without fill and stroke"), "{:?}", sketch.notes);
    }

    #[test]
    fn what_usvg_would_drop_or_cannot_show_is_drawn() {
        let sketch = drawn(
            "<defs><pattern id='hatch' width='1' height='1'><path d='M0 0H1' stroke='url(#hatch)'/></pattern>
               <linearGradient id='g'><stop stop-color='#102030'/><stop offset='1'/></linearGradient></defs>
             <rect width='9' height='9' fill='url(#hatch)'/><rect width='9' height='9' fill='url(#g)'/>
             <path d='M0 0H9' stroke='#000' style='filter:url(#gone);mask:url(#m);marker-end:url(#m)'/>
             <g clip-path='url(#t)'><clipPath id='t'><text>A</text></clipPath><path d='M0 0H9' stroke='#000'/></g>
             <image href='data:image/png;base64,AAAA' width='5' height='5'/>",
        );
        let fills: Vec<_> = sketch.paths.iter().map(|p| p.fill).collect();
        assert_eq!(fills, [Some([128; 3]), Some([16, 32, 48]), None, None]);
        assert_eq!(sketch.notes, ["1 bitmaps in the SVG are not read"]);
    }

    #[test]
    fn arcs_are_curves_and_an_outline_with_its_hole_is_one_group() {
        let sketch = drawn("<path d='M0 0H90V90H0ZM10 10H20V20H10Z'/><path d='M0 0A50 50 0 0 1 50 50' fill='none' stroke='#000'/>");
        let looks: Vec<_> = sketch.paths.iter().map(|p| (p.group, p.closed, p.curved)).collect();
        assert_eq!(looks, [(0, true, false), (0, true, false), (1, false, true)]);
        for pair in sketch.paths[2].points.windows(2) {
            let middle = [0, 1].map(|k| (pair[0][k] + pair[1][k]) / 2.0);
            let off = 50.0 - middle[0].hypot(middle[1] - 50.0);
            // A curve's chords, and the curve that stands for the arc (0.03 % of its radius).
            assert!(off.abs() < 200.0 * pen::CHORD_ERROR + 0.015, "{off}");
        }
    }

    #[test]
    fn texts_are_where_their_groups_put_them() {
        let sketch = drawn(
            "<path d='M0 0H9' stroke='red'/><style>.small { font-size: 5px } text { font-size: 10px }</style>
             <g id='Rooms' transform='translate(20 0) scale(2)'><text id='t' x='10' y='20' class='small'>Room
               <tspan>12</tspan><tspan x='10' dy='1.2em'>Store</tspan></text></g>
             <text x='100' y='50' text-anchor='middle'>Lift</text><text x='1' y='2'> </text>",
        );
        let [room, store, lift] = &sketch.texts[..] else { panic!("{:?}", sketch.texts) };
        assert_eq!((room.text.as_str(), room.at, room.layer.as_str()), ("Room 12", [40.0, 60.0], "Rooms/t/small"));
        assert_eq!(room.height, 10.0 * 0.7);
        assert!(store.text == "Store" && store.at[0] == 40.0 && (store.at[1] - 48.0).abs() < 1e-4, "{store:?}");
        assert!(lift.text == "Lift" && (lift.at[0] - 92.0).abs() < 1.0, "{lift:?}");
    }

    #[test]
    fn only_visios_drawing_scale_is_a_scale() {
        let page = |drawing: f64| {
            let page = format!("<g><v:pageProperties v:drawingScale='{drawing}' v:pageScale='0.0393701'/>{LINE}</g>");
            read(&svg("width='8.5in' height='11in' viewBox='0 0 612 792'", &page)).unwrap().metres_per_unit
        };
        // 1:50, with 72 units an inch.
        assert!((page(1.968_505).unwrap() - 50.0 * 0.0254 / 72.0).abs() < 1e-9);
        assert_eq!(page(0.0393701), None);
    }

    #[test]
    fn what_is_no_svg_or_shows_nothing_is_refused_with_a_remedy() {
        assert!(error("").contains("cannot be read"));
        assert!(error("<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0").contains("save it as plain SVG"));
        assert!(error("<html><body/></html>").contains("<html>"));
        assert!(error(&svg("", "")).contains("is it empty"));
        assert!(error(&svg("", "<image href='plan.png'/>")).contains("1 bitmaps"));
        assert!(error(&svg("", "<path d='M0 0h9v9z' fill='none'/>")).contains("1 shapes have neither"));
    }

    #[test]
    fn coordinates_that_are_no_numbers_are_left_out() {
        let sketch = drawn(
            "<path d='M0 0H9' stroke='#000'/><path d='M0 0L1e999 5L9 9' stroke='#000'/><path d='M0 0Lnan 5' stroke='#000'/>
             <rect width='nan' height='5'/><circle r='inf'/><g transform='scale(0)'><rect width='5' height='5'/></g>
             <g transform='scale(1e30)'><g transform='scale(1e30)'><rect width='5' height='5'/></g></g>",
        );
        assert!(sketch.paths.iter().flat_map(|p| &p.points).flatten().all(|v| v.is_finite()));
        assert_eq!(sketch.paths[0].points, [[0.0, 100.0], [9.0, 100.0]]);
    }

    #[test]
    fn arcs_of_an_astronomical_size_are_left_out() {
        let sketch =
            drawn(&format!("{LINE}<path d='M0 0L11e38 1A1 1 0 0 1 5 5z'/><circle r='1e30'/><rect width='9' height='1E+12' rx='1e11'/>"));
        assert_eq!((sketch.paths.len(), sketch.notes.len()), (1, 1), "{:?}", sketch.notes);
        for far in ["1e9", "M0 0L-1234567890 5", "1.5E+12,3", "00001e38", ".5e10"] {
            assert!(has_far_number(far), "{far}");
        }
        for near in
            ["123456789", "0.12345678901234", "1e8", "1e-30-5", "2em", "M1.5.5-3.000000000001", "0000000000001", "1 2 3 4 5 6 7 8 9 10 11"]
        {
            assert!(!has_far_number(near), "{near}");
        }
    }

    #[test]
    fn links_in_circles_end() {
        let sketch = drawn(&format!(
            "{LINE}<g id='a'><use href='#b'/></g><g id='b'><use href='#a'/></g><use id='c' href='#c'/><symbol id='s'><use href='#s'/>{LINE}</symbol><use href='#s'/>
             <linearGradient id='x' href='#y'/><linearGradient id='y' href='#x'/><rect width='5' height='5' fill='url(#x)'/>
             <clipPath id='k' clip-path='url(#k)'><rect clip-path='url(#k)' width='5' height='5'/></clipPath><rect clip-path='url(#k)' width='5' height='5'/>",
        ));
        assert!(sketch.notes.iter().any(|n| n.contains("hold themselves")), "{:?}", sketch.notes);
    }

    #[test]
    fn bombs_are_refused_in_bounded_time() {
        let deep = format!("{}{LINE}{}", "<g>".repeat(50_000), "</g>".repeat(50_000));
        assert!(error(&svg("", &deep)).contains("nested deeper than 150"));
        // Depth that is allowed does not overflow the stack.
        let allowed = DEEPEST - 1;
        assert_eq!(drawn(&format!("{}{LINE}{}", "<g>".repeat(allowed), "</g>".repeat(allowed))).paths.len(), 1);
        let chain: String = (0..1000).map(|i| format!("<g id='u{i}'><use href='#u{}'/></g>", i + 1)).collect();
        assert!(error(&svg("", &chain)).contains("nested deeper"));

        let copies: String = (0..10).map(|i| format!("<g id='b{}'>{}</g>", i + 1, format!("<use href='#b{i}'/>").repeat(10))).collect();
        assert!(error(&svg("", &format!("<g id='b0'>{LINE}</g>{copies}"))).contains("more than"));

        let laughs: String = (1..10).map(|i| format!("<!ENTITY l{i} \"{}\">", format!("&l{};", i - 1).repeat(10))).collect();
        let bomb = format!("<!DOCTYPE svg [<!ENTITY l0 \"lol\">{laughs}]>{}", svg("", "<text>&l9;</text>"));
        assert!(error(&bomb).contains("cannot be read"));
        let long = format!("<!DOCTYPE svg [<!ENTITY a \"{}\">]>{}", "x".repeat(1_000_000), svg("", &"<text>&a;</text>".repeat(1000)));
        assert!(error(&long).contains("entities may grow to 953 MB"), "{}", error(&long));
    }

    #[test]
    fn style_sheets_that_would_take_hours_are_refused() {
        let nested = format!("{}{LINE}{}", "<g>".repeat(100), "</g>".repeat(100));
        assert!(error(&svg("", &format!("<style>g g g g g g rect {{ fill: red }}</style>{nested}"))).contains("too intricate"));
        let rules = ".a{}".repeat(200_000);
        assert!(error(&svg("", &format!("<style>{rules}</style>{}", LINE.repeat(20_000)))).contains("too intricate"));
        let chain: String =
            (0..5000).map(|i| format!("<linearGradient id='g{i}' href='#g{}'/><path d='M{i} 0V9' stroke='url(#g{i})'/>", i + 1)).collect();
        assert_eq!(drawn(&chain).paths.len(), 5000);
    }

    #[test]
    fn entities_of_illustrator_are_fine() {
        let body = svg("viewBox='0 0 200 100'", "<path style=\"&st0;\" d='M10 10H30'/>");
        let text = format!("<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\" \"svg11.dtd\" [<!ENTITY st0 \"stroke:#0f0;\">]>{body}");
        assert_eq!(read(&text).unwrap().paths[0].stroke, Some([0, 255, 0]));
    }

    #[test]
    fn a_million_paths_are_refused() {
        assert!(error(&svg("", &"<path d='M0 0H9'/>".repeat(1_000_000))).contains("more than 500001 elements"));
    }

    #[test]
    fn style_sheets_name_the_groups_that_texts_become() {
        let styles = "text, .text > tspan{text-anchor:middle}#text{}[a=text]{}";
        assert_eq!(styles_of_groups(styles), "a, .text > .was-tspan{text-anchor:middle}#text{}[a=text]{}");
    }
}

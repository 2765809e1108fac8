//! Where are the texts? They are drawn as squares of their size, which usvg puts in their places.

use std::fmt::Write;

use usvg::roxmltree::Node;

use super::super::PlanFileError;
use super::super::drafter::Letters;
use super::super::sketch::SketchPoint;
use super::NUMBERED;
use super::redraft::{Redraft, SPAN, TEXT, escape, within};
use super::walk::Placing;
use super::xml::{attribute, name, pixels};

/// Attributes that place a text's letters.
const PLACES: [&str; 7] = ["x", "y", "dx", "dy", "rotate", "textLength", "class"];

/// Where a text begins: at an attribute's word, and so many font sizes and units on from it.
#[derive(Debug, Clone, Default)]
pub(super) struct Cursor {
    x: String,
    y: String,
    shift_em: SketchPoint,
    shift: SketchPoint,
    /// Share of its width that it begins left of there: `text-anchor`.
    anchor: f64,
    run: Option<usize>,
}

/// A text that is drawn as a square.
pub(super) struct Run {
    text: String,
    shift_em: SketchPoint,
    shift: SketchPoint,
    anchor: f64,
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
pub(super) fn anchored(cursor: &Cursor, node: Node) -> Cursor {
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

impl Run {
    /// The text where its square is: that begins at the text's x and y, and its side is the font's size.
    pub(super) fn piece(&self, square: usvg::Rect, placing: Placing, layer: String) -> Letters {
        let em = f64::from(square.width());
        let width_em = width_em(self.text.trim());
        let x = f64::from(square.left()) + self.shift[0] + em * (self.shift_em[0] - self.anchor * width_em);
        let y = f64::from(square.top()) + self.shift[1] + em * self.shift_em[1];
        let (at, on) = (placing.at(x, y), placing.at(x + em, y));
        Letters { at, em: [0, 1].map(|k| on[k] - at[k]), width_em, text: self.text.clone(), layer }
    }
}

impl<'a, 'input> Redraft<'a, 'input> {
    /// A text or a part of it: groups with the same styles, and a square of the font's size where a piece begins.
    pub(super) fn text(&mut self, node: Node<'a, 'input>, layer: &str, cursor: &mut Cursor, depth: usize) -> Result<(), PlanFileError> {
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
}

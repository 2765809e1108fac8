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

mod frame;
mod letters;
mod redraft;
mod walk;
mod xml;

use std::collections::HashSet;

use usvg::roxmltree::{self, ParsingOptions};

use super::PlanFileError;
use super::sketch::Sketch;
use crate::text as files;
use frame::{Frame, exported_from, metres_per_unit};
use redraft::Redraft;
use xml::name;

/// Most nodes of the XML, comments and blanks between elements among them.
const MOST_NODES: u32 = 4_000_000;
/// What entities may add to it, bytes.
const LONGEST_ENTITIES: usize = 64 << 20;
/// References that the XML parser follows within one reference to an entity.
const REFERENCES_WITHIN: usize = 255;
/// A number that leads back begins with this: no file has such an id.
const NUMBERED: &str = "\u{b6}";
/// Applies to all: usvg would leave out what has a broken filter, and follow links without end.
const STYLE: &str = "* { filter: none !important; mask: none !important; marker-start: none !important; marker-mid: none !important; \
                     marker-end: none !important } clipPath, clipPath * { clip-path: none !important }";

const SVG: &str = "http://www.w3.org/2000/svg";
const XLINK: &str = "http://www.w3.org/1999/xlink";
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
const VISIO: &str = "http://schemas.microsoft.com/visio/2003/SVGExtensions/";

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

#[cfg(test)]
mod tests;

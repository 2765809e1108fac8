//! Where and how large is the drawing? Its viewBox, and the metres of those that say them.

use usvg::roxmltree::Node;

use super::VISIO;
use super::xml::{attribute, pixels};

/// The root's viewBox, or its size as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    /// x, y, width, height; `None` where the file has no valid one.
    pub view_box: Option<[f64; 4]>,
    /// Width of the paper in pixels.
    paper_px: Option<f64>,
}

impl Frame {
    pub(super) fn of(root: Node) -> Self {
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
pub(super) fn exported_from(root: Node, frame: Frame) -> Option<[f64; 2]> {
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
pub(super) fn metres_per_unit(root: Node, frame: Frame) -> Option<f64> {
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

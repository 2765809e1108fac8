//! What frames the sheet? A rectangle around all the rest, and nothing that touches it.

use super::super::bounds::Bounds;
use super::Drawn;

/// The rest keeps this far from a frame, of the frame's size.
const APART: f64 = 0.01;
/// A sheet has an edge, a margin, and perhaps one more.
const FRAMES_MOST: usize = 4;

/// The drawing without the frames of its sheet (there may be several, one within the other).
pub(super) fn without<'a>(drawn: &'a [Drawn<'a>], notes: &mut Vec<String>) -> Vec<&'a Drawn<'a>> {
    let mut kept: Vec<&Drawn<'_>> = drawn.iter().filter(|path| path.points.len() > 1).collect();
    let before = kept.len();
    // Largest last; each is a frame as long as it holds all others at a distance. What is not finite holds nothing.
    let mut order: Vec<(usize, Option<Bounds>)> = kept.iter().map(|path| Bounds::of(&path.points)).enumerate().collect();
    order.sort_by(|(_, a), (_, b)| a.map_or(0.0, Bounds::diagonal).total_cmp(&b.map_or(0.0, Bounds::diagonal)));
    let mut framed: Vec<usize> = Vec::new();
    while let Some((last, Some(frame))) = order.pop() {
        let apart = frame.size().map(|side| APART * side);
        let holds = |at: &[f64; 2]| (0..2).all(|k| at[k] > frame.low[k] + apart[k] && at[k] < frame.high[k] - apart[k]);
        if framed.len() == FRAMES_MOST
            || order.is_empty()
            || !is_rectangle(kept[last], frame)
            || !order.iter().all(|(i, _)| kept[*i].points.iter().all(holds))
        {
            break;
        }
        framed.push(last);
    }
    framed.sort_unstable_by(|a, b| b.cmp(a));
    for at in framed {
        kept.remove(at);
    }
    if kept.len() < before {
        notes.push(format!("{} rectangles around all the rest are taken for frames of the sheet", before - kept.len()));
    }
    kept
}

/// Whether it is the outline of its own bounds.
fn is_rectangle(path: &Drawn<'_>, all: Bounds) -> bool {
    let near = |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-3 * size;
    let [width, height] = all.size();
    let on_rim = |at: &[f64; 2]| {
        let [left, right] = [all.low[0], all.high[0]].map(|x| near(at[0], x, width));
        let [low, high] = [all.low[1], all.high[1]].map(|y| near(at[1], y, height));
        (left || right) && (low || high)
    };
    path.points.len() >= 4 && path.points.iter().all(on_rim)
}

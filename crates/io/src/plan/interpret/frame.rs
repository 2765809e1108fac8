//! What frames the sheet? A rectangle around all the rest, and nothing that touches it.

use super::pens::Bounds;
use super::{Drawn, Piece};

/// The rest keeps this far from a frame, of the frame's size.
const APART: f64 = 0.01;
/// A sheet has an edge, a margin, and perhaps one more.
const FRAMES_MOST: usize = 4;

/// The drawing without the frames of its sheet (there may be several, one within the other).
pub(super) fn without<'a>(drawn: &'a [Drawn<'a>], notes: &mut Vec<String>) -> Vec<&'a Drawn<'a>> {
    let mut kept: Vec<&Drawn<'_>> = drawn.iter().filter(|path| path.points.len() > 1).collect();
    let before = kept.len();
    // Largest last; each is a frame as long as it holds all others at a distance.
    let diagonal = |path: &Drawn<'_>| {
        let [width, height] = bounds(path).size();
        width.hypot(height)
    };
    let mut order: Vec<usize> = (0..kept.len()).collect();
    order.sort_by(|a, b| diagonal(kept[*a]).total_cmp(&diagonal(kept[*b])));
    let mut framed: Vec<usize> = Vec::new();
    while let Some(last) = order.pop() {
        let frame = bounds(kept[last]);
        let apart = frame.size().map(|side| APART * side);
        let holds = |at: &[f64; 2]| (0..2).all(|k| at[k] > frame.low[k] + apart[k] && at[k] < frame.high[k] - apart[k]);
        if framed.len() == FRAMES_MOST
            || order.is_empty()
            || !is_rectangle(kept[last])
            || !order.iter().all(|i| kept[*i].points.iter().all(holds))
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

fn bounds(path: &Drawn<'_>) -> Bounds {
    let pieces: Vec<Piece> = path.points.iter().map(|at| Piece { from: *at, to: *at }).collect();
    Bounds::of(&pieces)
}

/// Whether it is the outline of its own bounds.
fn is_rectangle(path: &Drawn<'_>) -> bool {
    let (all, near) = (bounds(path), |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-3 * size);
    let [width, height] = all.size();
    let on_rim = |at: &[f64; 2]| {
        let [left, right] = [all.low[0], all.high[0]].map(|x| near(at[0], x, width));
        let [low, high] = [all.low[1], all.high[1]].map(|y| near(at[1], y, height));
        (left || right) && (low || high)
    };
    path.points.len() >= 4 && path.points.iter().all(on_rim)
}

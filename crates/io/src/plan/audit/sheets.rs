//! Is this one drawing? Storeys side by side on a sheet are parts of like size that nothing joins.

use planwalk_types::Pt2;

use super::finding::Finding;
use super::ground::{Ground, Place};

/// Parts are looked at by squares of this side, metres; what is nearer than that is joined.
const SQUARE_M: f64 = 1.0;
/// Smallest part, metres in both directions: a hut beside a house is no storey.
const SMALLEST_M: f64 = 5.0;
/// Parts of like size differ by at most this much, of the larger, in both directions.
const LIKE: f64 = 0.25;

/// The parts, if there are several that could be storeys of one building.
pub(super) fn several(ground: &Ground) -> Vec<Finding> {
    let mut parts = parts(ground);
    parts.retain(|part| part.size().iter().all(|size| *size >= SMALLEST_M));
    // The largest and all that are like it.
    let Some(largest) = parts.iter().map(Part::size).max_by(|a, b| (a[0] * a[1]).total_cmp(&(b[0] * b[1]))) else { return Vec::new() };
    let is_like = |part: &Part| part.size().iter().zip(largest).all(|(size, of)| *size >= (1.0 - LIKE) * of && *size <= (1.0 + LIKE) * of);
    parts.retain(is_like);
    let count = parts.len();
    let finding = |part: &Part| {
        let [x, y] = [0, 1].map(|k| 0.5 * (part.low[k] + part.high[k]));
        Finding::SeveralDrawings { at: Pt2::new(ground.origin.x + x, ground.origin.y + y), size_m: part.size(), count }
    };
    if count > 1 { parts.iter().map(finding).collect() } else { Vec::new() }
}

/// What is joined, metres from the grid's corner.
struct Part {
    low: [f64; 2],
    high: [f64; 2],
}

impl Part {
    fn size(&self) -> [f64; 2] {
        [0, 1].map(|k| self.high[k] - self.low[k])
    }
}

fn parts(ground: &Ground) -> Vec<Part> {
    let block = (SQUARE_M / ground.cell_m).round().max(1.0) as usize;
    let (columns, rows) = (ground.width.div_ceil(block), ground.height.div_ceil(block));
    let mut waiting = vec![false; columns * rows];
    for (i, place) in ground.places.iter().enumerate() {
        if matches!(place, Place::Built | Place::Door) {
            waiting[i / ground.width / block * columns + i % ground.width / block] = true;
        }
    }
    let side_m = block as f64 * ground.cell_m;
    let mut parts = Vec::new();
    for start in 0..waiting.len() {
        if !std::mem::take(&mut waiting[start]) {
            continue;
        }
        let (mut open, mut low, mut high) = (vec![start], [usize::MAX; 2], [0; 2]);
        while let Some(i) = open.pop() {
            let at = [i % columns, i / columns];
            (low, high) = ([0, 1].map(|k| low[k].min(at[k])), [0, 1].map(|k| high[k].max(at[k] + 1)));
            for row in at[1].saturating_sub(1)..(at[1] + 2).min(rows) {
                for column in at[0].saturating_sub(1)..(at[0] + 2).min(columns) {
                    if std::mem::take(&mut waiting[row * columns + column]) {
                        open.push(row * columns + column);
                    }
                }
            }
        }
        parts.push(Part { low: low.map(|v| v as f64 * side_m), high: high.map(|v| v as f64 * side_m) });
    }
    parts
}

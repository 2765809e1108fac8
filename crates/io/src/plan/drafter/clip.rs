//! What of a chain lies within a box? Areas stay areas, lines fall into pieces.

use super::{Bounds, Chain, SketchPoint};

/// Sutherland & Hodgman 1974: the ring, cut by one side of the box after the other.
pub(super) fn cut_area(ring: &[SketchPoint], clip: Bounds) -> Vec<SketchPoint> {
    let mut points = ring.to_vec();
    for (axis, limit, sign) in [(0, clip.low[0], 1.0), (0, clip.high[0], -1.0), (1, clip.low[1], 1.0), (1, clip.high[1], -1.0)] {
        let depth = |p: &SketchPoint| sign * (p[axis] - limit);
        let mut kept = Vec::with_capacity(points.len());
        let mut from = points.last().copied();
        for to in points {
            if let Some(from) = from.filter(|from| (depth(from) < 0.0) != (depth(&to) < 0.0)) {
                let t = depth(&from) / (depth(&from) - depth(&to));
                let mut crossing = [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
                crossing[axis] = limit;
                kept.push(crossing);
            }
            if depth(&to) >= 0.0 {
                kept.push(to);
            }
            from = Some(to);
        }
        points = kept;
    }
    points.dedup();
    points
}

/// Liang & Barsky 1984: what of each piece is inside; pieces that meet stay one chain.
pub(super) fn cut_line(chain: &Chain, clip: Bounds) -> Vec<Vec<SketchPoint>> {
    let mut chains: Vec<Vec<SketchPoint>> = Vec::new();
    let ends = chain.points.iter().skip(1).chain(chain.points.first().filter(|_| chain.closed));
    for (from, to) in chain.points.iter().zip(ends) {
        let (mut begin, mut end) = (0.0_f64, 1.0_f64);
        for k in 0..2 {
            let run = to[k] - from[k];
            for (ahead, room) in [(-run, from[k] - clip.low[k]), (run, clip.high[k] - from[k])] {
                if ahead < 0.0 {
                    begin = begin.max(room / ahead);
                } else if ahead > 0.0 {
                    end = end.min(room / ahead);
                } else if room < 0.0 {
                    end = -1.0;
                }
            }
        }
        if begin < end {
            let at = |t: f64| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
            let (a, b) = (if begin == 0.0 { *from } else { at(begin) }, if end == 1.0 { *to } else { at(end) });
            match chains.last_mut().filter(|last| last.last() == Some(&a)) {
                Some(last) => last.push(b),
                None => chains.push(vec![a, b]),
            }
        }
    }
    chains
}

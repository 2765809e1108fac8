//! How long is each keyframe's unit, by something that is about as long everywhere?
//!
//! lengths of it in each keyframe's own unit ─▶ [`Yardstick`]s ─▶ [`edges`] that know the length of the unit alone, for `links`

use std::ops::Range;

use planwalk_types::Similarity;

use crate::visual::graph::{Edge, EdgeKind, information};
use crate::visual::map::{Keyframe, KeyframeId};

/// Something that is about as long everywhere, as measured around a keyframe.
#[derive(Debug, Clone, Copy)]
pub(super) struct Yardstick {
    pub keyframe: KeyframeId,
    /// In the keyframe's own unit.
    pub length: f64,
    /// Keyframes that measured much the same moments: all of them together count once.
    pub shared: usize,
}

/// Each keyframe's unit against that of the one where the length is nearest to the `usual` one; `sigma` says by how much, in logarithm,
/// it varies, given the logarithm of the usual over the found length.
pub(super) fn edges(yardsticks: &[Yardstick], usual: f64, sigma: impl Fn(f64) -> f64, kind: EdgeKind) -> Vec<Edge> {
    let off = |y: &Yardstick| libm::log(usual / y.length);
    let Some(measure) = yardsticks.iter().min_by(|a, b| off(a).abs().total_cmp(&off(b).abs())) else { return Vec::new() };
    let edge = |y: &Yardstick| {
        let information = information(f64::INFINITY, f64::INFINITY, sigma(off(y)) * (y.shared as f64).sqrt());
        let a_from_b = Similarity { scale: usual / y.length, ..Similarity::identity() };
        Edge { a: measure.keyframe, b: y.keyframe, a_from_b, information, kind }
    };
    yardsticks.iter().filter(|y| y.keyframe != measure.keyframe).map(edge).collect()
}

/// The keyframes within so many seconds of this one.
pub(super) fn around(keyframes: &[Keyframe], k: usize, seconds: f64) -> Range<usize> {
    let near = |other: &Keyframe| other.stamp.secs_since(keyframes[k].stamp).abs() < seconds;
    let first = keyframes[..k].iter().rposition(|other| !near(other)).map_or(0, |i| i + 1);
    let after = keyframes[k..].iter().position(|other| !near(other)).map_or(keyframes.len(), |i| k + i);
    first..after
}

//! Which seen point is which remembered one? Mutual nearest neighbours that nothing else comes near to (Lowe 2004).

use nalgebra::Vector3;

use super::descriptor::Descriptor;

/// Share of the bits up to which two patches are one: two of different points have half, give or take 3 %.
const ALIKE: f64 = 0.25;
/// The next best must be this much worse: windows in a row are alike.
const RATIO: f64 = 0.8;

/// A remembered point as it should be seen now.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Unit ray, camera frame.
    pub ray: Vector3<f64>,
    /// How far from there it may be, radians.
    pub gate_rad: f64,
    /// How many times twice as large it should look.
    pub octaves: i32,
    /// How it looked.
    pub looks: Descriptor,
}

/// A point of the newest picture.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Unit ray, camera frame.
    pub ray: Vector3<f64>,
    /// How it looks.
    pub looks: Descriptor,
}

/// Pairs (expected, seen), in the order of the first.
pub fn matches(expected: &[Expected], seen: &[Seen]) -> Vec<(usize, usize)> {
    // The best expected point of each seen one.
    let mut best_of_seen: Vec<Option<(f64, usize)>> = vec![None; seen.len()];
    let mut chosen: Vec<Option<usize>> = Vec::with_capacity(expected.len());
    for (e, wanted) in expected.iter().enumerate() {
        let least_cosine = libm::cos(wanted.gate_rad);
        let (mut best, mut second) = ((f64::INFINITY, None), f64::INFINITY);
        for (s, point) in seen.iter().enumerate().filter(|(_, s)| s.ray.dot(&wanted.ray) > least_cosine) {
            let Some(distance) = wanted.looks.distance(&point.looks, wanted.octaves) else { continue };
            if distance < best.0 {
                (second, best) = (best.0, (distance, Some(s)));
            } else if distance < second {
                second = distance;
            }
            if best_of_seen[s].is_none_or(|(least, _)| distance < least) {
                best_of_seen[s] = Some((distance, e));
            }
        }
        chosen.push(best.1.filter(|_| best.0 < ALIKE && best.0 < RATIO * second));
    }
    let mutual = |(e, s): (usize, Option<usize>)| s.filter(|s| best_of_seen[*s].is_some_and(|(_, of)| of == e)).map(|s| (e, s));
    chosen.into_iter().enumerate().filter_map(mutual).collect()
}

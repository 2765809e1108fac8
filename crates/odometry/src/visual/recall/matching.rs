//! Which seen point is which remembered one? Mutual nearest neighbours that nothing else comes near to (Lowe 2004).

use nalgebra::Vector3;

use super::descriptor::Descriptor;

/// Share of the bits up to which two patches are one: two of different points have half, give or take 3 %.
const ALIKE: f64 = 0.25;
/// The next best must be this much worse: windows in a row are alike. The second is what noise turns over in a patch, thrice.
const RATIO: f64 = 0.8;
const MARGIN: f64 = 0.05;

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
        chosen.push(best.1.filter(|_| best.0 < ALIKE && best.0 < (RATIO * second).min(second - MARGIN)));
    }
    let mutual = |(e, s): (usize, Option<usize>)| s.filter(|s| best_of_seen[*s].is_some_and(|(_, of)| of == e)).map(|s| (e, s));
    chosen.into_iter().enumerate().filter_map(mutual).collect()
}

#[cfg(test)]
mod tests {
    use planwalk_types::{GrayImage, Seed};
    use rand::RngExt;

    use super::*;
    use crate::visual::image::Pyramid;
    use crate::visual::recall::descriptor::Pattern;

    /// Descriptors of six patches of noise in a row, 60 px apart; the last two are the same.
    fn patches(noise: u64) -> Vec<Descriptor> {
        let mut own = Seed(noise).derive("noise", 0);
        let texture: Vec<f64> = {
            let mut rng = Seed(7).derive("texture", 0);
            (0..16 * 16 * 6).map(|_| rng.random_range(20.0..230.0)).collect()
        };
        let image = GrayImage::from_fn(420, 120, |u, v| {
            let patch = (u / 60).min(5).min(4);
            let (x, y) = ((u % 60) / 4, (v / 8) % 16);
            (texture[patch * 256 + y * 16 + x] + own.random_range(-5.0..5.0)) as u8
        });
        let pyramid = Pyramid::new(&image, 4);
        let pattern = Pattern::new(0.0);
        (0..6).map(|i| pattern.describe(&pyramid, (30.0 + 60.0 * f64::from(i), 60.0)).expect("inside")).collect()
    }

    fn ray(i: usize) -> Vector3<f64> {
        Vector3::new(0.1 * i as f64, 0.0, 1.0).normalize()
    }

    #[test]
    fn each_is_known_again_but_twins_and_what_is_out_of_reach() {
        let expect = |(i, looks): (usize, &Descriptor)| Expected { ray: ray(i), gate_rad: 1.0, octaves: 0, looks: *looks };
        let mut expected: Vec<Expected> = patches(1).iter().enumerate().map(expect).collect();
        let seen: Vec<Seen> = patches(2).iter().enumerate().map(|(i, looks)| Seen { ray: ray(i), looks: *looks }).collect();
        assert_eq!(matches(&expected, &seen), [(0, 0), (1, 1), (2, 2), (3, 3)], "the last two look alike");
        for e in &mut expected {
            e.gate_rad = 0.03;
        }
        assert_eq!(matches(&expected, &seen).len(), 6, "where only one of the twins can be, it is that");
        expected[0].ray = ray(3);
        assert_eq!(matches(&expected, &seen)[0], (1, 1), "it looks so, but cannot be there");
        assert!(matches(&expected, &[]).is_empty() && matches(&[], &seen).is_empty());
    }

    #[test]
    fn one_point_is_not_two() {
        let looks = patches(1)[0];
        let expected = [ray(0), ray(1)].map(|ray| Expected { ray, gate_rad: 1.0, octaves: 0, looks });
        let seen = [Seen { ray: ray(0), looks: patches(2)[0] }];
        assert_eq!(matches(&expected, &seen), [(0, 0)]);
    }
}

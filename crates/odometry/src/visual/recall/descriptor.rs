//! What does a point look like? 256 bits, each saying which of two spots beside it is brighter: BRIEF (Calonder, Lepetit, Strecha &
//! Fua 2010).
//!
//! The pattern stands upright in the world, as gravity says, so a head that leans changes nothing; ORB (Rublee et al. 2011) asks the
//! patch itself, which a patch of two wall colours answers at random. A point is described at two sizes, one twice the other, so that
//! it is known again from half or twice as far.

use planwalk_types::Seed;
use rand::RngExt;

use crate::visual::image::{Level, Pyramid, to_level};

/// Bits of a patch.
pub const BITS: u32 = 256;
/// Pyramid levels at which a point is described: the full size is noise.
const LEVELS: [usize; 2] = [1, 2];
/// Half side of the pattern, pixels of its level: 41 px of the picture at the first.
const REACH: f32 = 10.0;
/// What the pattern grows from: it is the same in every run, or nothing could be compared.
const PATTERN: Seed = Seed(0x00b2_1ef0);

/// 256 comparisons.
type Bits = [u64; 4];

/// How a point looks, at each of two sizes if the picture holds the patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    sizes: [Option<Bits>; 2],
}

impl Descriptor {
    /// Share of the bits that differ, 0 to 1; half of them do between any two patches. `octaves` is how many times twice as large the
    /// point looks in `other`: −1, 0 or 1. `None` where no size can be compared.
    pub fn distance(&self, other: &Self, octaves: i32) -> Option<f64> {
        let pairs = match octaves {
            0 => [(0, 0), (1, 1)],
            1 => [(0, 1); 2],
            -1 => [(1, 0); 2],
            _ => return None,
        };
        let (mut differ, mut compared) = (0, 0);
        for (own, of_other) in pairs {
            if let (Some(a), Some(b)) = (&self.sizes[own], &other.sizes[of_other]) {
                differ += a.iter().zip(b).map(|(a, b)| (a ^ b).count_ones()).sum::<u32>();
                compared += BITS;
            }
        }
        (compared > 0).then(|| f64::from(differ) / f64::from(compared))
    }
}

/// The pairs of spots, turned upright.
#[derive(Debug, Clone)]
pub struct Pattern(Vec<[f32; 4]>);

impl Pattern {
    /// For a camera that leans by `roll` radians: that much to its right is up.
    pub fn new(roll: f64) -> Self {
        let (sin, cos) = libm::sincos(roll);
        let mut rng = PATTERN.derive("pattern", 0);
        // The sum of three uniform numbers: a bell that ends at the patch's border, a third of its reach wide.
        let mut bell = || (0..3).map(|_| rng.random_range(-1.0..1.0f64)).sum::<f64>() / 3.0 * f64::from(REACH);
        let mut spot = || {
            let (x, y) = (bell(), bell());
            [(cos * x - sin * y) as f32, (sin * x + cos * y) as f32]
        };
        let pair = |_| {
            let ([a, b], [c, d]) = (spot(), spot());
            [a, b, c, d]
        };
        Self((0..BITS).map(pair).collect())
    }

    /// How the point at this pixel looks; `None` where the patch leaves the picture at both sizes.
    pub fn describe(&self, pyramid: &Pyramid, pixel: (f64, f64)) -> Option<Descriptor> {
        let sizes = LEVELS.map(|level| {
            let (x, y) = to_level(pixel.0, pixel.1, level);
            self.bits(pyramid.levels.get(level)?, x, y)
        });
        sizes.iter().any(Option::is_some).then_some(Descriptor { sizes })
    }

    fn bits(&self, level: &Level, x: f32, y: f32) -> Option<Bits> {
        // The bell's corners reach further than its sides by √2 when it is turned.
        if !level.holds(x, y, REACH * std::f32::consts::SQRT_2) {
            return None;
        }
        let mut bits = [0; 4];
        for (i, [a, b, c, d]) in self.0.iter().enumerate() {
            let brighter = level.sample(x + a, y + b) > level.sample(x + c, y + d);
            bits[i / 64] |= u64::from(brighter) << (i % 64);
        }
        Some(bits)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use planwalk_types::GrayImage;
    use proptest::prelude::*;

    use super::*;

    /// Blobs of all sizes from 4 px on, turned by `roll` and enlarged by `zoom` about (160, 120), lit as told, with noise of ± 4.
    fn picture(roll: f64, zoom: f64, light: (f64, f64), noise: u64) -> Pyramid {
        let (sin, cos) = libm::sincos(roll);
        let mut rng = Seed(noise).derive("noise", 0);
        let image = GrayImage::from_fn(320, 240, |u, v| {
            let (x, y) = ((u as f64 - 160.0) / zoom, (v as f64 - 120.0) / zoom);
            let (x, y) = (cos * x + sin * y, cos * y - sin * x);
            let blobs = (0..6).map(|i| {
                let (wave, i) = (20.0 + 11.0 * f64::from(i), f64::from(i));
                libm::sin(x * TAU / wave + i) * libm::sin((y + 0.3 * x) * TAU / (wave + 7.0) + 2.0 * i)
            });
            let value = 128.0 + 25.0 * blobs.sum::<f64>();
            (light.0 * value + light.1 + rng.random_range(-4.0..4.0)).clamp(0.0, 255.0) as u8
        });
        Pyramid::new(&image, 4)
    }

    fn looks(pyramid: &Pyramid, roll: f64, at: (f64, f64)) -> Descriptor {
        Pattern::new(roll).describe(pyramid, at).expect("the patch is inside")
    }

    const MIDDLE: (f64, f64) = (160.0, 120.0);

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20))]
        #[test]
        fn a_patch_keeps_its_bits_however_the_head_leans_and_the_light_falls(
            roll in -0.5..0.5f64, gain in 0.5..1.3f64, offset in -20.0..20.0f64, noise in 1u64..999,
        ) {
            let first = looks(&picture(0.0, 1.0, (1.0, 0.0), 0), 0.0, MIDDLE);
            let again = looks(&picture(roll, 1.0, (gain, offset), noise), roll, MIDDLE);
            // Pairs of about the same grey fall either way: a tenth of them.
            prop_assert!(first.distance(&again, 0).unwrap() < 0.12);
        }
    }

    #[test]
    fn twice_as_near_it_is_known_at_the_other_size_and_elsewhere_not_at_all() {
        let first = looks(&picture(0.0, 1.0, (1.0, 0.0), 1), 0.0, MIDDLE);
        let nearer = looks(&picture(0.0, 2.0, (1.0, 0.0), 2), 0.0, MIDDLE);
        assert!(first.distance(&nearer, 1).unwrap() < 0.15 && nearer.distance(&first, -1).unwrap() < 0.15);
        assert_eq!(first.distance(&nearer, 2), None);
        let elsewhere = looks(&picture(0.0, 1.0, (1.0, 0.0), 1), 0.0, (200.0, 95.0));
        assert!(first.distance(&elsewhere, 0).unwrap() > 0.3);
    }

    #[test]
    fn a_patch_that_leaves_the_picture_is_not_described() {
        let pyramid = picture(0.0, 1.0, (1.0, 0.0), 0);
        assert_eq!(Pattern::new(0.0).describe(&pyramid, (10.0, 120.0)), None);
        let near_the_border = Pattern::new(0.0).describe(&pyramid, (40.0, 120.0)).expect("the smaller patch is inside");
        assert!(near_the_border.sizes[0].is_some() && near_the_border.sizes[1].is_none());
    }
}

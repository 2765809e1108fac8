//! Which numbers does chance deal to particle `i`? A function of the seed and of `i`, not of a state.
//!
//! (seed, particle) ──Philox──▶ 64 bits ──Walsh functions of their 8 bytes──▶ four normal numbers
//!
//! Whoever asks for a particle gets its numbers, in whatever order, chunk or thread; and loops over particles become SIMD.
//! Source: Salmon, Moraes, Dror & Shaw 2011 (Philox2x32-10, which passes BigCrush).

use planwalk_types::Seed;

/// Standard deviation of the sum of 8 bytes, each uniform over 0..=255: √(8 · (256² − 1) / 12).
const SUM_SIGMA: f32 = 209.022_33;
/// Its mean.
const SUM_MEAN: f32 = 1020.0;

/// One stream of chance over all particles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chance {
    key: u32,
    /// The half of the counter that is the same for all particles.
    high: u32,
}

impl Chance {
    /// The stream for `name` of this seed.
    pub(crate) fn new(seed: Seed, name: &str) -> Self {
        let seed = seed.child(name, 0).0;
        Self { key: seed as u32, high: (seed >> 32) as u32 }
    }

    /// Four numbers for this particle: normal, near enough, and uncorrelated.
    ///
    /// Each is a sum of all 8 bytes with signs of its own (the first with none), which makes it symmetric, of variance 1, excess
    /// kurtosis −0.15, at most 4.9 σ. Signs that are orthogonal make them uncorrelated; their squares correlate by −0.075.
    #[inline(always)]
    pub(crate) fn normals(self, particle: u32) -> [f32; 4] {
        let [a, b] = philox([particle, self.high], self.key);
        // Two sums of 16 bits in one word; a bias keeps differences of 510 from borrowing out of their half.
        const BYTES: u32 = 0x00ff_00ff;
        const BIAS: u32 = 0x0200_0200;
        let (even_a, odd_a, even_b, odd_b) = (a & BYTES, (a >> 8) & BYTES, (b & BYTES), (b >> 8) & BYTES);
        let (sum_a, sum_b) = (even_a + odd_a, even_b + odd_b);
        let sums = sum_a + sum_b;
        let (low, high) = ((sums & 0xffff) as i32, (sums >> 16) as i32);
        let by_word = sum_a + BIAS - sum_b;
        let by_byte = (even_a + even_b) + BIAS - (odd_a + odd_b);
        let both = |word: u32| ((word & 0xffff) + (word >> 16)) as i32 - 0x400;
        let of = |sum: i32| sum as f32 * (1.0 / SUM_SIGMA);
        [((low + high) as f32 - SUM_MEAN) * (1.0 / SUM_SIGMA), of(low - high), of(both(by_word)), of(both(by_byte))]
    }
}

/// Ten rounds of Philox2x32.
#[inline(always)]
fn philox(counter: [u32; 2], key: u32) -> [u32; 2] {
    let ([mut left, mut right], mut key) = (counter, key);
    for _ in 0..10 {
        let product = u64::from(left) * 0xd256_d193;
        left = (product >> 32) as u32 ^ key ^ right;
        right = product as u32;
        key = key.wrapping_add(0x9e37_79b9);
    }
    [left, right]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_numbers() {
        // The known answers of Random123, the authors' own library.
        assert_eq!(philox([0, 0], 0), [0xff1d_ae59, 0x6cd1_0df2]);
        assert_eq!(philox([u32::MAX; 2], u32::MAX), [0x2c3f_628b, 0xab4f_d7ad]);
        assert_eq!(philox([0x243f_6a88, 0x85a3_08d3], 0x1319_8a2e), [0xdd7c_e038, 0xf62a_4c12]);
    }

    #[test]
    fn numbers_are_standard_normal_and_uncorrelated() {
        const N: u32 = 400_000;
        let chance = Chance::new(Seed(11), "test");
        let mut sum = [0.0f64; 4];
        let mut products = [[0.0f64; 4]; 4];
        let (mut fourth, mut largest) = ([0.0f64; 4], 0.0f64);
        for i in 0..N {
            let draw = chance.normals(i).map(f64::from);
            for j in 0..4 {
                sum[j] += draw[j] / f64::from(N);
                fourth[j] += draw[j].powi(4) / f64::from(N);
                largest = largest.max(draw[j].abs());
                (0..4).for_each(|k| products[j][k] += draw[j] * draw[k] / f64::from(N));
            }
        }
        let error = 1.0 / f64::from(N).sqrt();
        for j in 0..4 {
            assert!(sum[j].abs() < 4.5 * error, "mean {} of {j}", sum[j]);
            // Kurtosis 2.85; its standard error is √96 / √N.
            assert!((fourth[j] - 2.85).abs() < 4.5 * 9.8 * error, "fourth moment {} of {j}", fourth[j]);
            for (k, product) in products[j].iter().enumerate() {
                let expected = if j == k { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 4.5 * 1.4 * error, "product {product} of {j} and {k}");
            }
        }
        assert!(largest > 4.0 && largest < 4.9, "the largest of 1.6 million is {largest} σ");
    }

    #[test]
    fn tails_hold_what_a_normal_numbers_hold() {
        const N: u32 = 1_000_000;
        let chance = Chance::new(Seed(3), "test");
        let draws: Vec<[f32; 4]> = (0..N).map(|i| chance.normals(i)).collect();
        // Two-sided probabilities of a normal number. To first order a sum of eight lacks −κ/12 · φ(x)(x³ − 3x), κ = −0.15, of it.
        for (sigmas, normal, slack) in [(1.0, 0.3173, 0.02), (2.0, 0.0455, 0.06), (3.0, 0.0027, 0.1), (3.5, 4.65e-4, 0.2)] {
            let density = libm::exp(-0.5 * sigmas * sigmas) * 0.398_942;
            let expected = normal - 0.15 / 12.0 * density * (sigmas * sigmas * sigmas - 3.0 * sigmas);
            for j in 0..4 {
                let share = draws.iter().filter(|d| f64::from(d[j].abs()) > sigmas).count() as f64 / f64::from(N);
                assert!((share - expected).abs() < slack * normal, "{share} of draw {j} lie beyond {sigmas} σ, not {expected}");
            }
        }
    }

    #[test]
    fn neighbours_steps_and_seeds_are_independent() {
        const N: u32 = 200_000;
        let chance = |seed: u64, name: &str| Chance::new(Seed(seed), name);
        let with = |f: &dyn Fn(u32) -> f32, g: &dyn Fn(u32) -> f32| -> f64 {
            (0..N).map(|i| f64::from(f(i)) * f64::from(g(i))).sum::<f64>() / f64::from(N)
        };
        let (one, other, named) = (chance(1, "move"), chance(2, "move"), chance(1, "roughen"));
        for j in 0..4 {
            let own = |i: u32| one.normals(i)[j];
            let pairs =
                [with(&own, &|i| one.normals(i + 1)[j]), with(&own, &|i| other.normals(i)[j]), with(&own, &|i| named.normals(i)[j])];
            for correlation in pairs {
                assert!(correlation.abs() < 4.5 / f64::from(N).sqrt(), "correlation {correlation} of draw {j}");
            }
        }
    }

    #[test]
    fn every_byte_is_even() {
        const N: u32 = 1 << 18;
        let mut counts = vec![[0u32; 256]; 8];
        for i in 0..N {
            let [a, b] = philox([i, 77], 5);
            for (byte, count) in a.to_le_bytes().into_iter().chain(b.to_le_bytes()).zip(&mut counts) {
                count[usize::from(byte)] += 1;
            }
        }
        let expected = f64::from(N) / 256.0;
        for count in counts {
            let chi2: f64 = count.iter().map(|c| (f64::from(*c) - expected).powi(2) / expected).sum();
            // 255 degrees of freedom: mean 255, standard deviation √510; five of these.
            assert!((chi2 - 255.0).abs() < 5.0 * 510f64.sqrt(), "chi² {chi2}");
        }
    }
}

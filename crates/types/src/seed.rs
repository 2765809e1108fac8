//! Where does chance come from? A seed, a name and a step; never the machine.
//!
//! Streams are independent of each other and of the number of threads: whoever draws for (name, step) gets the
//! same numbers, whenever and wherever it is done.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// The generator of one stream. Xoshiro256++ is portable: the same bits on every platform.
pub type StreamRng = Xoshiro256PlusPlus;

/// What a whole run's chance grows from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seed(pub u64);

impl Seed {
    /// The stream for `name` at `step`.
    pub fn derive(self, name: &str, step: u64) -> StreamRng {
        StreamRng::seed_from_u64(self.child(name, step).0)
    }

    /// A seed for a part of the run that derives streams of its own.
    pub fn child(self, name: &str, step: u64) -> Seed {
        // FNV-1a over the name, then the finaliser of splitmix64 over all three: every bit of each reaches every bit.
        let name_hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        Seed(mix(mix(mix(self.0) ^ name_hash) ^ step))
    }
}

fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn the_same_name_and_step_give_the_same_stream() {
        assert_eq!(Seed(7).derive("resample", 3).next_u64(), Seed(7).derive("resample", 3).next_u64());
    }

    #[test]
    fn another_seed_name_or_step_gives_another_stream() {
        let draw = |seed: u64, name: &str, step: u64| Seed(seed).derive(name, step).next_u64();
        let all = [draw(7, "resample", 3), draw(8, "resample", 3), draw(7, "motion", 3), draw(7, "resample", 4)];
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b));
        }
    }
}

//! Random numbers that depend on nothing but what they are for: the SplitMix64 generator
//! (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014).
//!
//! Its output is part of what this crate promises (same seed, same bytes), so it is written out
//! here rather than taken from a crate whose next version may differ.

use super::{Vec3, vec3};

/// The increment of SplitMix64: the odd number nearest to 2^64 over the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64's output function: a bijection that spreads every input bit over all output bits.
pub fn mix(value: u64) -> u64 {
    let z = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream number `index` of those that belong to `seed`.
    pub fn new(seed: u64, index: u64) -> Random {
        Random { state: mix(mix(seed.wrapping_add(GOLDEN)).wrapping_add(index)) }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN);
        mix(self.state)
    }

    /// The next of the numbers 0 .. `count` - 1, as good as uniform where they are few beside 2^64.
    ///
    /// # Panics
    /// If `count` is zero.
    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// The next number, uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number, uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// The next number of mean 0 and variance 1 that is nearly normal: the sum of twelve uniform
    /// ones (Irwin and Hall), since that needs no logarithm.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    /// The next direction, uniform on the unit sphere, by rejection from the cube.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = vec3(self.signed(), self.signed(), self.signed());
            let square = v.dot(v);
            // The lower bound keeps the division well-conditioned.
            if (1e-4..=1.0).contains(&square) {
                return v / square.sqrt();
            }
        }
    }
}

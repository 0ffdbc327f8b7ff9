//! A random generator for the simulation: the same seed gives the same sequence on every machine.
//!
//! The simulation does not use the product's generator. The sealed cases must never change with the product, and a fault
//! of the product must not enter the cases that test it.

use std::f64::consts::TAU;

/// The xoshiro256++ generator (Blackman and Vigna), seeded from one word.
#[derive(Debug, Clone)]
pub(super) struct Rng([u64; 4]);

/// Returns the mixed bits of `word` (the SplitMix64 finaliser).
fn scramble(word: u64) -> u64 {
    let mut z = word;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl Rng {
    pub(super) fn new(seed: u64) -> Self {
        let mut word = seed;
        Self(std::array::from_fn(|_| {
            word = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
            scramble(word)
        }))
    }

    /// Creates an independent generator for each pair of labels.
    pub(super) fn stream(seed: u64, set: u64, index: u64) -> Self {
        let label = scramble(set.wrapping_mul(0xD6E8_FEB8_6659_FD93) ^ scramble(index + 1));
        Self::new(seed ^ label)
    }

    pub(super) fn word(&mut self) -> u64 {
        let s = &mut self.0;
        let out = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let shifted = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= shifted;
        s[3] = s[3].rotate_left(45);
        out
    }

    /// Returns a number uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number uniform from `low` to `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a number log-uniform from `low` to `high`, both positive.
    pub(super) fn between_log(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.unit())
    }

    /// Returns an index uniform in 0..`count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.word()) * count as u128) >> 64) as usize
    }

    /// Returns true with probability `share`.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// Returns +1 or -1 with equal probability.
    pub(super) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Returns a number of random sign with a magnitude between `low` and `high`.
    pub(super) fn signed(&mut self, low: f64, high: f64) -> f64 {
        self.sign() * self.between(low, high)
    }

    /// Returns a random unit vector.
    pub(super) fn direction(&mut self) -> [f64; 2] {
        let angle = self.between(0.0, TAU);
        [libm::cos(angle), libm::sin(angle)]
    }

    /// Returns a standard normal deviate (Box-Muller).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(TAU * self.unit())
    }

    /// Shuffles `items` in place (Fisher-Yates).
    pub(super) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

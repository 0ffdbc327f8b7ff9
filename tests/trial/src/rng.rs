//! The room's own random numbers: one seed, one sequence, on every machine.

use std::f64::consts::TAU;

/// xoshiro256++ (Blackman and Vigna), its state filled from one word.
#[derive(Debug, Clone)]
pub(super) struct Rng([u64; 4]);

/// Scrambles a word so that neighbours share nothing.
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

    /// An independent sequence for each pair of labels, whatever has been drawn elsewhere.
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

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform from `low` to `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the logarithm from `low` to `high`, both above zero.
    pub(super) fn between_log(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.unit())
    }

    /// One of 0..`count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.word()) * count as u128) >> 64) as usize
    }

    /// True this share of the time.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// +1 or -1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// A size between `low` and `high` of either sign.
    pub(super) fn signed(&mut self, low: f64, high: f64) -> f64 {
        self.sign() * self.between(low, high)
    }

    /// A direction, as a unit vector.
    pub(super) fn direction(&mut self) -> [f64; 2] {
        let angle = self.between(0.0, TAU);
        [libm::cos(angle), libm::sin(angle)]
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(TAU * self.unit())
    }

    /// A shuffle in place (Fisher and Yates).
    pub(super) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

//! A deterministic random generator: the same seed gives the same numbers on every machine.

/// The SplitMix64 generator (Steele, Lea and Flood 2014): a 64-bit counter with a mixing function.
#[derive(Debug, Clone)]
pub struct SplitMix64(u64);

/// Increment of the counter: 2^64 over the golden ratio.
const INCREMENT: u64 = 0x9E37_79B9_7F4A_7C15;

impl SplitMix64 {
    /// Creates a generator with `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Creates the generator with seed 0 as it is after `position` words.
    pub fn at_position(position: u64) -> Self {
        Self(position.wrapping_mul(INCREMENT))
    }

    /// Returns the next word, uniform over all 64-bit values.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(INCREMENT);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Returns a number uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns an index uniform among 0..`count`; the bias of the product method is below 2^-40 for any real count.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next_u64()) * count as u128) >> 64) as usize
    }

    /// Returns 0..`count` in random order (Fisher-Yates shuffle).
    pub fn permutation(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.below(last + 1));
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_published_generator() {
        let mut random = SplitMix64::new(1_234_567);
        assert_eq!(random.next_u64(), 6_457_827_717_110_365_317);
        assert_eq!(random.next_u64(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn positions_continue_the_sequence_of_seed_0() {
        let mut random = SplitMix64::new(0);
        for position in 0..5 {
            let word = random.next_u64();
            assert_eq!(SplitMix64::at_position(position).next_u64(), word);
        }
    }

    #[test]
    fn permutations_hold_every_index_once() {
        let mut order = SplitMix64::new(7).permutation(100);
        assert_ne!(order, (0..100).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..100).collect::<Vec<_>>());
    }
}

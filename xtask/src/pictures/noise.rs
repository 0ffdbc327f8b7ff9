//! Gaussian noise, the same every time.

use std::f64::consts::TAU;

/// Normal deviates by the Box-Muller transform of SplitMix64 numbers.
pub(super) struct Gaussian {
    state: u64,
}

impl Gaussian {
    pub(super) fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next deviate, of unit variance.
    pub(super) fn sample(&mut self) -> f64 {
        let (a, b) = (self.uniform(), self.uniform());
        (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
    }

    /// A number between 0 and 1, neither included.
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviates_have_unit_variance() {
        let mut noise = Gaussian::new(1);
        let all: Vec<f64> = (0..20_000).map(|_| noise.sample()).collect();
        let mean = all.iter().sum::<f64>() / 20_000.0;
        let variance = all.iter().map(|v| v * v).sum::<f64>() / 20_000.0;
        assert!(
            mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04,
            "{mean} {variance}"
        );
    }
}

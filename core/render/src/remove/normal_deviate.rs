//! Normal deviates by index, the same on any machine and for any number of threads.

use seidel_optics::numeric::SplitMix64;
use std::f64::consts::TAU;

/// Returns a standard normal deviate for an index (Box and Muller 1958).
pub(super) fn normal_deviate(index: u64) -> f64 {
    let mut random = SplitMix64::at_position(2 * index);
    let scale = (1_u64 << 53) as f64;
    let mut open_unit = || ((random.next_u64() >> 11) as f64 + 0.5) / scale;
    let (a, b) = (open_unit(), open_unit());
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviates_are_normal_and_independent() {
        let all: Vec<f64> = (0..20_000).map(normal_deviate).collect();
        let mean = |of: &dyn Fn(usize) -> f64| (0..19_999).map(of).sum::<f64>() / 19_999.0;
        assert!(mean(&|k| all[k]).abs() < 0.03);
        assert!((mean(&|k| all[k].powi(2)) - 1.0).abs() < 0.04);
        assert!((mean(&|k| all[k].powi(4)) - 3.0).abs() < 0.3);
        assert!(mean(&|k| all[k] * all[k + 1]).abs() < 0.03);
    }
}

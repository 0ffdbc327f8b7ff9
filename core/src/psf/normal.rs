//! The normal distribution function, and the vector code that samples skew-normal densities.

use super::{SkewNormalDensity, Window};

/// The normal distribution function, within 1e-15 (absolute) everywhere and relative in the tails.
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Adds `weight` times `part`'s density at the pixel centres of `window` to `out`.
pub(super) fn sample_rows_f32(
    part: &SkewNormalDensity,
    weight: f64,
    window: &Window,
    out: &mut [f32],
) {
    for (row, line) in out.chunks_exact_mut(window.width).enumerate() {
        let y = window.first_y_px + row as f64;
        for (column, sample) in line.iter_mut().enumerate() {
            *sample += (weight * part.density(window.first_x_px + column as f64, y)) as f32;
        }
    }
}

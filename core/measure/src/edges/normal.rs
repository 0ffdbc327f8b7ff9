//! The normal distribution.

/// Returns the density of the standard normal distribution.
pub(super) fn density(z: f64) -> f64 {
    const ROOT_TAU: f64 = 2.506_628_274_631_000_5;
    (-z * z / 2.0).exp() / ROOT_TAU
}

/// Returns the cumulative standard normal distribution, within 7.5e-8 (Zelen and Severo 1964, 26.2.17).
pub(super) fn cumulative(z: f64) -> f64 {
    let k = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let series = [
        0.319_381_530,
        -0.356_563_782,
        1.781_477_937,
        -1.821_255_978,
        1.330_274_429,
    ];
    let tail = series.iter().rev().fold(0.0, |sum, c| (sum + c) * k) * density(z);
    if z > 0.0 { 1.0 - tail } else { tail }
}

//! Weights of pixels whose noise grows with their signal: photon noise.

/// Standard deviation of the Gaussian over which the expected signal is averaged, px. Weights taken from single pixels
/// would follow their noise and bias the fit towards the pixels that came out dark.
const SMOOTHING_PX: f64 = 1.0;
/// Error of the model relative to the peak of the light, beyond the noise. Without it the wings of bright lights, whose noise
/// is far below a thousandth of the peak, decide the fit of a lens that no model describes to that accuracy.
const MODEL_ERROR: f64 = 0.002;

/// Returns the weighted mean of the counted pixels around each pixel of a tile of `size` (columns, rows).
pub(super) fn smoothed(light: &[f64], counts: Option<&[bool]>, size: (usize, usize)) -> Vec<f64> {
    let reach = (3.0 * SMOOTHING_PX) as usize;
    let (width, height) = size;
    let tap = |a: usize, b: usize| {
        let distance = a.abs_diff(b) as f64 / SMOOTHING_PX;
        (-0.5 * distance * distance).exp()
    };
    (0..light.len())
        .map(|index| {
            let (column, row) = (index % width, index / width);
            let (mut sum, mut norm) = (0.0, 0.0);
            for y in row.saturating_sub(reach)..(row + reach + 1).min(height) {
                for x in column.saturating_sub(reach)..(column + reach + 1).min(width) {
                    let at = y * width + x;
                    if counts.is_none_or(|c| c[at]) {
                        let weight = tap(x, column) * tap(y, row);
                        sum += weight * light[at];
                        norm += weight;
                    }
                }
            }
            if norm > 0.0 { sum / norm } else { 0.0 }
        })
        .collect()
}

/// Returns the weight of every pixel relative to that of a dark one, for pixels of variance `sigma`² + `gain` x signal.
pub(super) fn relative(expected: &[f64], sigma: f64, gain: f64) -> Vec<f64> {
    let peak = expected.iter().copied().fold(0.0, f64::max);
    let weight = |signal: &f64| {
        let variance = sigma * sigma + gain * signal.max(0.0) + (MODEL_ERROR * peak).powi(2);
        sigma / variance.sqrt()
    };
    expected.iter().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_inverse_of_the_noise() {
        let weights = relative(&[0.0, 300.0, -5.0], 10.0, 1.0);
        assert!((weights[0] - 1.0).abs() < 0.01, "{}", weights[0]);
        assert!((weights[1] - 0.5).abs() < 0.01, "{}", weights[1]);
        assert_eq!(weights[2], weights[0]);
    }

    #[test]
    fn pixels_that_do_not_count_have_no_influence() {
        let mut light = vec![2.0; 25];
        light[12] = 1e6;
        let mut counts = vec![true; 25];
        counts[12] = false;
        let mean = smoothed(&light, Some(&counts), (5, 5));
        assert!(mean.iter().all(|v| (v - 2.0).abs() < 1e-12));
    }
}

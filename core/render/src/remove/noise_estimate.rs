//! Estimates of the noise of a plate from frequencies that its lens blocks.
//!
//! In the stopband of the lens the plate has noise alone. The power of white noise at a frequency is exponentially
//! distributed, so its variance is the median power / ln 2.

use super::canvas::Canvas;
use super::lens_operator::LensOperator;

/// Median of the absolute value of a standard normal deviate.
const MEDIAN_ABS_NORMAL: f64 = 0.674_489_75;
/// Frequencies of which the lens passes less than this share of the power are its stopband.
const STOPBAND_POWER: f32 = 1e-6;
/// Least number of stopband frequencies in a tile that is used.
const MIN_FREQUENCIES: usize = 64;
/// Largest number of samples from which the quantisation step is estimated.
const MAX_SAMPLES: usize = 8192;
/// Least number of distinct levels: planes with fewer are masks, which say nothing about quantisation.
const MIN_LEVELS: usize = 16;

/// Returns the standard deviation of white noise in `plane`, a plane of the plate on `canvas`.
///
/// It is estimated from the stopband of the lens `operator`, in the median tile. If the lens has no stopband, it is
/// estimated by [`haar_noise`]. It is at least the [`quantisation_noise`].
pub(super) fn estimate_noise(plane: &[f32], canvas: &Canvas, operator: &LensOperator) -> f64 {
    stopband_noise(plane, canvas, operator)
        .unwrap_or_else(|| haar_noise(plane, canvas.plate.0))
        .max(quantisation_noise(plane))
}

/// Returns the standard deviation of rounding to the levels that occur in `plane`: 1 / sqrt(12) of the median step
/// between them. It is next to nothing for samples of many bits.
fn quantisation_noise(plane: &[f32]) -> f64 {
    let step = plane.len().div_ceil(MAX_SAMPLES).max(1);
    let mut levels: Vec<f32> = plane.iter().step_by(step).copied().collect();
    levels.sort_unstable_by(f32::total_cmp);
    levels.dedup();
    if levels.len() < MIN_LEVELS {
        return 0.0;
    }
    let mut steps: Vec<f32> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / 12.0_f64.sqrt()
}

/// Returns the noise in the stopband of the lens, or nothing if no tile has enough of a stopband.
fn stopband_noise(plane: &[f32], canvas: &Canvas, operator: &LensOperator) -> Option<f64> {
    let mirrored = canvas.extend_by_mirroring(plane);
    let mut powers = operator.stopband_powers(&mirrored, STOPBAND_POWER, MIN_FREQUENCIES);
    if powers.is_empty() {
        return None;
    }
    let middle = powers.len() / 2;
    let (_, median, _) = powers.select_nth_unstable_by(middle, f64::total_cmp);
    Some((*median / std::f64::consts::LN_2).sqrt())
}

/// Returns the standard deviation of white noise in a plane `width` samples wide, from the median absolute diagonal Haar
/// detail of the finest scale (Donoho and Johnstone 1994). Fine detail of the image counts as noise.
pub(super) fn haar_noise(plane: &[f32], width: usize) -> f64 {
    let mut details = Vec::with_capacity(plane.len() / 4);
    for rows in plane.chunks_exact(2 * width.max(1)) {
        let (upper, lower) = rows.split_at(width);
        let blocks = upper.chunks_exact(2).zip(lower.chunks_exact(2));
        details.extend(blocks.map(|(up, low)| ((up[0] - up[1] - low[0] + low[1]) / 2.0).abs()));
    }
    if details.is_empty() {
        return 0.0;
    }
    let middle = details.len() / 2;
    let (_, median, _) = details.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / MEDIAN_ABS_NORMAL
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{WEIGHTS, lens, plate, scene};
    use super::*;

    #[test]
    fn noise_of_a_plate_is_estimated_within_6_percent() {
        let lens = lens(1.0);
        let scene = scene(&lens);
        let canvas = Canvas::new(&scene);
        let operator = LensOperator::new(&scene, &canvas, &WEIGHTS).expect("a valid lens");
        for noise in [0.001, 0.01, 0.03] {
            let estimate = estimate_noise(&plate(noise), &canvas, &operator);
            assert!((estimate / noise - 1.0).abs() < 0.06, "{noise}: {estimate}");
        }
    }

    #[test]
    fn quantisation_is_found_in_planes_of_few_levels_only() {
        let smooth: Vec<f32> = (0..20_000)
            .map(|k| 0.5 + 0.4 * (0.013 * k as f32).sin())
            .collect();
        let rounded = |levels: f32| -> Vec<f32> {
            smooth
                .iter()
                .map(|v| (v * levels).round() / levels)
                .collect()
        };
        let eight = quantisation_noise(&rounded(255.0));
        assert!(
            (eight * 255.0 * 12.0_f64.sqrt() - 1.0).abs() < 1e-3,
            "{eight}"
        );
        assert!(quantisation_noise(&rounded(65_535.0)) < 5e-5);
        assert!(quantisation_noise(&smooth) < 5e-5);
        // A mask has two levels.
        assert_eq!(quantisation_noise(&rounded(1.0)), 0.0);
    }
}

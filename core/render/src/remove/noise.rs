//! How noisy a plane is, told from what its lens cannot pass.

use super::canvas::Canvas;
use super::view::View;

/// Median of the size of a normal deviate of unit variance.
const MEDIAN_SIZE: f64 = 0.674_489_75;
/// Waves are noise alone where the lens passes less than this share of their power.
const PASSED: f32 = 1e-6;
/// Waves of a square that noise is told from at least.
const LEAST_WAVES: usize = 64;
/// Samples whose levels are looked at, at most, and levels at least for steps between them to be told.
const LOOKED_AT: usize = 8192;
const LEAST_LEVELS: usize = 16;

/// Standard deviation of white noise in a plate's `plane`: by the median power of waves that its lens, `view`, does not
/// pass, in the middle one of all squares; where it passes all, by its finest detail ([`by_detail`]). No less than what
/// rounding to the plane's levels leaves ([`of_rounding`]).
pub(super) fn deviation(plane: &[f32], canvas: &Canvas, view: &View) -> f64 {
    of_waves(plane, canvas, view).max(of_rounding(plane))
}

/// Standard deviation of what is lost where samples are rounded to the next of so few levels as they have: 1 / sqrt(12) of the
/// median step between levels. Nearly none of samples of many bits.
fn of_rounding(plane: &[f32]) -> f64 {
    let step = plane.len().div_ceil(LOOKED_AT).max(1);
    let mut levels: Vec<f32> = plane.iter().step_by(step).copied().collect();
    levels.sort_unstable_by(f32::total_cmp);
    levels.dedup();
    if levels.len() < LEAST_LEVELS {
        return 0.0;
    }
    let mut steps: Vec<f32> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / 12.0_f64.sqrt()
}

fn of_waves(plane: &[f32], canvas: &Canvas, view: &View) -> f64 {
    let mut powers = view.quiet_powers(&canvas.mirrored(plane), PASSED, LEAST_WAVES);
    if powers.is_empty() {
        return by_detail(plane, canvas.plate.0);
    }
    let middle = powers.len() / 2;
    let (_, median, _) = powers.select_nth_unstable_by(middle, f64::total_cmp);
    // Power of noise in a wave is spread exponentially.
    (*median / std::f64::consts::LN_2).sqrt()
}

/// Standard deviation of white noise in a plane `width` samples wide: by the median size of the finest diagonal
/// Haar details (Donoho and Johnstone 1994). What the picture itself has there counts as noise.
pub(super) fn by_detail(plane: &[f32], width: usize) -> f64 {
    let mut details = Vec::with_capacity(plane.len() / 4);
    for rows in plane.chunks_exact(2 * width.max(1)) {
        let (upper, lower) = rows.split_at(width);
        let squares = upper.chunks_exact(2).zip(lower.chunks_exact(2));
        details.extend(squares.map(|(up, low)| ((up[0] - up[1] - low[0] + low[1]) / 2.0).abs()));
    }
    if details.is_empty() {
        return 0.0;
    }
    let middle = details.len() / 2;
    let (_, median, _) = details.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / MEDIAN_SIZE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_told_of_few_levels_only() {
        let smooth: Vec<f32> = (0..20_000)
            .map(|k| 0.5 + 0.4 * (0.013 * k as f32).sin())
            .collect();
        let rounded = |levels: f32| -> Vec<f32> {
            smooth
                .iter()
                .map(|v| (v * levels).round() / levels)
                .collect()
        };
        let eight = of_rounding(&rounded(255.0));
        assert!(
            (eight * 255.0 * 12.0_f64.sqrt() - 1.0).abs() < 1e-3,
            "{eight}"
        );
        assert!(of_rounding(&rounded(65_535.0)) < 5e-5);
        assert!(of_rounding(&smooth) < 5e-5);
        // A mask says nothing of rounding.
        assert_eq!(of_rounding(&rounded(1.0)), 0.0);
    }
}

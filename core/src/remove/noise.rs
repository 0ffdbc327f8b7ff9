//! How noisy a plane is, told from what its lens cannot pass.

use super::canvas::Canvas;
use super::view::View;

/// Median of the size of a normal deviate of unit variance.
const MEDIAN_SIZE: f64 = 0.674_489_75;
/// Waves are noise alone where the lens passes less than this share of their power.
const PASSED: f32 = 1e-6;
/// Waves of a square that noise is told from at least.
const LEAST_WAVES: usize = 64;

/// Standard deviation of white noise in a plate's `plane`: by the median power of waves that its lens, `view`, does not
/// pass, in the middle one of all squares; where it passes all, by its finest detail ([`by_detail`]).
pub(super) fn deviation(plane: &[f32], canvas: &Canvas, view: &View) -> f64 {
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
fn by_detail(plane: &[f32], width: usize) -> f64 {
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

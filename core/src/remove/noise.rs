//! How noisy a plane is, told from its finest diagonal detail, where blurred pictures have next to none.

/// Median of the size of a normal deviate of unit variance.
const MEDIAN_SIZE: f64 = 0.674_489_75;

/// Standard deviation of white noise in a plane `width` samples wide: by the median of the finest diagonal
/// Haar details (Donoho and Johnstone 1994), those of samples that are `told` alone.
pub(super) fn deviation(plane: &[f32], width: usize, told: impl Fn(usize) -> bool) -> f64 {
    let height = plane.len() / width.max(1);
    let mut details = Vec::with_capacity(plane.len() / 4);
    for y in (0..height.saturating_sub(1)).step_by(2) {
        for x in (0..width.saturating_sub(1)).step_by(2) {
            let at = y * width + x;
            let places = [at, at + 1, at + width, at + width + 1];
            if places.into_iter().all(&told) {
                let [a, b, c, d] = places.map(|k| plane[k]);
                details.push(((a - b - c + d) / 2.0).abs());
            }
        }
    }
    if details.is_empty() {
        return 0.0;
    }
    let middle = details.len() / 2;
    let (_, median, _) = details.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / MEDIAN_SIZE
}

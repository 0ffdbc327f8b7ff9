//! How noisy a plane is, told from its finest diagonal detail, where blurred pictures have next to none.

/// Median of the size of a normal deviate of unit variance.
const MEDIAN_SIZE: f64 = 0.674_489_75;

/// Standard deviation of white noise in a plane `width` samples wide: by the median size of the finest diagonal
/// Haar details (Donoho and Johnstone 1994). What the picture itself has there counts as noise.
pub(super) fn deviation(plane: &[f32], width: usize) -> f64 {
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

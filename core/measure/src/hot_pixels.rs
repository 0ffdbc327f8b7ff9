//! Defective pixels: brighter than any optics could make them next to their neighbours.

use rayon::prelude::*;

/// Excess over the noise from which on a pixel is examined, standard deviations.
const MIN_SIGMAS: f32 = 6.0;
/// Ratio to the third largest of the eight neighbours from which on a pixel is hot. A PSF as narrow as a Gaussian with a
/// standard deviation of 0.6 px, pixel area included, stays below 4.1 wherever it lies on the grid.
const MIN_RATIO: f32 = 4.5;
/// Rank of the neighbour compared with, from the brightest: two hot neighbours do not hide a third.
const RANK: usize = 2;

/// Finds the hot pixels of a plane of `width` columns. `signal` is light above background with the channels equalised,
/// `noise` its standard deviation.
pub fn find(signal: &[f32], noise: &[f32], width: usize) -> Vec<bool> {
    let height = signal.len() / width.max(1);
    let is_hot = |index: usize| {
        let value = signal[index] - MIN_SIGMAS * noise[index];
        if value <= 0.0 {
            return false;
        }
        let (near, count) = neighbours(signal, index, width, height);
        let mut near = near;
        let near = &mut near[..count];
        near.sort_by(|a, b| b.total_cmp(a));
        let compared = near.get(RANK).copied().unwrap_or(0.0);
        value > MIN_RATIO * compared.max(0.0)
    };
    (0..signal.len()).into_par_iter().map(is_hot).collect()
}

/// Returns `signal` with its hot pixels replaced by the median of their neighbours. For detection only: measurements leave
/// hot pixels out.
pub fn repaired(signal: &[f32], hot: &[bool], width: usize) -> Vec<f32> {
    let height = signal.len() / width.max(1);
    let value = |index: usize| {
        if !hot[index] {
            return signal[index];
        }
        let (mut near, count) = neighbours(signal, index, width, height);
        let near = &mut near[..count];
        near.sort_by(f32::total_cmp);
        near.get(count / 2).copied().unwrap_or(0.0)
    };
    (0..signal.len()).into_par_iter().map(value).collect()
}

/// Returns the values of the neighbours of pixel `index`, and their number.
fn neighbours(signal: &[f32], index: usize, width: usize, height: usize) -> ([f32; 8], usize) {
    let (column, row) = (index % width, index / width);
    let mut found = [0.0; 8];
    let mut count = 0;
    for y in row.saturating_sub(1)..(row + 2).min(height) {
        for x in column.saturating_sub(1)..(column + 2).min(width) {
            if (x, y) != (column, row) {
                found[count] = signal[y * width + x];
                count += 1;
            }
        }
    }
    (found, count)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 24;

    fn light(sigma_px: f32, x: f32, y: f32) -> Vec<f32> {
        let values = (0..WIDTH * WIDTH).map(|k| {
            let (dx, dy) = ((k % WIDTH) as f32 + 0.5 - x, (k / WIDTH) as f32 + 0.5 - y);
            1000.0 * (-(dx * dx + dy * dy) / (2.0 * sigma_px * sigma_px)).exp()
        });
        values.collect()
    }

    #[test]
    fn lights_are_kept_and_hot_pixels_beside_them_found() {
        let noise = vec![1.0; WIDTH * WIDTH];
        for (x, y) in [(12.0, 12.0), (12.5, 12.5), (12.2, 11.7)] {
            let mut plane = light(0.6, x, y);
            let hot = find(&plane, &noise, WIDTH);
            assert!(!hot.contains(&true), "{x} {y}");
            plane[5 * WIDTH + 5] = 300.0;
            plane[5 * WIDTH + 6] = 280.0;
            let hot = find(&plane, &noise, WIDTH);
            assert_eq!(hot.iter().filter(|h| **h).count(), 2);
            let repaired = repaired(&plane, &hot, WIDTH);
            assert!(repaired[5 * WIDTH + 5] < 1.0);
            assert_eq!(repaired[12 * WIDTH + 12], plane[12 * WIDTH + 12]);
        }
    }
}

//! Defective pixels: brighter than any optics could make them next to their neighbours.

use rayon::prelude::*;

/// Excess over the noise from which on a pixel is examined, standard deviations.
const MIN_SIGMAS: f32 = 6.0;
/// Ratio to the third largest of the eight neighbours from which on a pixel is hot. A PSF as narrow as a Gaussian with a
/// standard deviation of 0.6 px, pixel area included, stays below 4.1 wherever it lies on the grid.
const MIN_RATIO: f32 = 4.5;
/// Distances of the neighbours, px: those next to a pixel, and in a mosaic those of its own colour. Where only one colour is sharp, its
/// neighbours of other colours are far darker.
const STEPS: [usize; 2] = [1, 2];
/// Rank of the neighbour compared with, from the brightest: two hot neighbours do not hide a third.
const RANK: usize = 2;

/// Finds the hot pixels of a plane of `width` columns. `signal` is light above background with the channels equalised,
/// `noise` its standard deviation.
pub fn find(signal: &[f32], noise: &[f32], width: usize) -> Vec<bool> {
    let is_hot = |index: usize| {
        let value = signal[index] - MIN_SIGMAS * noise[index];
        if value <= 0.0 {
            return false;
        }
        STEPS.into_iter().all(|step| {
            let (mut near, count) = neighbours(signal, index, step, width);
            let near = &mut near[..count];
            near.sort_by(|a, b| b.total_cmp(a));
            let compared = near.get(RANK).copied().unwrap_or(0.0);
            value > MIN_RATIO * compared.max(0.0)
        })
    };
    (0..signal.len()).into_par_iter().map(is_hot).collect()
}

/// Returns `signal` with its hot pixels replaced by the median of their neighbours. For detection only: measurements leave
/// hot pixels out.
pub fn repaired(signal: &[f32], hot: &[bool], width: usize) -> Vec<f32> {
    let value = |index: usize| {
        if !hot[index] {
            return signal[index];
        }
        let (mut near, count) = neighbours(signal, index, 1, width);
        let near = &mut near[..count];
        near.sort_by(f32::total_cmp);
        near.get(count / 2).copied().unwrap_or(0.0)
    };
    (0..signal.len()).into_par_iter().map(value).collect()
}

/// Returns the values of the eight neighbours of pixel `index` that lie `step` columns and rows away, and how many of them there are.
fn neighbours(signal: &[f32], index: usize, step: usize, width: usize) -> ([f32; 8], usize) {
    let height = signal.len() / width.max(1);
    let (column, row) = (index % width, index / width);
    let along = |at: usize, length: usize| {
        [at.checked_sub(step), Some(at), Some(at + step)]
            .into_iter()
            .flatten()
            .filter(move |at| *at < length)
    };
    let mut found = [0.0; 8];
    let mut count = 0;
    for y in along(row, height) {
        for x in along(column, width) {
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

    /// Pixels of the one colour in focus stand out from those beside them.
    #[test]
    fn a_light_sharp_in_one_colour_alone_is_kept() {
        let noise = vec![1.0; WIDTH * WIDTH];
        let sharp = light(1.2, 12.0, 12.0);
        let wide = light(4.0, 12.0, 12.0);
        let colour = |k: usize| (k % WIDTH % 2, k / WIDTH % 2);
        let mixed = sharp.iter().zip(&wide).enumerate();
        let plane: Vec<f32> = mixed
            .map(|(k, (sharp, wide))| {
                if colour(k) == (0, 0) {
                    *sharp
                } else {
                    0.05 * wide
                }
            })
            .collect();
        assert!(!find(&plane, &noise, WIDTH).contains(&true));
    }
}

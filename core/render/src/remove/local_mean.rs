//! Local means of a plane over about 30 px.

use rayon::prelude::*;

/// Number of box blurs along each axis.
const BOX_PASSES: usize = 3;
/// Half width of a box, px.
const BOX_HALF_WIDTH: usize = 8;

/// Replaces each sample by the mean around it: three box blurs along rows and columns, normalised at the edges, which are
/// nearly a Gaussian blur.
pub(super) fn average_locally(plane: &mut [f32], width: usize) {
    for _ in 0..BOX_PASSES {
        plane.par_chunks_mut(width).for_each(|row| {
            let mut line = row.to_vec();
            box_blur(&mut line);
            row.copy_from_slice(&line);
        });
        let height = plane.len() / width;
        let columns: Vec<Vec<f32>> = (0..width)
            .into_par_iter()
            .map(|x| {
                let mut line: Vec<f32> = (0..height).map(|y| plane[y * width + x]).collect();
                box_blur(&mut line);
                line
            })
            .collect();
        plane
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (out, column) in row.iter_mut().zip(&columns) {
                    *out = column[y];
                }
            });
    }
}

fn box_blur(line: &mut [f32]) {
    let mut sums = vec![0.0_f64];
    sums.extend(line.iter().scan(0.0, |sum, v| {
        *sum += f64::from(*v);
        Some(*sum)
    }));
    let count = line.len();
    for (k, out) in line.iter_mut().enumerate() {
        let (from, to) = (
            k.saturating_sub(BOX_HALF_WIDTH),
            (k + BOX_HALF_WIDTH + 1).min(count),
        );
        *out = ((sums[to] - sums[from]) / (to - from) as f64) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_blurs_keep_what_is_even_and_the_sum_inside() {
        let mut uniform = vec![3.0; 70 * 50];
        average_locally(&mut uniform, 70);
        assert!(uniform.iter().all(|v| (v - 3.0).abs() < 1e-5));
        let mut one = vec![0.0; 120 * 120];
        one[60 * 120 + 60] = 1.0;
        average_locally(&mut one, 120);
        assert!((one.iter().sum::<f32>() - 1.0).abs() < 1e-4);
        assert!(one[60 * 120 + 60] < 0.01);
    }
}

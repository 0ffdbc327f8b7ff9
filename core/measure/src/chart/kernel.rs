//! Kernels of blocks: PSFs on a square of whole pixels.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::picture::SOFT_VARIANCE;

/// Returns the centroid of a kernel relative to its central sample.
pub(super) fn centroid(kernel: &[f64], side: usize) -> [f64; 2] {
    let half = (side / 2) as f64;
    let mut sum = [0.0; 2];
    for (k, value) in kernel.iter().enumerate() {
        sum[0] += value * ((k % side) as f64 - half);
        sum[1] += value * ((k / side) as f64 - half);
    }
    sum
}

/// Taps of a filter on either side of its middle, and more for each px of the blur that it adds.
const TAPS: usize = 4;
const TAPS_PER_PX: f64 = 4.0;
/// Frequencies at which a filter is compared with its response.
const FREQUENCIES: usize = 256;
/// Standard deviation of the weight of these frequencies, radians per px: that of the light of a narrow PSF.
const WEIGHT_WIDTH: f64 = 1.7;

/// The step from the kernel of a block to a PSF integrated over pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Integration {
    /// Whether the chart was averaged over [`Aperture::Soft`](super::picture::Aperture::Soft).
    pub(super) soft: bool,
    /// Standard deviation of a Gaussian blur to add, px.
    pub(super) added_sigma_px: f64,
}

impl Integration {
    /// Returns the response at `frequency` (radians per px) along an axis: sinc(w / 2) of a pixel, cos(w / 4) of the soft
    /// aperture, which kernels lack, and that of the Gaussian.
    fn response(self, frequency: f64) -> f64 {
        let half = (frequency / 2.0).max(1e-9);
        let soft = if self.soft {
            (frequency / 4.0).cos()
        } else {
            1.0
        };
        let blur = (-0.5 * (self.added_sigma_px * frequency).powi(2)).exp();
        half.sin() / half * soft * blur
    }

    fn variance(self) -> f64 {
        let soft = if self.soft { SOFT_VARIANCE } else { 0.0 };
        1.0 / 12.0 + soft + self.added_sigma_px.powi(2)
    }

    /// Returns the number of taps on either side of the middle of a filter.
    fn reach(self) -> usize {
        TAPS + (TAPS_PER_PX * self.added_sigma_px).ceil() as usize
    }

    /// Returns the taps from the middle outwards of the filter that is closest to the response, among those of `count` outer
    /// taps with its sum and variance.
    fn taps(self, count: usize) -> Vec<f64> {
        // The middle and two outer taps of each distance; two multipliers for the sum and the variance.
        let size = count + 1;
        let mut matrix = DMatrix::zeros(size + 2, size + 2);
        let mut right = DVector::zeros(size + 2);
        let multiple = |k: usize| if k == 0 { 1.0 } else { 2.0 };
        for step in 0..FREQUENCIES {
            let frequency = PI * (step as f64 + 0.5) / FREQUENCIES as f64;
            let weight = (-0.5 * (frequency / WEIGHT_WIDTH).powi(2)).exp();
            let wave = |k: usize| multiple(k) * (k as f64 * frequency).cos();
            for row in 0..size {
                right[row] += weight * wave(row) * self.response(frequency);
                for column in 0..size {
                    matrix[(row, column)] += weight * wave(row) * wave(column);
                }
            }
        }
        for k in 0..size {
            let of_variance = multiple(k) * (k * k) as f64;
            for (row, value) in [(size, multiple(k)), (size + 1, of_variance)] {
                matrix[(row, k)] = value;
                matrix[(k, row)] = value;
            }
        }
        right[size] = 1.0;
        right[size + 1] = self.variance();
        let solved = matrix.lu().solve(&right);
        let solved = solved.expect("cosines of different periods are independent");
        solved.rows(0, size).iter().copied().collect()
    }

    /// Returns the filters, made once for many kernels.
    pub(super) fn filters(self) -> Filters {
        Filters {
            by_border: (1..=self.reach()).map(|count| self.taps(count)).collect(),
        }
    }
}

/// Filters of an [`Integration`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filters {
    /// Taps from the middle outwards, by the distance from the border of a tile less one.
    by_border: Vec<Vec<f64>>,
}

impl Filters {
    /// Returns the PSF integrated over pixels of a block's `kernel`. Near the border of its square filters are narrower, and
    /// what leaves the border itself is lost.
    pub(super) fn of(&self, kernel: &[f64], side: usize) -> Vec<f64> {
        let pass = |values: &[f64], stride: usize| -> Vec<f64> {
            let mut spread = vec![0.0; side * side];
            for (k, value) in values.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                let along = k / stride % side;
                let to_border = along.min(side - 1 - along);
                let taps = &self.by_border[to_border.clamp(1, self.by_border.len()) - 1];
                let reach = taps.len() - 1;
                for at in along.saturating_sub(reach)..(along + reach + 1).min(side) {
                    spread[k + at * stride - along * stride] += taps[at.abs_diff(along)] * value;
                }
            }
            spread
        };
        pass(&pass(kernel, 1), side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the samples of a Gaussian of variance `variance` on a square.
    fn gaussian(side: usize, variance: f64) -> Vec<f64> {
        let half = (side / 2) as f64;
        let along = |k: usize| (-0.5 * (k as f64 - half).powi(2) / variance).exp();
        let all: Vec<f64> = (0..side * side)
            .map(|k| along(k % side) * along(k / side))
            .collect();
        let sum: f64 = all.iter().sum();
        all.iter().map(|v| v / sum).collect()
    }

    #[test]
    fn a_gaussian_becomes_the_gaussian_integrated_over_pixels() {
        let (side, variance) = (21, 0.9_f64);
        let found = Integration {
            soft: false,
            added_sigma_px: 0.5,
        }
        .filters()
        .of(&gaussian(side, variance), side);
        // The integral over a pixel by the midpoint rule on a fine grid.
        let wide = variance + 0.25;
        let along = |k: usize| -> f64 {
            let fine = (0..64).map(|j| k as f64 - 10.5 + (f64::from(j) + 0.5) / 64.0);
            let sum: f64 = fine.map(|x| (-0.5 * x * x / wide).exp()).sum();
            sum / 64.0 / (std::f64::consts::TAU * wide).sqrt()
        };
        for (k, value) in found.iter().enumerate() {
            let want = along(k % side) * along(k / side);
            assert!((value - want).abs() < 1e-3, "sample {k}: {value}, {want}");
        }
    }

    #[test]
    fn sum_and_variance_are_exact_and_the_response_is_close() {
        for (soft, added_sigma_px) in [(false, 0.0), (true, 0.0), (true, 1.2)] {
            let integration = Integration {
                soft,
                added_sigma_px,
            };
            let taps = integration.taps(integration.reach());
            let outer = taps.iter().enumerate().skip(1);
            let sum = taps[0] + outer.clone().map(|(_, t)| 2.0 * t).sum::<f64>();
            let variance: f64 = outer.map(|(k, t)| 2.0 * t * (k * k) as f64).sum();
            assert!((sum - 1.0).abs() < 1e-9);
            assert!((variance - integration.variance()).abs() < 1e-9);
            for frequency in [0.4, 0.8, 1.6, 2.2] {
                let cosines = taps.iter().enumerate().skip(1);
                let cosines = cosines.map(|(k, t)| 2.0 * t * (k as f64 * frequency).cos());
                let found = taps[0] + cosines.sum::<f64>();
                let error = found - integration.response(frequency);
                assert!(error.abs() < 0.005, "{integration:?} {frequency}: {error}");
            }
        }
    }
}

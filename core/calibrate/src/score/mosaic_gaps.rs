//! Pixels of other colours in the tiles of a mosaic, filled in so that whole kernels can be compared.
//!
//! A gap takes the weighted mean of the pixels of its channel around it. Measured light is smoothed by that, so predictions
//! are compared by their residual instead: it is small and smooth, and where it is known it is kept as it is.

/// Standard deviation of the Gaussian weights, px: about half the distance between the pixels of a rare colour.
const SIGMA_PX: f64 = 1.0;
/// Largest distance along an axis to a pixel that takes part, px. A pixel of its channel lies within two of every gap.
const REACH_PX: usize = 2;

/// The gaps of one tile, on the square on which it is compared.
pub(crate) struct MosaicGaps {
    /// Pixels that count.
    counted: Vec<usize>,
    /// Pixels without a sample of their own.
    gaps: Vec<Gap>,
}

struct Gap {
    pixel: usize,
    /// Counted pixels and their weights, which sum to one.
    sources: Vec<(usize, f64)>,
}

impl MosaicGaps {
    /// Finds the gaps between the pixels that are `counted`, on a square of `side` px.
    pub(super) fn new(counted: &[bool], side: usize) -> Self {
        let weight = |a: usize, b: usize| {
            let distance = a.abs_diff(b) as f64 / SIGMA_PX;
            (-0.5 * distance * distance).exp()
        };
        let sources = |pixel: usize| {
            let (column, row) = (pixel % side, pixel / side);
            let mut found = Vec::new();
            for y in row.saturating_sub(REACH_PX)..(row + REACH_PX + 1).min(side) {
                for x in column.saturating_sub(REACH_PX)..(column + REACH_PX + 1).min(side) {
                    if counted[y * side + x] {
                        found.push((y * side + x, weight(x, column) * weight(y, row)));
                    }
                }
            }
            let sum: f64 = found.iter().map(|(_, weight)| weight).sum();
            found.iter_mut().for_each(|(_, weight)| *weight /= sum);
            found
        };
        let gaps = (0..counted.len())
            .filter(|k| !counted[*k])
            .map(|pixel| Gap {
                pixel,
                sources: sources(pixel),
            })
            .filter(|gap| !gap.sources.is_empty());
        Self {
            gaps: gaps.collect(),
            counted: (0..counted.len()).filter(|k| counted[*k]).collect(),
        }
    }

    /// Fills the gaps of `samples`.
    pub(super) fn fill(&self, samples: &mut [f64]) {
        for gap in &self.gaps {
            let mean = gap.sources.iter().map(|(k, weight)| weight * samples[*k]);
            samples[gap.pixel] = mean.sum();
        }
    }

    /// Returns the sum of `variances` over all pixels, those of the gaps as they follow from their sources.
    pub(super) fn total_variance(&self, variances: &[f64]) -> f64 {
        let own: f64 = self.counted.iter().map(|k| variances[*k]).sum();
        let filled = self.gaps.iter().flat_map(|gap| &gap.sources);
        own + filled
            .map(|(k, weight)| weight * weight * variances[*k])
            .sum::<f64>()
    }

    /// Returns `kernel` with the difference to `measured` added: at counted pixels as it is, in gaps filled in. The kernel
    /// is scaled to the light of the counted pixels.
    pub(super) fn completed(&self, measured: &[f64], kernel: &[f64]) -> Vec<f64> {
        let product: f64 = self.counted.iter().map(|&k| measured[k] * kernel[k]).sum();
        let power: f64 = self.counted.iter().map(|&k| kernel[k] * kernel[k]).sum();
        let flux = if product > 0.0 { product / power } else { 1.0 };
        let mut residual = vec![0.0; kernel.len()];
        for &k in &self.counted {
            residual[k] = measured[k] / flux - kernel[k];
        }
        self.fill(&mut residual);
        residual.iter().zip(kernel).map(|(r, k)| r + k).collect()
    }

    /// Returns the counted pixels.
    pub(super) fn counted(&self) -> &[usize] {
        &self.counted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 12;

    /// Every second column and row.
    fn quarter() -> Vec<bool> {
        (0..SIDE * SIDE)
            .map(|k| (k % SIDE).is_multiple_of(2) && !(k / SIDE).is_multiple_of(2))
            .collect()
    }

    fn bell(width: f64) -> Vec<f64> {
        let values = (0..SIDE * SIDE).map(|k| {
            let at = |v: usize| (v as f64 - 5.7) / width;
            (-at(k % SIDE).powi(2) - at(k / SIDE).powi(2)).exp()
        });
        values.collect()
    }

    #[test]
    fn a_true_kernel_leaves_no_difference_whatever_its_flux() {
        let gaps = MosaicGaps::new(&quarter(), SIDE);
        let kernel = bell(2.0);
        let measured: Vec<f64> = kernel.iter().map(|v| 7.0 * v).collect();
        let completed = gaps.completed(&measured, &kernel);
        for (a, b) in completed.iter().zip(&kernel) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn a_wrong_kernel_differs_in_the_gaps_too() {
        let gaps = MosaicGaps::new(&quarter(), SIDE);
        let (truth, kernel) = (bell(3.0), bell(2.5));
        let error =
            |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum() };
        let completed = gaps.completed(&truth, &kernel);
        let found = error(&completed, &kernel);
        let on_counted: f64 = (gaps.counted().iter())
            .map(|&k| (completed[k] - kernel[k]).powi(2))
            .sum();
        assert!(found > 2.5 * on_counted, "{found} {on_counted}");
    }

    #[test]
    fn the_variance_of_a_mean_is_smaller() {
        let gaps = MosaicGaps::new(&quarter(), SIDE);
        let total = gaps.total_variance(&[1.0; SIDE * SIDE]);
        let count = (SIDE * SIDE) as f64;
        assert!(total > count / 4.0 && total < 0.8 * count, "{total}");
    }
}

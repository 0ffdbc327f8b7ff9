//! The change of the PSF over a block, from the kernels of the blocks around it.

use nalgebra::{DMatrix, DVector};

use super::block_estimate::BlockEstimate;
use seidel_optics::numeric::median;

/// Number of blocks nearest to a block whose kernels determine the change over it.
const NEIGHBOURS: usize = 25;
/// Least number of such blocks.
const MIN_NEIGHBOURS: usize = 12;
/// Ratio of the distance at which a block has no weight to that of the farthest neighbour.
const REACH: f64 = 1.1;
/// Terms of a change: x, y, x², x y, y².
const TERMS: usize = 5;

/// Change of a kernel with the distance from the centre of its block.
#[derive(Debug, Clone)]
pub(super) struct Variation {
    /// One row a sample of the kernel, one column a term, per px and per px².
    terms: DMatrix<f64>,
}

fn terms([x, y]: [f64; 2]) -> [f64; TERMS] {
    [x, y, x * x, x * y, y * y]
}

impl Variation {
    /// Fits polynomials of second degree about `centre` to the samples of the kernels of `blocks`, with the weights of a local
    /// regression (tricube, Cleveland 1979). `None` where too few blocks lie around.
    pub(super) fn around(centre: [f64; 2], blocks: &[([f64; 2], &BlockEstimate)]) -> Option<Self> {
        let off = |at: &[f64; 2]| [at[0] - centre[0], at[1] - centre[1]];
        let distance = |at: &[f64; 2]| {
            let [x, y] = off(at);
            x.hypot(y)
        };
        let mut near: Vec<&([f64; 2], &BlockEstimate)> = blocks.iter().collect();
        near.sort_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
        near.truncate(NEIGHBOURS);
        if near.len() < MIN_NEIGHBOURS {
            return None;
        }
        let reach = REACH * distance(&near.last()?.0);
        // Blocks of little texture are noisy. Below the median, noise hardly counts.
        let mut noises: Vec<f64> = near.iter().map(|(_, e)| e.sigma).collect();
        let typical = median(&mut noises).max(f64::MIN_POSITIVE);
        let noise = |estimate: &BlockEstimate| (estimate.sigma / typical).max(1.0);
        let size = 1 + TERMS;
        let mut normal = DMatrix::zeros(size, size);
        let mut weighted = DMatrix::zeros(size, near.len());
        for (column, (at, estimate)) in near.iter().enumerate() {
            let weight = (1.0 - (distance(at) / reach).powi(3)).powi(3) / noise(estimate).powi(2);
            let row: Vec<f64> = std::iter::once(1.0)
                .chain(terms(off(at).map(|v| v / reach)))
                .collect();
            let row = DVector::from_vec(row);
            normal += weight * &row * row.transpose();
            weighted.set_column(column, &(weight * row));
        }
        let coefficients = normal.cholesky()?.solve(&weighted);
        let samples = near[0].1.kernel.len();
        let kernels = DMatrix::from_fn(samples, near.len(), |k, column| near[column].1.kernel[k]);
        let mut found = kernels * coefficients.rows(1, TERMS).transpose();
        for (term, scale) in terms([1.0 / reach; 2]).into_iter().enumerate() {
            found.column_mut(term).scale_mut(scale);
        }
        Some(Self { terms: found })
    }

    /// Returns the light at a pixel `off` the centre of the block that comes from the change of a kernel of unit sum; `chart`
    /// holds the chart at every offset of the kernel.
    pub(super) fn light(&self, off: [f64; 2], chart: &[f64]) -> f64 {
        let terms = terms(off);
        let columns = self.terms.column_iter().zip(terms);
        columns
            .map(|(change, term)| {
                let light = change.iter().zip(chart).map(|(a, b)| a * b).sum::<f64>();
                term * light
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_change_is_found() {
        let kernel =
            |[x, y]: [f64; 2]| vec![1.0 + 0.01 * x - 2e-5 * x * y, 0.02 * y + 1e-4 * y * y];
        let estimate = |at: [f64; 2]| BlockEstimate {
            kernel: kernel(at),
            chi_square: 1.0,
            misfit: 0.0,
            curvature: 0.0,
            unbounded: Vec::new(),
            sigma: 0.0,
            white: 1.0,
            detail: 1.0,
        };
        let places = (0..30).map(|k| [f64::from(k % 6) * 70.0, f64::from(k / 6) * 60.0]);
        let estimates: Vec<([f64; 2], BlockEstimate)> =
            places.map(|at| (at, estimate(at))).collect();
        let blocks: Vec<([f64; 2], &BlockEstimate)> =
            estimates.iter().map(|(at, e)| (*at, e)).collect();
        let centre = [70.0, 60.0];
        let variation = Variation::around(centre, &blocks).expect("enough blocks");
        let [here, there] = [kernel(centre), kernel([90.0, 45.0])];
        for (k, chart) in [[1.0, 0.0], [0.0, 1.0]].iter().enumerate() {
            let found = variation.light([20.0, -15.0], chart);
            assert!((found - (there[k] - here[k])).abs() < 1e-9, "{k}: {found}");
        }
        assert!(Variation::around(centre, &blocks[..5]).is_none());
    }
}

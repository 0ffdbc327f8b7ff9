//! Separable Gaussian blur of light on a grid of cells, combined with summation of the cells into pixels.
//!
//! The kernel is the discrete Gaussian e^-t I_n(t) at n cells, with t the variance in cells². Its variance is exact
//! at any width, and at zero it is the identity. (A sampled Gaussian, or one integrated over cells, is too wide where
//! it is narrower than a cell.)

use std::ops::Range;

use super::mesh::LANES;

/// Half width of the kernel, standard deviations: 1e-8 of the light lies outside.
const REACH: f64 = 5.7;

/// The weights of cells in a pixel, and their derivatives by the variance.
pub(super) struct GaussianBlur {
    /// Cells along the side of a pixel.
    factor: usize,
    /// Cells beyond a pixel, on either side, from which it gets light.
    pub(super) margin: usize,
    down: Line,
    /// Weights along x, if they differ from those along y.
    across: Option<Line>,
}

/// Weights along one axis.
struct Line {
    weights: Vec<f64>,
    /// Derivatives of the weights by the variance, per px².
    derivatives: Vec<f64>,
}

impl GaussianBlur {
    /// Creates a blur with these variances (x, y), px², for `factor` cells along the side of a pixel.
    pub(super) fn new([along_x, along_y]: [f64; 2], factor: usize) -> Self {
        let cells = (factor * factor) as f64;
        let t = along_x.max(along_y).max(0.0) * cells;
        let margin = (REACH * t.sqrt()).ceil() as usize + 2;
        Self {
            factor,
            margin,
            down: Line::new(along_y, factor, margin),
            across: (along_x != along_y).then(|| Line::new(along_x, factor, margin)),
        }
    }

    /// Blurs `cells` into the pixels of `out`, an image of `size` (width, height) with `depth` values a pixel.
    ///
    /// `cells` extends [`GaussianBlur::margin`] cells beyond the image on every side.
    pub(super) fn apply(&self, cells: &[f64], depth: usize, size: (usize, usize), out: &mut [f64]) {
        out.fill(0.0);
        let (x, y) = (self.across.as_ref().unwrap_or(&self.down), &self.down);
        self.add_separable(cells, depth, size, [&x.weights, &y.weights], out);
    }

    /// Computes the derivative of the blurred light by the variance, per px², into `out`; otherwise like
    /// [`GaussianBlur::apply`] with one value a pixel.
    pub(super) fn apply_variance_derivative(
        &self,
        cells: &[f64],
        size: (usize, usize),
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let (x, y) = (self.across.as_ref().unwrap_or(&self.down), &self.down);
        self.add_separable(cells, 1, size, [&x.derivatives, &y.weights], out);
        self.add_separable(cells, 1, size, [&x.weights, &y.derivatives], out);
    }

    /// Adds `cells`, filtered with `weights` along x and y, to `out`.
    fn add_separable(
        &self,
        cells: &[f64],
        depth: usize,
        size: (usize, usize),
        [across, down]: [&[f64]; 2],
        out: &mut [f64],
    ) {
        pulp::Arch::new().dispatch(Blurring {
            blur: self,
            cells,
            depth,
            size,
            across,
            down,
            out,
        });
    }
}

impl Line {
    fn new(variance_px2: f64, factor: usize, margin: usize) -> Self {
        let cells = (factor * factor) as f64;
        let t = variance_px2.max(0.0) * cells;
        let kernel = discrete_gaussian(t, margin + factor + 2);
        let at = |n: isize| kernel[n.unsigned_abs()];
        let count = factor + 2 * margin;
        // A pixel is the sum of its own cells.
        let gathered = |value: &dyn Fn(isize) -> f64| -> Vec<f64> {
            (0..count)
                .map(|k| {
                    let place = k as isize - margin as isize;
                    (0..factor as isize).map(|m| value(place - m)).sum()
                })
                .collect()
        };
        let mut weights = gathered(&at);
        // Conserves the light of every cell: renormalises the truncated kernel.
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w *= factor as f64 / sum);
        // The discrete Gaussian obeys the discrete diffusion equation.
        let slope = |n: isize| cells / 2.0 * (at(n - 1) - 2.0 * at(n) + at(n + 1));
        Self {
            weights,
            derivatives: gathered(&slope),
        }
    }
}

/// Returns e^-t I_n(t) for n in 0..`count`, by Miller's downward recurrence I_(n-1) = I_(n+1) + 2 n / t I_n.
///
/// Scaled so that the sum over all n of both signs is one.
fn discrete_gaussian(t: f64, count: usize) -> Vec<f64> {
    let mut kernel = vec![0.0; count];
    if t < 1e-12 {
        kernel[0] = 1.0;
        return kernel;
    }
    let first = count + 20 + (2.0 * t.sqrt()) as usize;
    let (mut above, mut here) = (0.0, 1e-280_f64);
    let mut sum = 0.0;
    for n in (0..first).rev() {
        // `here` is the value at n.
        if n < count {
            kernel[n] = here;
        }
        sum += if n == 0 { here } else { 2.0 * here };
        let below = above + 2.0 * n as f64 / t * here;
        (above, here) = (here, below);
        if here > 1e200 {
            (above, here, sum) = (above * 1e-200, here * 1e-200, sum * 1e-200);
            kernel.iter_mut().for_each(|k| *k *= 1e-200);
        }
    }
    kernel.iter_mut().for_each(|k| *k /= sum);
    kernel
}

/// [`GaussianBlur::add_separable`] for `pulp::Arch::dispatch`.
struct Blurring<'a> {
    blur: &'a GaussianBlur,
    cells: &'a [f64],
    depth: usize,
    size: (usize, usize),
    across: &'a [f64],
    down: &'a [f64],
    out: &'a mut [f64],
}

impl pulp::WithSimd for Blurring<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        if self.depth == 1 {
            self.add_columns_first();
        } else {
            self.add_rows_first();
        }
    }
}

impl<'a> Blurring<'a> {
    /// Filters each row of cells along x, then adds it to the rows of pixels: quick where a cell has several values,
    /// which are then filtered side by side.
    #[inline(always)]
    fn add_rows_first(self) {
        let (width, height) = self.size;
        let (factor, depth) = (self.blur.factor, self.depth);
        let mut line = vec![0.0; width * depth];
        for (row, source) in self.rows_of_cells().enumerate() {
            let Some(nonzero) = nonzero(source) else {
                continue;
            };
            let (first, end) = (nonzero.start / depth, nonzero.end.div_ceil(depth));
            // Pixels that get light from a nonzero cell.
            let lit = first.saturating_sub(self.across.len() - 1).div_ceil(factor)
                ..end.div_ceil(factor).min(width);
            for column in lit.clone() {
                let sums = &mut line[column * depth..(column + 1) * depth];
                sums.fill(0.0);
                let start = column * factor;
                for k in first.max(start)..end.min(start + self.across.len()) {
                    add(
                        sums,
                        self.across[k - start],
                        &source[k * depth..(k + 1) * depth],
                    );
                }
            }
            let lit = lit.start * depth..lit.end.max(lit.start) * depth;
            // Pixel rows that get light from this row of cells.
            for pixel in (0..=(row / factor).min(height - 1)).rev() {
                let Some(&weight) = self.down.get(row - pixel * factor) else {
                    break;
                };
                let target = &mut self.out[pixel * width * depth..(pixel + 1) * width * depth];
                add(&mut target[lit.clone()], weight, &line[lit.clone()]);
            }
        }
    }

    /// Sums rows of cells for each row of pixels, then filters the sum along x: quick where a cell has one value, as
    /// the cells of a row are then summed side by side.
    #[inline(always)]
    fn add_columns_first(self) {
        let (width, factor) = (self.size.0, self.blur.factor);
        let nonzero: Vec<Option<Range<usize>>> = self.rows_of_cells().map(nonzero).collect();
        let columns = self.columns();
        let mut line = vec![0.0; columns];
        for (pixel, target) in self.out.chunks_exact_mut(width).enumerate() {
            let rows = pixel * factor..pixel * factor + self.down.len();
            let lit = nonzero[rows.clone()].iter().flatten();
            let Some(lit) = lit
                .cloned()
                .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
            else {
                continue;
            };
            line[lit.clone()].fill(0.0);
            for (row, weight) in rows.zip(self.down) {
                if let Some(cells) = &nonzero[row] {
                    let source = &self.cells[row * columns..(row + 1) * columns];
                    add(&mut line[cells.clone()], *weight, &source[cells.clone()]);
                }
            }
            for (column, out) in target.iter_mut().enumerate() {
                let start = column * factor;
                let from = lit.start.max(start);
                let to = lit.end.min(start + self.across.len());
                if from < to {
                    *out += dot(&self.across[from - start..to - start], &line[from..to]);
                }
            }
        }
    }

    fn columns(&self) -> usize {
        self.size.0 * self.blur.factor + 2 * self.blur.margin
    }

    #[inline(always)]
    fn rows_of_cells(&self) -> std::slice::ChunksExact<'a, f64> {
        let rows = self.size.1 * self.blur.factor + 2 * self.blur.margin;
        let values = self.columns() * self.depth;
        self.cells[..rows * values].chunks_exact(values)
    }
}

/// Returns the range of `values` outside which all are zero, roughly; nothing if all are zero.
#[inline(always)]
fn nonzero(values: &[f64]) -> Option<Range<usize>> {
    const TOGETHER: usize = 4 * LANES;
    // By bits and without branches, so that many values are tested at once; the sign of zero is shifted out.
    let lit = |chunk: &[f64]| chunk.iter().fold(0, |bits, v| bits | v.to_bits()) << 1 != 0;
    let first = values.chunks(TOGETHER).position(lit)?;
    let last = values.chunks(TOGETHER).rposition(lit).unwrap_or(first);
    Some(first * TOGETHER..((last + 1) * TOGETHER).min(values.len()))
}

/// Returns the sum of products, by lanes.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Adds `weight` times `values` to `sums`.
#[inline(always)]
fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    let (sums, sums_rest) = sums.as_chunks_mut::<LANES>();
    let (values, values_rest) = values.as_chunks::<LANES>();
    for (sums, values) in sums.iter_mut().zip(values) {
        for lane in 0..LANES {
            sums[lane] += weight * values[lane];
        }
    }
    for (sum, value) in sums_rest.iter_mut().zip(values_rest) {
        *sum += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_a_gaussian_of_the_right_width() {
        for factor in [1, 2, 4] {
            let blur = GaussianBlur::new([0.7; 2], factor);
            let size = 17;
            let columns = size * factor + 2 * blur.margin;
            let mut fine = vec![0.0; columns * columns];
            // The cells of the middle pixel.
            let middle = blur.margin + 8 * factor;
            for y in 0..factor {
                for x in 0..factor {
                    fine[(middle + y) * columns + middle + x] = 1.0 / (factor * factor) as f64;
                }
            }
            let mut out = vec![0.0; size * size];
            blur.apply(&fine, 1, (size, size), &mut out);
            let sum: f64 = out.iter().sum();
            let variance: f64 = out
                .iter()
                .enumerate()
                .map(|(k, v)| v * ((k % size) as f64 - 8.0).powi(2))
                .sum();
            assert!((sum - 1.0).abs() < 1e-7, "{factor}: {sum}");
            // Variance of the uniformly lit pixel on the grid of cells.
            let area = (1.0 - 1.0 / (factor * factor) as f64) / 12.0;
            // Approximate: a narrow discrete Gaussian passes frequencies above the pixels' Nyquist
            // frequency, which alias depending on the place of the point in its pixel.
            let expected = 0.7 + area + pixels(factor);
            assert!(
                (variance - expected).abs() < 1e-3,
                "{factor}: {variance} {expected}"
            );
        }
    }

    /// Returns the variance that summing `factor` cells into a pixel adds.
    fn pixels(factor: usize) -> f64 {
        (1.0 - 1.0 / (factor * factor) as f64) / 12.0
    }

    #[test]
    fn the_discrete_gaussian_has_the_variance_asked_for() {
        for t in [1e-13, 1e-6, 0.01, 0.3, 2.0, 40.0, 900.0] {
            let kernel = discrete_gaussian(t, 10 + (12.0 * t.sqrt()) as usize);
            let of = |power: i32| -> f64 {
                let terms = kernel.iter().enumerate().skip(1);
                2.0 * terms.map(|(n, k)| k * (n as f64).powi(power)).sum::<f64>()
            };
            assert!((kernel[0] + of(0) - 1.0).abs() < 1e-12, "{t}");
            assert!((of(2) - t).abs() < 1e-9 * t.max(1e-3), "{t}: {}", of(2));
        }
    }

    #[test]
    fn the_derivative_is_that_by_the_variance() {
        let step = 1e-5;
        let point = |blur: &GaussianBlur| {
            let columns = 18 + 2 * blur.margin;
            let mut cells = vec![0.0; columns * columns];
            cells[(blur.margin + 8) * columns + blur.margin + 9] = 1.0;
            cells
        };
        let draw = |variance: f64| {
            let blur = GaussianBlur::new([variance; 2], 2);
            let mut out = vec![0.0; 81];
            blur.apply(&point(&blur), 1, (9, 9), &mut out);
            out
        };
        let (low, high) = (draw(0.3 - step), draw(0.3 + step));
        let blur = GaussianBlur::new([0.3; 2], 2);
        let mut derivative = vec![0.0; 81];
        blur.apply_variance_derivative(&point(&blur), (9, 9), &mut derivative);
        for (k, slope) in derivative.iter().enumerate() {
            let numeric = (high[k] - low[k]) / (2.0 * step);
            assert!((slope - numeric).abs() < 1e-6, "{k}: {slope} {numeric}");
        }
    }
}

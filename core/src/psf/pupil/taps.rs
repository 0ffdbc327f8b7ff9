//! Symmetric Gaussian blur of light on a fine grid, integrated over the pixels of a coarse one.
//!
//! A fine cell's light is spread evenly over the cell, blurred and integrated over each pixel: a
//! trapezoid blurred by the Gaussian, in closed form. Along each axis apart.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Reach of the blur beyond the trapezoid, standard deviations: 1e-8 of the light is beyond.
const REACH: f64 = 5.7;

/// Below this variance (px²) the blur is drawn as if it had it; a tenth of that cannot be told.
const LEAST_VARIANCE_PX2: f64 = 1e-4;

/// Weights of fine cells in one pixel, and their derivatives by the variance.
pub(super) struct Taps {
    /// Fine cells per pixel along an axis.
    factor: usize,
    /// Fine cells that a pixel sees beyond its own on either side.
    pub(super) margin: usize,
    weights: Vec<f64>,
    slopes: Vec<f64>,
}

impl Taps {
    /// For a blur of `variance_px2` and `factor` fine cells a pixel.
    pub(super) fn new(variance_px2: f64, factor: usize) -> Self {
        let sigma = variance_px2.max(LEAST_VARIANCE_PX2).sqrt();
        let cells = factor as f64;
        let margin = (REACH * sigma * cells).ceil() as usize;
        let (far, near) = (0.5 + 0.5 / cells, 0.5 - 0.5 / cells);
        // Second integral of the Gaussian, and the Gaussian.
        let ramp = |x: f64| {
            let z = x / sigma;
            x * 0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
                + sigma * (-0.5 * z * z).exp() / (2.0 * PI).sqrt()
        };
        let bell = |x: f64| (-0.5 * (x / sigma).powi(2)).exp() / (sigma * (2.0 * PI).sqrt());
        let count = factor + 2 * margin;
        let offset = |k: usize| (k as f64 + 0.5 - margin as f64) / cells - 0.5;
        let all = |curve: &dyn Fn(f64) -> f64, scale: f64| -> Vec<f64> {
            (0..count)
                .map(|k| {
                    let t = offset(k);
                    scale * (curve(t + far) - curve(t + near) - curve(t - near) + curve(t - far))
                })
                .collect()
        };
        let mut weights = all(&ramp, cells);
        // Every fine cell gives all its light away: what lies beyond the reach is shared out.
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w *= cells / sum);
        Self {
            factor,
            margin,
            weights,
            slopes: all(&bell, cells / 2.0),
        }
    }

    /// Blurs `fine`, `depth` values a cell, `width` x `height` pixels with a margin of
    /// [`Taps::margin`] cells on every side, into `out`. With `by_variance` the derivative by the
    /// variance instead.
    pub(super) fn apply(
        &self,
        fine: &[f64],
        depth: usize,
        size: (usize, usize),
        by_variance: bool,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let passes: &[(&[f64], &[f64])] = if by_variance {
            &[(&self.slopes, &self.weights), (&self.weights, &self.slopes)]
        } else {
            &[(&self.weights, &self.weights)]
        };
        for &(across, down) in passes {
            pulp::Arch::new().dispatch(Blurring {
                taps: self,
                fine,
                depth,
                size,
                across,
                down,
                out,
            });
        }
    }
}

/// One separable blur, compiled for the machine's vector instructions.
struct Blurring<'a> {
    taps: &'a Taps,
    fine: &'a [f64],
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
        let (width, height) = self.size;
        let (factor, depth) = (self.taps.factor, self.depth);
        let columns = width * factor + 2 * self.taps.margin;
        let rows = height * factor + 2 * self.taps.margin;
        let mut line = vec![0.0; width * depth];
        for row in 0..rows {
            let source = &self.fine[row * columns * depth..(row + 1) * columns * depth];
            let Some(first) = source.iter().position(|v| *v != 0.0) else {
                continue;
            };
            let end = source.iter().rposition(|v| *v != 0.0).unwrap_or(first) / depth + 1;
            let first = first / depth;
            // Pixels that see a lit cell.
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
            // Pixel rows that see this fine row: start <= row < start + taps.
            for pixel in (0..=(row / factor).min(height - 1)).rev() {
                let Some(&weight) = self.down.get(row - pixel * factor) else {
                    break;
                };
                let target = &mut self.out[pixel * width * depth..(pixel + 1) * width * depth];
                add(&mut target[lit.clone()], weight, &line[lit.clone()]);
            }
        }
    }
}

/// Adds `weight` times `values` to `sums`.
#[inline(always)]
fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    const LANES: usize = super::mesh::LANES;
    let mut sums = sums.chunks_exact_mut(LANES);
    let mut values = values.chunks_exact(LANES);
    for (sums, values) in sums.by_ref().zip(values.by_ref()) {
        for lane in 0..LANES {
            sums[lane] += weight * values[lane];
        }
    }
    let rest = sums.into_remainder().iter_mut();
    for (sum, value) in rest.zip(values.remainder()) {
        *sum += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_a_gaussian_of_the_right_width() {
        for factor in [1, 2, 4] {
            let taps = Taps::new(0.7, factor);
            let size = 13;
            let columns = size * factor + 2 * taps.margin;
            let mut fine = vec![0.0; columns * columns];
            // The cells about the middle of pixel (6, 6).
            let middle = taps.margin + 6 * factor;
            for y in 0..factor {
                for x in 0..factor {
                    fine[(middle + y) * columns + middle + x] = 1.0 / (factor * factor) as f64;
                }
            }
            let mut out = vec![0.0; size * size];
            taps.apply(&fine, 1, (size, size), false, &mut out);
            let sum: f64 = out.iter().sum();
            let variance: f64 = out
                .iter()
                .enumerate()
                .map(|(k, v)| v * ((k % size) as f64 - 6.0).powi(2))
                .sum();
            assert!((sum - 1.0).abs() < 1e-7, "{factor}: {sum}");
            // The pixel's own area twice: the evenly lit pixel, and the one that integrates.
            assert!((variance - 0.7 - 1.0 / 6.0).abs() < 1e-4, "{variance}");
        }
    }

    #[test]
    fn the_derivative_is_that_by_the_variance() {
        let step = 1e-5;
        let draw = |variance: f64, by_variance: bool| {
            let taps = Taps::new(variance, 2);
            let columns = 18 + 2 * taps.margin;
            let mut fine = vec![0.0; columns * columns];
            fine[(taps.margin + 8) * columns + taps.margin + 9] = 1.0;
            let mut out = vec![0.0; 81];
            taps.apply(&fine, 1, (9, 9), by_variance, &mut out);
            out
        };
        let (low, high) = (draw(0.3 - step, false), draw(0.3 + step, false));
        for (k, slope) in draw(0.3, true).iter().enumerate() {
            let numeric = (high[k] - low[k]) / (2.0 * step);
            assert!((slope - numeric).abs() < 1e-6, "{k}: {slope} {numeric}");
        }
    }
}

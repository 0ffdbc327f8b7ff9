//! The PSF of one block of a photograph: non-negative least squares on the pixels of one colour.

use nalgebra::{DMatrix, DVector};

use super::block_estimate::BlockEstimate;
use super::kernel::Filters;
use super::picture::Region;
use super::variation::Variation;
use crate::photograph::Photograph;
use crate::rejection::Reason;
use seidel_optics::numeric::scatter;

/// Weight of the squared gradient of a tile over the mean diagonal of the normal equations.
const GRADIENT_WEIGHT: f64 = 1e-4;
/// Standard deviations from which on a pixel is left out.
const OUTLIER_SIGMAS: f64 = 6.0;
/// Sweeps of coordinate descent, and the largest change relative to the largest sample at which it ends.
const MAX_SWEEPS: usize = 400;
const CHANGE: f64 = 1e-6;

/// The chart as the photograph would show it without blur, over a region.
#[derive(Debug, Clone)]
pub(crate) struct SharpView {
    pub(crate) region: Region,
    pub(crate) values: Vec<f64>,
}

impl SharpView {
    /// Returns the root mean square difference between neighbours of a row.
    fn detail(&self) -> f64 {
        let rows = self.values.chunks(self.region.width);
        let squares = rows.flat_map(|row| row.windows(2).map(|w| (w[1] - w[0]).powi(2)));
        let count = self.region.height * (self.region.width - 1);
        (squares.sum::<f64>() / count.max(1) as f64).sqrt()
    }

    /// Returns the range of the chart.
    fn contrast(&self) -> f64 {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        self.values
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max)
            - low
    }

    fn at(&self, x: i64, y: i64) -> f64 {
        let column = (x - self.region.left) as usize;
        let row = (y - self.region.top) as usize;
        self.values[row * self.region.width + column]
    }
}

/// Why a block has no estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Failure {
    pub(crate) why: Reason,
    pub(crate) value: f64,
    pub(crate) limit: f64,
}

/// Share of clipped pixels up to which the others are used.
const MAX_CLIPPED: f64 = 0.05;
/// Least difference between the bright and the dark of the chart over the brightest pixel.
const MIN_CONTRAST: f64 = 0.08;
const NO_CONTRAST: Failure = Failure {
    why: Reason::LowContrast,
    value: 0.0,
    limit: MIN_CONTRAST,
};

/// A block to estimate.
pub(crate) struct BlockTask<'a> {
    pub(crate) photo: &'a Photograph,
    pub(crate) channel: usize,
    pub(crate) sharp: &'a SharpView,
    /// Pixels whose light is compared.
    pub(crate) block: Region,
    /// Odd width and height of the tile.
    pub(crate) side: usize,
    /// Change of the PSF over the block, if known.
    pub(super) variation: Option<&'a Variation>,
    /// Alternations between the tile and the slope of the light.
    pub(crate) light_steps: usize,
    /// Noise variance of a dark pixel, counts², and counts per electron.
    pub(crate) dark_variance: f64,
    pub(crate) gain: f64,
    /// The step from the kernel to the tile, whose error is stated.
    pub(super) integration: &'a Filters,
}

/// The pixels of a block.
struct Pixels {
    /// One column a pixel: the chart at every offset of the tile, then 1 for the offset.
    design: DMatrix<f64>,
    values: DVector<f64>,
    /// Light that the change of a PSF of unit sum over the block adds.
    change: DVector<f64>,
    /// Position in the block, -0.5 to 0.5.
    place: Vec<[f64; 2]>,
}

impl BlockTask<'_> {
    /// Returns the estimate.
    ///
    /// # Errors
    /// Too many clipped pixels, or no contrast.
    pub(crate) fn estimate(&self) -> Result<BlockEstimate, Failure> {
        let pixels = self.pixels()?;
        let (count, unknowns) = (pixels.values.len(), self.side * self.side);
        let mut light = DVector::from_element(count, 1.0);
        let mut predicted = pixels.values.clone();
        let mut kernel = DVector::zeros(unknowns);
        let mut offset = 0.0;
        let mut normal = DMatrix::zeros(unknowns + 1, unknowns + 1);
        let mut right = DVector::zeros(unknowns + 1);
        let mut changed = DVector::zeros(count);
        let mut weights = DVector::zeros(count);
        for step in 0..self.light_steps {
            weights = predicted.map(|v| 1.0 / (self.dark_variance + self.gain * v.max(0.0)));
            without_outliers(&mut weights, &(&pixels.values - &predicted));
            // Columns are pixels, so that memory is read in order; the product is a blocked one.
            let mut weighted = pixels.design.clone();
            let mut right_side = &pixels.values - changed.component_mul(&light);
            for k in 0..count {
                let root = weights[k].sqrt();
                weighted.column_mut(k).scale_mut(root * light[k]);
                right_side[k] *= root;
            }
            normal = &weighted * weighted.transpose();
            right = &weighted * right_side;
            let start = (step > 0).then_some((&kernel, offset));
            let solved = non_negative(&self.regularised(&normal), &right, start);
            kernel = solved.rows(0, unknowns).into_owned();
            offset = solved[unknowns];
            changed = &pixels.change * kernel.sum();
            let flat = pixels.design.tr_mul(&solved) + &changed;
            light = slope_of_light(&pixels, &flat, &weights).ok_or(NO_CONTRAST)?;
            predicted = flat.component_mul(&light);
        }
        let total = kernel.sum();
        let contrast = total * self.sharp.contrast() / pixels.values.amax().max(1e-30);
        if !(contrast.is_finite() && contrast > MIN_CONTRAST) {
            return Err(Failure {
                value: contrast.max(0.0),
                ..NO_CONTRAST
            });
        }
        let residual = &pixels.values - &predicted;
        let used = weights.iter().filter(|w| **w > 0.0).count();
        let chi_square = residual.component_mul(&residual).dot(&weights) / used.max(1) as f64;
        let sigma = self.kernel_sigma(&normal, &kernel) * chi_square.max(1.0).sqrt() / total;
        let noise: f64 = weights.iter().filter(|w| **w > 0.0).map(|w| 1.0 / w).sum();
        let square: f64 = (residual.iter().zip(weights.iter()))
            .filter_map(|(r, w)| (*w > 0.0).then_some(r * r))
            .sum();
        let beyond_noise = ((square - noise).max(0.0) / used.max(1) as f64).sqrt();
        Ok(BlockEstimate {
            kernel: kernel.iter().map(|v| v / total).collect(),
            chi_square,
            misfit: beyond_noise / (total * self.sharp.contrast()),
            curvature: curvature(&predicted, &residual, &weights),
            unbounded: self.unbounded(&normal, &right),
            sigma,
            white: total + offset,
            detail: self.sharp.detail(),
        })
    }

    fn pixels(&self) -> Result<Pixels, Failure> {
        let half = (self.side / 2) as i64;
        let plane = &self.photo.planes[self.photo.plane_of(self.channel)];
        let mut places = Vec::new();
        let (mut clipped, mut all) = (0.0, 0.0);
        for y in self.block.top..self.block.top + self.block.height as i64 {
            for x in self.block.left..self.block.left + self.block.width as i64 {
                let (column, row) = (x as usize, y as usize);
                let index = row * self.photo.width + column;
                if !self.photo.covers(self.channel, column, row) || self.photo.is_bad(column, row) {
                    continue;
                }
                all += 1.0;
                if plane[index] < self.photo.white {
                    places.push((x, y));
                } else {
                    clipped += 1.0;
                }
            }
        }
        let unknowns = self.side * self.side;
        let share = clipped / f64::max(all, 1.0);
        if share > MAX_CLIPPED || places.len() < unknowns + unknowns / 4 {
            return Err(Failure {
                why: Reason::Clipped,
                value: share,
                limit: MAX_CLIPPED,
            });
        }
        let side = self.side as i64;
        let mut design = DMatrix::from_element(unknowns + 1, places.len(), 1.0);
        for (k, (x, y)) in places.iter().enumerate() {
            let mut column = design.column_mut(k);
            for index in 0..unknowns as i64 {
                let (dx, dy) = (index % side - half, index / side - half);
                column[index as usize] = self.sharp.at(x - dx, y - dy);
            }
        }
        let middle = |start: i64, length: usize| start as f64 + (length as f64 - 1.0) / 2.0;
        let [across, down] = [
            middle(self.block.left, self.block.width),
            middle(self.block.top, self.block.height),
        ];
        let change = places.iter().enumerate().map(|(k, (x, y))| {
            let off = [*x as f64 - across, *y as f64 - down];
            let chart = &design.as_slice()[k * (unknowns + 1)..][..unknowns];
            self.variation.map_or(0.0, |v| v.light(off, chart))
        });
        let change = DVector::from_iterator(places.len(), change);
        let values = places
            .iter()
            .map(|(x, y)| f64::from(plane[*y as usize * self.photo.width + *x as usize]));
        let relative = |v: i64, start: i64, length: usize| (v - start) as f64 / length as f64 - 0.5;
        Ok(Pixels {
            values: DVector::from_iterator(places.len(), values),
            design,
            change,
            place: (places.iter())
                .map(|(x, y)| {
                    [
                        relative(*x, self.block.left, self.block.width),
                        relative(*y, self.block.top, self.block.height),
                    ]
                })
                .collect(),
        })
    }

    /// Returns the normal equations with the squared gradient of the tile added.
    fn regularised(&self, normal: &DMatrix<f64>) -> DMatrix<f64> {
        let unknowns = self.side * self.side;
        let trace: f64 = (0..unknowns).map(|k| normal[(k, k)]).sum();
        let weight = GRADIENT_WEIGHT * trace / unknowns as f64;
        let mut sum = normal.clone();
        for index in 0..unknowns {
            let (x, y) = (index % self.side, index / self.side);
            for (there, other) in [
                (x + 1 < self.side, index + 1),
                (y + 1 < self.side, index + self.side),
            ] {
                if there {
                    sum[(index, index)] += weight;
                    sum[(other, other)] += weight;
                    sum[(index, other)] -= weight;
                    sum[(other, index)] -= weight;
                }
            }
        }
        sum
    }

    /// Returns the tile of unit sum that may be negative.
    fn unbounded(&self, normal: &DMatrix<f64>, right: &DVector<f64>) -> Vec<f64> {
        let unknowns = self.side * self.side;
        let solved = self.regularised(normal).cholesky().map(|c| c.solve(right));
        let solved = solved.unwrap_or_else(|| DVector::zeros(unknowns + 1));
        let total = solved.rows(0, unknowns).sum();
        let kernel: Vec<f64> = solved.iter().take(unknowns).map(|v| v / total).collect();
        self.integration.of(&kernel, self.side)
    }

    /// Returns the standard deviation of a typical sample of the tile of `kernel`, from the inverse of the normal equations: root
    /// mean square over the samples that hold light. Those at zero are held there, and the step to area-integrated pixels
    /// averages errors of opposite sign.
    fn kernel_sigma(&self, normal: &DMatrix<f64>, kernel: &DVector<f64>) -> f64 {
        let unknowns = self.side * self.side;
        let mut free: Vec<usize> = (0..unknowns).filter(|k| kernel[*k] > 0.0).collect();
        free.push(unknowns);
        let all = self.regularised(normal);
        let restricted = DMatrix::from_fn(free.len(), free.len(), |r, c| all[(free[r], free[c])]);
        free.pop();
        let Some(cholesky) = restricted.cholesky() else {
            return 0.0;
        };
        // The covariance is the inverse of L L', so that of the filtered samples F is the square of F times the inverse of L'.
        let root = cholesky.l().transpose();
        let root = root.solve_upper_triangular(&DMatrix::identity(free.len() + 1, free.len() + 1));
        let Some(root) = root else {
            return 0.0;
        };
        let mut square = 0.0;
        for column in root.column_iter() {
            let mut samples = vec![0.0; unknowns];
            for (at, value) in free.iter().zip(column.iter()) {
                samples[*at] = *value;
            }
            let tile = self.integration.of(&samples, self.side);
            square += free.iter().map(|at| tile[*at].powi(2)).sum::<f64>();
        }
        (square / free.len().max(1) as f64).sqrt()
    }
}

/// Returns the part of `residual` that is a parabola of the predicted light, zero at its ends: the height in the middle over the
/// range. A curve between light and values bends them so.
fn curvature(predicted: &DVector<f64>, residual: &DVector<f64>, weights: &DVector<f64>) -> f64 {
    let used = || (0..weights.len()).filter(|k| weights[*k] > 0.0);
    let (low, high) = used().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), k| {
        (low.min(predicted[k]), high.max(predicted[k]))
    });
    let range = (high - low).max(f64::MIN_POSITIVE);
    let (mut normal, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
    for k in used() {
        let at = (predicted[k] - low) / range;
        let row = nalgebra::Vector3::new(1.0, at, 4.0 * at * (1.0 - at));
        normal += row * row.transpose();
        right += row * residual[k] / range;
    }
    normal.cholesky().map_or(0.0, |c| c.solve(&right)[2])
}

/// Sets the weights of pixels to zero whose residuals stand out from the others: hot pixels and dust.
fn without_outliers(weights: &mut DVector<f64>, residual: &DVector<f64>) {
    let relative = residual.zip_map(weights, |r, w| r * w.sqrt());
    let limit = OUTLIER_SIGMAS * scatter(relative.as_slice());
    if limit > 0.0 {
        for (weight, value) in weights.iter_mut().zip(&relative) {
            if value.abs() > limit {
                *weight = 0.0;
            }
        }
    }
}

/// Returns the light over the block as a plane whose mean is one, by weighted least squares.
fn slope_of_light(
    pixels: &Pixels,
    flat: &DVector<f64>,
    weights: &DVector<f64>,
) -> Option<DVector<f64>> {
    let mut normal = nalgebra::Matrix3::zeros();
    let mut right = nalgebra::Vector3::zeros();
    for (k, [x, y]) in pixels.place.iter().enumerate() {
        let row = nalgebra::Vector3::new(1.0, *x, *y) * flat[k];
        normal += weights[k] * row * row.transpose();
        right += weights[k] * row * pixels.values[k];
    }
    let [level, x_slope, y_slope] = normal.cholesky()?.solve(&right).into();
    if level <= 0.0 {
        return None;
    }
    let light = pixels
        .place
        .iter()
        .map(|[x, y]| (level + x_slope * x + y_slope * y) / level);
    Some(DVector::from_iterator(flat.len(), light))
}

/// Minimises x'Ax/2 - b'x for all x but the last at least zero, by coordinate descent.
fn non_negative(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    start: Option<(&DVector<f64>, f64)>,
) -> DVector<f64> {
    let count = right.len();
    let last = count - 1;
    let mut x = DVector::zeros(count);
    if let Some((kernel, offset)) = start {
        x.rows_mut(0, last).copy_from(kernel);
        x[last] = offset;
    }
    let mut gradient = matrix * &x - right;
    for _ in 0..MAX_SWEEPS {
        let mut change = 0.0_f64;
        for k in (0..count).rev() {
            let diagonal = matrix[(k, k)];
            if diagonal <= 0.0 {
                continue;
            }
            let wanted = x[k] - gradient[k] / diagonal;
            let value = if k == last { wanted } else { wanted.max(0.0) };
            let step = value - x[k];
            if step != 0.0 {
                x[k] = value;
                gradient.axpy(step, &matrix.column(k), 1.0);
                change = change.max(step.abs());
            }
        }
        if change <= CHANGE * x.rows(0, last).amax() {
            break;
        }
    }
    x
}

//! The deconvolution of one plane as a problem: the plate, the lens, the weights of samples, and what an estimate leaves.

use super::canvas::Canvas;
use super::gradient::{LinkedPlane, sampled_norms, white_noise_power};
use super::lens_operator::LensOperator;
use super::local_mean::average_locally;
use super::ramp;
use super::vectors::{add_scaled, dot};
use super::winsorised::WinsorisedStatistics;
use rayon::prelude::*;
use seidel_optics::error::Result;

/// Shares of a pixel's light from unknown samples, at which the start begins to turn into the plate and is the plate alone.
const UNKNOWN_LIGHT: [f32; 2] = [0.005, 0.02];
/// Residual at which the weight of a sample is halved, in standard deviations.
const OUTLIER: f32 = 3.0;
/// Standard deviation of a normal deviate over the median of its absolute value.
const MEDIAN_TO_DEVIATION: f32 = 1.4826;
/// Root mean square residual that noise explains, in standard deviations.
const UNEXPLAINED: f64 = 2.0;
/// Powers of the residual beyond that, in those of the plate as its own sharp image, at which the image begins to turn into the plate
/// and is the plate alone.
const POORER: [f32; 2] = [0.5, 1.0];

/// The deconvolution of one plane.
pub(super) struct Problem<'a> {
    /// b, extended to the canvas.
    pub(super) plate: &'a [f32],
    pub(super) canvas: Canvas,
    /// A.
    pub(super) operator: &'a LensOperator,
    /// The diagonal of W.
    pub(super) weights: Vec<f32>,
    /// Standard deviation of the plate's noise.
    pub(super) noise: f64,
    /// The least that it can be: a smaller residual shows that the estimate overfits.
    pub(super) least_noise: f64,
    /// s.
    pub(super) deviation: f64,
    /// Number of iterations.
    pub(super) iterations: usize,
    pub(super) refinement: Refinement,
}

/// The steps that the lens check leaves out: the return of the start to the plate beside unknown samples, and the correction of
/// texture and the prior of patches after the last iteration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refinement {
    Run,
    Skip,
}

/// An image x, or a search direction, with its blurred version A x.
pub(super) struct BlurPair {
    pub(super) image: Vec<f32>,
    pub(super) blurred: Vec<f32>,
}

impl Problem<'_> {
    /// Returns the columns of the canvas.
    pub(super) fn width(&self) -> usize {
        self.canvas.size().0
    }

    /// Replaces `start` by the plate at pixels that get light from others than the `known` ones. What these are filled with is no
    /// blurred image, so that the filter makes it ring, and the iterations are too few to remove that.
    pub(super) fn return_to_plate(&self, start: &mut [f32], known: &[bool]) -> Result<()> {
        let unknown = known.iter().map(|known| f32::from(u8::from(!known)));
        let unknown: Vec<f32> = unknown.collect();
        if unknown.iter().all(|unknown| *unknown == 0.0) {
            return Ok(());
        }
        let light = self.operator.apply(&unknown)?;
        let samples = start.par_iter_mut().zip(self.plate).zip(&light);
        samples.for_each(|((sample, plate), light)| {
            *sample += ramp(*light, UNKNOWN_LIGHT) * (plate - *sample);
        });
        Ok(())
    }

    /// Returns the weights `certain`, lowered at depth edges where the residual of `estimate` is larger than noise: the depth pass is
    /// wrong by parts of a pixel there, or a third surface lies behind the second (Cauchy weights, with the median as the scale).
    /// Elsewhere a large residual is detail that is not in the estimate yet.
    pub(super) fn without_outliers(&self, estimate: &BlurPair, certain: &[f32]) -> Vec<f32> {
        let residual = |k: usize| (self.plate[k] - estimate.blurred[k]).abs();
        let known = (0..certain.len()).filter(|k| certain[*k] > 0.0);
        let mut residuals: Vec<f32> = known.map(residual).collect();
        if residuals.is_empty() {
            return certain.to_vec();
        }
        let middle = residuals.len() / 2;
        let (_, median, _) = residuals.select_nth_unstable_by(middle, f32::total_cmp);
        let scale = (MEDIAN_TO_DEVIATION * *median).max(self.deviation as f32) * OUTLIER;
        let edges = self.operator.edge_shares();
        let weight = |k: usize| certain[k] / (1.0 + edges[k] * (residual(k) / scale).powi(2));
        (0..certain.len()).into_par_iter().map(weight).collect()
    }

    /// Returns the share of its blur that each pixel of the canvas keeps because `estimate` does not explain the plate around it better
    /// than the plate itself would as a sharp image.
    pub(super) fn unexplained_shares(&self, estimate: &BlurPair) -> Result<Vec<f32>> {
        let plate = self.blur(self.operator.image(self.plate.to_vec()))?;
        let local_power = |pair: &BlurPair| {
            let mut power = self.weighted_residual(pair, 1.0);
            power.par_iter_mut().for_each(|v| *v *= *v);
            average_locally(&mut power, self.width());
            power
        };
        let noise = (UNEXPLAINED * self.deviation).powi(2) as f32;
        let (own, of_plate) = (local_power(estimate), local_power(&plate));
        let share = |(own, of_plate): (&f32, &f32)| {
            ramp(
                own - noise,
                [
                    POORER[0] * of_plate,
                    POORER[1] * of_plate + f32::MIN_POSITIVE,
                ],
            )
        };
        Ok(own.par_iter().zip(&of_plate).map(share).collect())
    }

    /// Returns the residual b - A x on the plate, 0 where samples have no weight.
    pub(super) fn residual(&self, estimate: &BlurPair) -> Vec<f32> {
        let samples = self.plate.par_iter().zip(&estimate.blurred);
        let residual: Vec<f32> = samples
            .zip(&self.weights)
            .map(|((b, blurred), weight)| if *weight > 0.0 { b - blurred } else { 0.0 })
            .collect();
        self.canvas.crop(&residual)
    }

    /// Returns the weighted root mean square of the residual, in units of s.
    pub(super) fn misfit(&self, estimate: &BlurPair) -> f64 {
        let samples = self.plate.par_iter().zip(&estimate.blurred);
        let residual: Vec<f32> = samples
            .zip(&self.weights)
            .map(|((b, blurred), weight)| (b - blurred) * weight.sqrt())
            .collect();
        let count: f64 = self.weights.iter().map(|weight| f64::from(*weight)).sum();
        (dot(&residual, &residual) / count.max(1.0)).sqrt() / self.deviation
    }

    /// Returns `gain` W (b - A x) on the canvas.
    pub(super) fn weighted_residual(&self, estimate: &BlurPair, gain: f32) -> Vec<f32> {
        let samples = self.plate.par_iter().zip(&estimate.blurred);
        samples
            .zip(&self.weights)
            .map(|((b, blurred), weight)| weight * (b - blurred) * gain)
            .collect()
    }

    /// Returns `image` with its blurred version.
    pub(super) fn blur(&self, image: Vec<f32>) -> Result<BlurPair> {
        Ok(BlurPair {
            blurred: self.operator.apply(&image)?,
            image,
        })
    }

    /// Returns the plane of an image that the plate shows, without what is hidden.
    pub(super) fn front<'a>(&self, estimate: &'a BlurPair) -> &'a [f32] {
        &estimate.image[..self.plate.len()]
    }

    /// Returns `estimate` with another plane in front, and its blurred version.
    pub(super) fn blur_with_front(
        &self,
        estimate: &BlurPair,
        mut front: Vec<f32>,
    ) -> Result<BlurPair> {
        front.extend(&estimate.image[self.plate.len()..]);
        self.blur(front)
    }

    /// Returns the root mean square gradient of the plate without its noise.
    pub(super) fn plate_gradient(&self) -> f64 {
        let gradients =
            WinsorisedStatistics::new(sampled_norms(LinkedPlane::plain(self.plate, self.width())));
        let rms = gradients.root_mean_square;
        let noise_power = self.noise * self.noise * white_noise_power();
        // The noise is an estimate: the difference could be zero or negative.
        (rms * rms - noise_power).max(0.1 * noise_power).sqrt()
    }
}

impl BlurPair {
    pub(super) fn add_scaled(&mut self, other: &Self, gain: f64) {
        add_scaled(&mut self.image, &other.image, gain as f32);
        add_scaled(&mut self.blurred, &other.blurred, gain as f32);
    }

    pub(super) fn scale(&mut self, gain: f64) {
        for plane in [&mut self.image, &mut self.blurred] {
            plane
                .par_iter_mut()
                .for_each(|sample| *sample *= gain as f32);
        }
    }
}

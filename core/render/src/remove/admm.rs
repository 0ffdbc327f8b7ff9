//! Total-variation deconvolution of one plane by ADMM, the alternating direction method of multipliers.
//!
//! The sharp image x of a plate b minimises
//!
//! ```text
//! |W^(1/2) (A x - b)|² / (2 s²) + l sum |D x|
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | A | the lens on the canvas, a linear operator |
//! | W | weights of samples, diagonal, from the noise model; 0 where the plate is unknown |
//! | s | standard deviation of a typical sample: noise and model error |
//! | D | the gradient in four directions; the sum over pixels of its norm is the total variation |
//! | l | the regularisation weight |
//!
//! The start is a Wiener filter on local spectra. ADMM sets the gradient apart as z = D x, with a scaled multiplier u and
//! a penalty r. Each iteration
//!
//! 1. shortens D x + u by l / r at each pixel, which gives z, and sets u to the rest;
//! 2. lowers Q(x) = |W^(1/2) (A x - b)|² / (2 s²) + r |D x - z + u|² / 2 by one exact line search over the plane of two
//!    directions: the preconditioned negative gradient of Q, and the previous step. On one fixed quadratic this is the
//!    method of conjugate gradients.
//!
//! The weights l and r follow the mean gradient of the estimate. Two things differ from the textbook. The multiplier u is
//! not scaled when r changes. And while the residual is larger than s it takes the place of s, because fitting the plate at
//! once makes the image ring.

use super::canvas::Canvas;
use super::gradient::{Gradient, sampled_norms, white_noise_power};
use super::lens_operator::{Accuracy, KEPT_NORMALISATION_ERROR, LensOperator};
use super::plug_and_play::refine;
use super::quadratic::Quadratic;
use super::ramp;
use super::vectors::{add_scaled, dot};
use super::winsorised::WinsorisedStatistics;
use crate::cancelled;
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// l times the mean gradient of the estimate. It would be 1 if gradients had a Laplacian distribution; the value was
/// chosen on photographs, which are smoother than their gradients suggest.
const WEIGHT: f64 = 0.15;
/// The same where the prior of patches follows: it removes the noise that is left, but cannot restore what total variation
/// has flattened.
const WEIGHT_BEFORE_PATCHES: f64 = 0.05;
/// The same where depth varies: the residual falls slowly there, so that l would grow too late to keep the image from ringing.
const WEIGHT_IN_DEPTH: f64 = 0.3;
/// Largest mean gradient, in root mean square gradients of the plate without its noise: larger ones are amplified noise.
const MAX_MEAN_GRADIENT: f64 = 2.0;
/// Ratio of residual to noise below which the estimate overfits and l grows.
const OVERFIT_RATIO: f64 = 0.94;
/// Largest growth of l in one iteration.
const MAX_WEIGHT_GROWTH: f64 = 4.0;
/// Largest l times the mean gradient.
const MAX_WEIGHT: f64 = 8.0;
/// l / r, by which gradients are shortened, in mean gradients.
const THRESHOLD: f64 = 1.5;
/// Shares of a pixel's light from unknown samples, at which the start begins to turn into the plate and is the plate alone.
const UNKNOWN_LIGHT: [f32; 2] = [0.005, 0.02];
/// Times that the strength of the Wiener filter's prior is estimated.
const STRENGTH_PASSES: usize = 2;
/// Least mean square gradient that the Wiener filter assumes, in variances of the noise. Below, it would damp the spectrum
/// of the tiles' own windows.
const MIN_STRENGTH: f64 = 20.0;
/// Least residual that is treated as noise, as a share of the largest so far. Where the kernel varies much within a tile,
/// the preconditioner is poor, and the image would ring long before it fits the plate.
const MIN_RESIDUAL_SHARE: f64 = 0.25;
/// Share of the progress that the iterations take where a refinement follows them.
const ITERATIONS_SHARE: f64 = 0.6;

/// The deconvolution of one plane.
pub(super) struct Problem<'a> {
    /// b, extended to the canvas.
    pub(super) plate: &'a [f32],
    pub(super) canvas: Canvas,
    /// A.
    pub(super) operator: &'a LensOperator,
    /// The diagonal of W.
    pub(super) weights: &'a [f32],
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

/// A solved problem.
pub(super) struct Solution {
    pub(super) estimate: BlurPair,
    /// The quadratic of the last iteration.
    pub(super) quadratic: Quadratic,
}

/// Solves `problem`. `progress` gets the share done.
///
/// # Errors
/// Cancellation by `progress`.
pub(super) fn solve(problem: &Problem, progress: &Progress) -> Result<Solution> {
    let width = problem.width();
    let data_weight = problem.deviation.powi(-2);
    let mut estimate = problem.blur(wiener_estimate(problem, data_weight)?, Accuracy::Final)?;
    let mut multiplier = Gradient::zeros(problem.plate.len(), width);
    let mut previous: Option<BlurPair> = None;
    let mut mean_gradient = MAX_MEAN_GRADIENT * problem.plate_gradient();
    let (mut weight, iterations_share) = match problem.refinement {
        Refinement::Run if problem.operator.is_flat() => (WEIGHT_BEFORE_PATCHES, ITERATIONS_SHARE),
        Refinement::Run => (WEIGHT_IN_DEPTH, ITERATIONS_SHARE),
        Refinement::Skip => (WEIGHT, 1.0),
    };
    let mut largest_misfit = 0.0_f64;
    let mut quadratic = Quadratic {
        data_weight,
        penalty: 0.0,
    };
    for iteration in 0..problem.iterations {
        if !progress(iterations_share * iteration as f64 / problem.iterations as f64) {
            return Err(cancelled());
        }
        // It never grows: ringing has gradients of its own.
        let gradients = WinsorisedStatistics::new(sampled_norms(&estimate.image, width));
        mean_gradient = gradients.mean.min(mean_gradient);
        if mean_gradient == 0.0 {
            break;
        }
        let misfit = problem.misfit(&estimate);
        if iteration > 0 {
            let ratio = misfit * problem.deviation / (OVERFIT_RATIO * problem.least_noise);
            let growth = ratio.powi(-4).clamp(1.0, MAX_WEIGHT_GROWTH);
            weight = (weight * growth).min(MAX_WEIGHT);
        }
        quadratic.penalty = weight / (THRESHOLD * mean_gradient * mean_gradient);
        let threshold = (THRESHOLD * mean_gradient) as f32;
        let pull = multiplier.update_multiplier(&estimate.image, threshold);
        largest_misfit = largest_misfit.max(misfit);
        let least = (MIN_RESIDUAL_SHARE * largest_misfit).max(1.0);
        quadratic.data_weight = data_weight / misfit.max(least).powi(2);
        let descent = quadratic.descent(problem, &estimate, &pull)?;
        let direction = quadratic.precondition(problem, &descent)?;
        let direction = problem.blur(direction, Accuracy::Draft)?;
        let step = quadratic.line_search(problem, &descent, direction, previous.take());
        estimate.add_scaled(&step, 1.0);
        previous = Some(step);
        if iteration + 1 == problem.iterations / 2 {
            // Errors of the draft operator have added up; the second half would fit them.
            estimate = problem.blur(estimate.image, Accuracy::Final)?;
        }
    }
    estimate = problem.blur(estimate.image, Accuracy::Final)?;
    if problem.refinement == Refinement::Run {
        let residual = problem.weighted_residual(&estimate, 1.0);
        let correction =
            (problem.operator).texture_correction(&estimate.image, &residual, problem.deviation)?;
        add_scaled(&mut estimate.image, &correction, 1.0);
        estimate = problem.blur(estimate.image, Accuracy::Final)?;
        estimate = refine(problem, estimate, &|share| {
            progress(ITERATIONS_SHARE + (1.0 - ITERATIONS_SHARE) * share)
        })?;
    }
    Ok(Solution {
        estimate,
        quadratic,
    })
}

/// Returns the plate after a Wiener filter on local spectra, whose prior power spectrum is proportional to 1 / |D|². Its
/// strength, the mean square gradient of the image, is estimated from the filtered image.
fn wiener_estimate(problem: &Problem, data_weight: f64) -> Result<Vec<f32>> {
    let width = problem.width();
    let mean_square_gradient = |image: &[f32]| {
        let gradients = WinsorisedStatistics::new(sampled_norms(image, width));
        gradients.root_mean_square.powi(2)
    };
    // A guess to begin with: blur has lowered the gradients of the plate, and noise has raised them.
    let mut strength = 2.0 * mean_square_gradient(problem.plate);
    let least = MIN_STRENGTH / data_weight;
    let mut estimate = problem.plate.to_vec();
    let weights = problem.canvas.crop(problem.weights);
    let known = problem.canvas.embed(true, |k| weights[k] > 0.0);
    for _ in 0..STRENGTH_PASSES {
        let damping = (2.0 / (data_weight * strength.max(least))) as f32;
        let wiener = |h: Complex<f32>, gradient_power: f32| {
            h.conj() / (h.norm_sqr() + damping * gradient_power)
        };
        estimate = (problem.operator).filter_by_layer(problem.plate, &known, wiener)?;
        strength = mean_square_gradient(&estimate);
    }
    if problem.refinement == Refinement::Run {
        problem.return_to_plate(&mut estimate, &known)?;
    }
    Ok(estimate)
}

impl Problem<'_> {
    /// Returns the columns of the canvas.
    pub(super) fn width(&self) -> usize {
        self.canvas.size().0
    }

    /// Replaces `start` by the plate at pixels that get light from others than the `known` ones. What these are filled with is no
    /// blurred image, so that the filter makes it ring, and the iterations are too few to remove that. Samples at depth edges are
    /// left out: from the plate, edges of surfaces that are blurred little come back worse.
    fn return_to_plate(&self, start: &mut [f32], known: &[bool]) -> Result<()> {
        let errors = self.operator.normalisation_error();
        let is_at_edge = |k: usize| {
            (errors.as_ref()).is_some_and(|errors| errors[k] > KEPT_NORMALISATION_ERROR[0])
        };
        let unknown: Vec<f32> = (known.iter().enumerate())
            .map(|(k, known)| if *known || is_at_edge(k) { 0.0 } else { 1.0 })
            .collect();
        if unknown.iter().all(|unknown| *unknown == 0.0) {
            return Ok(());
        }
        let light = self.operator.apply(&unknown, Accuracy::Draft)?;
        let samples = start.par_iter_mut().zip(self.plate).zip(&light);
        samples.for_each(|((sample, plate), light)| {
            *sample += ramp(*light, UNKNOWN_LIGHT) * (plate - *sample);
        });
        Ok(())
    }

    /// Returns the residual b - A x on the plate, 0 where samples have no weight.
    pub(super) fn residual(&self, estimate: &BlurPair) -> Vec<f32> {
        let samples = self.plate.par_iter().zip(&estimate.blurred);
        let residual: Vec<f32> = samples
            .zip(self.weights)
            .map(|((b, blurred), weight)| if *weight > 0.0 { b - blurred } else { 0.0 })
            .collect();
        self.canvas.crop(&residual)
    }

    /// Returns the weighted root mean square of the residual, in units of s.
    pub(super) fn misfit(&self, estimate: &BlurPair) -> f64 {
        let samples = self.plate.par_iter().zip(&estimate.blurred);
        let residual: Vec<f32> = samples
            .zip(self.weights)
            .map(|((b, blurred), weight)| (b - blurred) * weight.sqrt())
            .collect();
        let count: f64 = self.weights.iter().map(|weight| f64::from(*weight)).sum();
        (dot(&residual, &residual) / count.max(1.0)).sqrt() / self.deviation
    }

    /// Returns `gain` W (b - A x) on the canvas.
    pub(super) fn weighted_residual(&self, estimate: &BlurPair, gain: f32) -> Vec<f32> {
        let samples = self.plate.par_iter().zip(&estimate.blurred);
        samples
            .zip(self.weights)
            .map(|((b, blurred), weight)| weight * (b - blurred) * gain)
            .collect()
    }

    /// Returns `image` with its blurred version.
    pub(super) fn blur(&self, image: Vec<f32>, accuracy: Accuracy) -> Result<BlurPair> {
        Ok(BlurPair {
            blurred: self.operator.apply(&image, accuracy)?,
            image,
        })
    }

    /// Returns the root mean square gradient of the plate without its noise.
    fn plate_gradient(&self) -> f64 {
        let gradients = WinsorisedStatistics::new(sampled_norms(self.plate, self.width()));
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

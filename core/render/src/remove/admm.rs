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
//! The start is a Wiener filter on local spectra, or the plate itself where depth varies. ADMM sets the gradient apart as
//! z = D x, with a scaled multiplier u and a penalty r. Each iteration
//!
//! 1. shortens D x + u by l / r at each pixel, which gives z, and sets u to the rest;
//! 2. lowers Q(x) = |W^(1/2) (A x - b)|² / (2 s²) + r |D x - z + u|² / 2 by one exact line search over the plane of two
//!    directions: the preconditioned negative gradient of Q, and the previous step. On one fixed quadratic this is the
//!    method of conjugate gradients.
//!
//! The weights l and r follow the mean gradient of the estimate. Two things differ from the textbook. The multiplier u is
//! not scaled when r changes. And a larger residual takes the place of s at first, which falls from one iteration to the
//! next (`schedule`), because fitting the plate at once makes the image ring.

use super::canvas::Canvas;
use super::gradient::{Gradient, LinkedPlane, sampled_norms, white_noise_power};
use super::lens_operator::LensOperator;
use super::local_mean::average_locally;
use super::plug_and_play::refine;
use super::quadratic::Quadratic;
use super::ramp;
use super::schedule::{ITERATIONS_SHARE, Schedule};
use super::vectors::{add_scaled, dot};
use super::winsorised::WinsorisedStatistics;
use crate::cancelled;
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::Progress;
use seidel_optics::error::Result;

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
/// Ratio of the residual to the noise up to which the estimate explains the plate.
const EXPLAINED_MISFIT: f64 = 1.03;
/// Ratio of a residual to that of the iteration before from which the estimate no longer approaches the plate.
const STALLED_SHARE: f64 = 0.9;
/// Change of l in an iteration that does not approach a plate that is not explained yet, and the least l times the mean gradient.
const UNDERFIT_SHRINKAGE: f64 = 0.7;
const MIN_WEIGHT: f64 = 0.1;
/// Iteration from which samples that nothing explains lose weight, where depth varies.
const OUTLIERS_FROM: usize = 8;
/// Residual at which the weight of a sample is halved, in standard deviations.
const OUTLIER: f32 = 3.0;
/// Standard deviation of a normal deviate over the median of its absolute value.
const MEDIAN_TO_DEVIATION: f32 = 1.4826;
/// Root mean square residual that noise explains, in standard deviations.
const UNEXPLAINED: f64 = 2.0;
/// Powers of the residual beyond that, in those of the plate as its own sharp image, at which the image begins to turn into the plate
/// and is the plate alone.
const POORER: [f32; 2] = [0.5, 1.0];
/// Iterations after which the blurred estimate is computed anew.
const REFRESH: usize = 5;

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
pub(super) fn solve(problem: &mut Problem, progress: &Progress) -> Result<Solution> {
    let operator = problem.operator;
    let data_weight = problem.deviation.powi(-2);
    let plate_gradient = problem.plate_gradient();
    let schedule = Schedule::of(problem, plate_gradient);
    let start = if operator.is_flat() {
        operator.image(wiener_estimate(problem, schedule.start_noise)?)
    } else {
        operator.image(problem.plate.to_vec())
    };
    let mut estimate = problem.blur(start)?;
    let stacked = operator.stack(&estimate.image);
    let mut multiplier = Gradient::zeros(stacked.len(), problem.width());
    let mut previous: Option<BlurPair> = None;
    let [least_gradient, mut most_gradient] =
        schedule.gradients.map(|bound| bound * plate_gradient);
    let mut weight = schedule.weight;
    let mut scheduled = schedule.start * plate_gradient / problem.deviation;
    let mut previous_misfit = f64::INFINITY;
    let mut largest_misfit = 0.0_f64;
    let mut settled = 0;
    let mut quadratic = Quadratic {
        data_weight,
        penalty: 0.0,
    };
    let certain = problem.weights.clone();
    for iteration in 0..schedule.limit {
        if !progress(schedule.share * iteration as f64 / schedule.limit as f64) {
            return Err(cancelled());
        }
        if iteration >= OUTLIERS_FROM && operator.has_edges() {
            problem.weights = problem.without_outliers(&estimate, &certain);
        }
        let misfit = problem.misfit(&estimate);
        if iteration > 0 {
            let ratio = misfit * problem.deviation / (OVERFIT_RATIO * problem.least_noise);
            let stalls = misfit > STALLED_SHARE * previous_misfit && scheduled <= misfit;
            if scheduled <= 1.0 {
                weight = (weight * ratio.powi(-4).clamp(1.0, MAX_WEIGHT_GROWTH)).min(MAX_WEIGHT);
                settled += 1;
            }
            if stalls && misfit > EXPLAINED_MISFIT && !operator.has_edges() {
                weight = (weight * UNDERFIT_SHRINKAGE).max(MIN_WEIGHT);
            }
            let is_fitted = ratio >= 1.0 || weight >= MAX_WEIGHT;
            let is_explained = is_fitted && misfit <= EXPLAINED_MISFIT;
            if iteration >= problem.iterations
                && settled >= schedule.settled
                && (is_explained || stalls && (weight <= MIN_WEIGHT || operator.has_edges()))
            {
                break;
            }
        }
        previous_misfit = misfit;
        let stacked = operator.stack(&estimate.image);
        let front = &stacked[..problem.plate.len()];
        let gradients = WinsorisedStatistics::new(sampled_norms(operator.linked(front)));
        let mean_gradient = gradients.mean.clamp(least_gradient, most_gradient);
        if mean_gradient == 0.0 {
            break;
        }
        if problem.refinement == Refinement::Skip {
            // Ringing has gradients of its own.
            most_gradient = mean_gradient;
        }
        quadratic.penalty = weight / (THRESHOLD * mean_gradient * mean_gradient);
        let threshold = (THRESHOLD * mean_gradient) as f32;
        let pull = multiplier.update_multiplier(operator.linked(&stacked), threshold);
        largest_misfit = largest_misfit.max(misfit);
        let residual = (scheduled.max(schedule.residual_share * misfit))
            .max(schedule.largest_share * largest_misfit)
            .max(1.0);
        scheduled *= schedule.decay;
        quadratic.data_weight = data_weight / residual.powi(2);
        let descent = quadratic.descent(problem, &estimate, &pull)?;
        let direction = quadratic.precondition(problem, &descent)?;
        let direction = problem.blur(direction)?;
        let step = quadratic.line_search(problem, &descent, direction, previous.take());
        estimate.add_scaled(&step, 1.0);
        previous = Some(step);
        if (iteration + 1) % REFRESH == 0 {
            // Rounding has added up.
            estimate = problem.blur(estimate.image)?;
        }
    }
    estimate = problem.blur(estimate.image)?;
    if schedule.is_refined {
        let residual = problem.weighted_residual(&estimate, 1.0);
        let front = problem.front(&estimate);
        let mut corrected = operator.texture_correction(front, &residual, problem.deviation)?;
        add_scaled(&mut corrected, front, 1.0);
        estimate = problem.blur_with_front(&estimate, corrected)?;
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
fn wiener_estimate(problem: &Problem, least_noise: f64) -> Result<Vec<f32>> {
    let width = problem.width();
    let noise = problem
        .deviation
        .max(least_noise * problem.plate_gradient());
    let mean_square_gradient = |image: &[f32]| {
        let image = LinkedPlane::plain(image, width);
        WinsorisedStatistics::new(sampled_norms(image))
            .root_mean_square
            .powi(2)
    };
    // A guess to begin with: blur has lowered the gradients of the plate, and noise has raised them.
    let mut strength = 2.0 * mean_square_gradient(problem.plate);
    let least = MIN_STRENGTH * noise * noise;
    let mut estimate = problem.plate.to_vec();
    for _ in 0..STRENGTH_PASSES {
        let damping = (2.0 * noise * noise / strength.max(least)) as f32;
        let wiener = |h: Complex<f32>, gradient_power: f32| {
            h.conj() / (h.norm_sqr() + damping * gradient_power)
        };
        estimate = (problem.operator).filter(problem.plate, wiener)?;
        strength = mean_square_gradient(&estimate);
    }
    if problem.refinement == Refinement::Run {
        let weights = problem.canvas.crop(&problem.weights);
        let known = problem.canvas.embed(true, |k| weights[k] > 0.0);
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
    /// blurred image, so that the filter makes it ring, and the iterations are too few to remove that.
    fn return_to_plate(&self, start: &mut [f32], known: &[bool]) -> Result<()> {
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

    /// Returns the weights `certain`, lowered where the residual of `estimate` is larger than noise: where the depth pass is wrong by
    /// parts of a pixel, or a third surface lies behind the second (Cauchy weights, with the median as the scale).
    fn without_outliers(&self, estimate: &BlurPair, certain: &[f32]) -> Vec<f32> {
        let residual = |k: usize| (self.plate[k] - estimate.blurred[k]).abs();
        let known = (0..certain.len()).filter(|k| certain[*k] > 0.0);
        let mut residuals: Vec<f32> = known.map(residual).collect();
        if residuals.is_empty() {
            return certain.to_vec();
        }
        let middle = residuals.len() / 2;
        let (_, median, _) = residuals.select_nth_unstable_by(middle, f32::total_cmp);
        let scale = (MEDIAN_TO_DEVIATION * *median).max(self.deviation as f32) * OUTLIER;
        let weight = |k: usize| certain[k] / (1.0 + (residual(k) / scale).powi(2));
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
    fn plate_gradient(&self) -> f64 {
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

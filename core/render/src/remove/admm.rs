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
//! The start is a Wiener filter on local spectra, or the plate itself where depth varies or where that explains the plate
//! better. ADMM sets the gradient apart as z = D x, with a scaled multiplier u and a penalty r. Each iteration
//!
//! 1. shortens D x + u by l / r at each pixel, which gives z, and sets u to the rest;
//! 2. lowers Q(x) = |W^(1/2) (A x - b)|² / (2 s²) + r |D x - z + u|² / 2 by one exact line search over the plane of two
//!    directions: the preconditioned negative gradient of Q, and the previous step. On one fixed quadratic this is the
//!    method of conjugate gradients.
//!
//! The weights l and r follow the mean gradient of the estimate. Two things differ from the textbook. The multiplier u is
//! not scaled when r changes. And a larger residual takes the place of s at first, which falls from one iteration to the
//! next (`schedule`), because fitting the plate at once makes the image ring.

use super::gradient::{Gradient, LinkedPlane, sampled_norms};
use super::plug_and_play::refine;
use super::problem::{BlurPair, Problem, Refinement};
use super::quadratic::Quadratic;
use super::schedule::{ITERATIONS_SHARE, Schedule};
use super::vectors::add_scaled;
use super::winsorised::WinsorisedStatistics;
use crate::cancelled;
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
/// Iterations after which the blurred estimate is computed anew.
const REFRESH: usize = 5;

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
    let mut estimate = problem.blur(operator.image(problem.plate.to_vec()))?;
    if operator.is_flat() {
        let filtered = operator.image(wiener_estimate(problem, schedule.start_noise)?);
        let filtered = problem.blur(filtered)?;
        // Kernels as wide as the tiles leave the filter nothing but their windows, from which no iteration returns.
        if problem.misfit(&filtered) < problem.misfit(&estimate) {
            estimate = filtered;
        }
    }
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

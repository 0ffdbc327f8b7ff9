//! A prior of patches for the last steps of a deconvolution: plug-and-play half-quadratic splitting with BM3D.
//!
//! The sharp image x of a plate b, and a denoised image v close to it, minimise in turn
//!
//! ```text
//! |A x - b|² / (2 s²) + |x - v|² / (2 q² s²)
//! ```
//!
//! over x, and a prior of patches over v. The first minimum is x = v + g F(b - A v). F is a Wiener filter of local spectra,
//! h* / (|h|² + 1 / q²), with h the transfer function. The second removes noise of the
//! standard deviation q s from x by collaborative filtering, with v as the pilot (`collaborative_filter`). Total variation
//! knows the gradients at a pixel alone; this prior keeps what similar patches have in common.
//!
//! The strength g is below one where the residual holds nothing of the image: where the image has no detail, so that low
//! frequencies of the noise would return, and where noise does not explain the residual, so that errors of the lens would
//! ring.
//!
//! S. Venkatakrishnan, C. Bouman and B. Wohlberg, "Plug-and-play priors for model based reconstruction", GlobalSIP 2013;
//! A. Danielyan, V. Katkovnik and K. Egiazarian, "BM3D frames and variational image deblurring", IEEE Transactions on
//! Image Processing 21 (2012).

use super::block_matching::PatchGroups;
use super::collaborative_filter::collaborative_filter;
use super::gradient::{LinkedPlane, norms};
use super::local_mean::average_locally;
use super::problem::{BlurPair, Problem};
use super::ramp;
use super::texture::EXPLAINED_RESIDUAL;
use crate::cancelled;
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// q in each round: the noise that is removed, in standard deviations of the plate's. Chosen on the photographs of
/// docs/background/figures.md. With 5, 4 and 3, brick gains 0.06 dB and chelsea loses 0.04 dB.
const DEVIATIONS: [f64; 3] = [4.0, 3.0, 3.0];
/// q of the step over x that follows the last round, so that the result reproduces the plate.
const LAST_DEVIATION: f64 = 1.0;
/// Root mean square gradients between which g rises from 0 to 1, in standard deviations of the noise. From 0 on, the noise
/// of flat areas is up to four times as large.
const DETAIL_GRADIENT: [f32; 2] = [1.0, 3.0];

/// Largest residual and gradient that counts, in standard deviations of the noise, so that local sums stay exact.
const LARGEST: f32 = 1e3;

/// Improves the `estimate` of a solved `problem`. `progress` gets the share done.
///
/// # Errors
/// Those of the lens operator, and cancellation by `progress`.
pub(super) fn refine(
    problem: &Problem,
    mut estimate: BlurPair,
    progress: &Progress,
) -> Result<BlurPair> {
    let Some(groups) = PatchGroups::find(problem.front(&estimate), problem.width()) else {
        return Ok(estimate);
    };
    let strengths = strengths(problem, &estimate);
    for (round, deviation) in DEVIATIONS.into_iter().enumerate() {
        if !progress(round as f64 / DEVIATIONS.len() as f64) {
            return Err(cancelled());
        }
        let noisy = fitted_image(problem, &estimate, &strengths, deviation)?;
        let noise = (deviation * problem.deviation) as f32;
        let front = problem.front(&estimate);
        let image = collaborative_filter(&noisy, front, &groups, noise);
        estimate = problem.blur_with_front(&estimate, image)?;
    }
    let image = fitted_image(problem, &estimate, &strengths, LAST_DEVIATION)?;
    problem.blur_with_front(&estimate, image)
}

/// Returns x for v = `estimate` and q = `deviation`.
fn fitted_image(
    problem: &Problem,
    estimate: &BlurPair,
    strengths: &[f32],
    deviation: f64,
) -> Result<Vec<f32>> {
    let residual = problem.weighted_residual(estimate, 1.0);
    let damping = deviation.powi(-2) as f32;
    let wiener = |h: Complex<f32>, _| h.conj() / (h.norm_sqr() + damping);
    let mut image = problem.operator.filter(&residual, wiener)?;
    let samples = image
        .par_iter_mut()
        .zip(problem.front(estimate))
        .zip(strengths);
    samples.for_each(|((sample, v), strength)| *sample = v + strength * *sample);
    Ok(image)
}

/// Returns g at each pixel of the canvas.
fn strengths(problem: &Problem, estimate: &BlurPair) -> Vec<f32> {
    let root_mean_squares = |mut plane: Vec<f32>| {
        let deviation = (problem.deviation as f32).max(f32::MIN_POSITIVE);
        plane.par_iter_mut().for_each(|v| {
            *v = (*v / deviation).clamp(-LARGEST, LARGEST).powi(2);
        });
        average_locally(&mut plane, problem.width());
        // Rounding may leave less than zero.
        plane.par_iter_mut().for_each(|v| *v = v.max(0.0).sqrt());
        plane
    };
    let residuals = root_mean_squares(problem.weighted_residual(estimate, 1.0));
    let gradients = root_mean_squares(norms(LinkedPlane::plain(
        problem.front(estimate),
        problem.width(),
    )));
    let pixels = residuals.par_iter().zip(&gradients);
    pixels
        .map(|(residual, gradient)| {
            ramp(*residual, EXPLAINED_RESIDUAL) * ramp(*gradient, DETAIL_GRADIENT)
        })
        .collect()
}

//! The course of a deconvolution: the residual that counts as noise in each iteration, and the number of iterations.
//!
//! At the start much more than the noise counts as noise, and the share falls with each iteration (a continuation, or homotopy). The
//! prior shapes the image first: large structures come before small ones, and ringing is not fitted. The values were chosen on the plate
//! `character` and on the depth scenes of docs/background/figures.md.

use super::problem::{Problem, Refinement};

/// l times the mean gradient at the start where the prior of patches follows: that removes the noise that is left, but cannot restore
/// what total variation has flattened.
const WEIGHT_BEFORE_PATCHES: f64 = 0.05;
/// The same where it does not follow, which is what gradients with a Laplacian distribution ask for.
const WEIGHT: f64 = 1.0;
/// The same where depth varies.
const WEIGHT_IN_DEPTH: f64 = 0.3;
/// Least noise of a plate whose image is refined in the end, in mean gradients of the plate.
const REFINED_NOISE: f64 = 0.01;
/// Share of the progress that the iterations take where a refinement follows them.
pub(super) const ITERATIONS_SHARE: f64 = 0.6;
/// Largest number of iterations, in least numbers: a plate without noise takes the longest to explain.
const MAX_ITERATIONS_RATIO: usize = 4;

/// The course of a deconvolution.
pub(super) struct Schedule {
    /// Whether the correction of texture and the prior of patches follow the iterations.
    pub(super) is_refined: bool,
    /// l times the mean gradient at the start.
    pub(super) weight: f64,
    /// The residual that counts as noise at the start, in mean gradients of the plate.
    pub(super) start: f64,
    /// Least noise for which the start is filtered, in mean gradients of the plate: less would amplify what the windows of the tiles
    /// cut off.
    pub(super) start_noise: f64,
    /// Its decay in an iteration.
    pub(super) decay: f64,
    /// Share of the present residual that counts as noise at least.
    pub(super) residual_share: f64,
    /// Share of the largest residual so far that counts as noise at least: few iterations cannot fit more without ringing.
    pub(super) largest_share: f64,
    /// Bounds of the image's mean gradient, as multiples of the plate's.
    pub(super) gradients: [f64; 2],
    /// Least number of iterations at the noise itself.
    pub(super) settled: usize,
    /// Largest number of iterations.
    pub(super) limit: usize,
    /// Share of the progress.
    pub(super) share: f64,
}

impl Schedule {
    /// Returns the schedule of `problem`, whose plate has this root mean square gradient.
    pub(super) fn of(problem: &Problem, plate_gradient: f64) -> Self {
        // Without noise there is none to remove, and the prior has determined next to nothing.
        let is_noisy = problem.deviation > REFINED_NOISE * plate_gradient;
        let is_refined = problem.refinement == Refinement::Run && is_noisy;
        let flat = Self {
            is_refined,
            weight: if is_refined {
                WEIGHT_BEFORE_PATCHES
            } else {
                WEIGHT
            },
            start: 1.5,
            start_noise: 0.5,
            decay: 0.8,
            residual_share: 0.8,
            largest_share: 0.0,
            gradients: [0.5, 3.0],
            settled: 6,
            limit: MAX_ITERATIONS_RATIO * problem.iterations,
            share: ITERATIONS_SHARE,
        };
        match problem.refinement {
            Refinement::Run if problem.operator.is_flat() => flat,
            Refinement::Run => Self {
                weight: WEIGHT_IN_DEPTH,
                start: 3.0,
                decay: 0.75,
                residual_share: 1.0,
                ..flat
            },
            Refinement::Skip => Self {
                weight: 0.15,
                start: 0.0,
                start_noise: 0.0,
                gradients: [0.0, 2.0],
                residual_share: 1.0,
                largest_share: 0.25,
                settled: 0,
                limit: problem.iterations,
                share: 1.0,
                ..flat
            },
        }
    }
}

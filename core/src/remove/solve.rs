//! One plane without its blur: the picture that fits the plate as well as its noise allows and has few slopes.
//!
//! Sought is the x with the least |A x - b|^2 / (2 s^2) + l sum |D x|, b being the plate, s its noise, A the lens and D
//! the differences of the prior. It begins with a Wiener filter by local spectra. Then the slopes z are set apart
//! (alternating directions: z shortened by l / r, its multiplier u summed up), and x goes to the least of
//! |A x - b|^2 / (2 s^2) + r |D x - z + u|^2 / 2 over two directions: the slope of that as the local spectra
//! would have it, and the step before.

use super::local::Local;
use super::prior::Slopes;
use crate::error::Result;
use crate::render::{Edges, Operator, stopped};
use rustfft::num_complex::Complex;

/// Weight l of slopes times the mean slope of the picture so far: of a picture whose slopes are spread as a
/// Laplacian it would be one; that pictures are smoother than their slopes tell was found on photographs.
const WEIGHT: f64 = 0.17;
/// By how much slopes are shortened, l / r, as a share of their mean.
const SHORTER: f64 = 3.0;
/// How often the strength of slopes is told from the picture found so far, before the rounds.
const TELLINGS: usize = 2;
/// Least mean square slope that the Wiener filter reckons with, in variances of the noise: below, it would damp what
/// the windows of its squares alone are made of.
const LEAST_STRENGTH: f64 = 20.0;
/// Least noise, as a share of the largest sample: less is below what operators are right to.
const LEAST_NOISE: f64 = 1e-4;

/// What is known of a plane.
pub(super) struct Task<'a> {
    pub(super) blurred: &'a [f32],
    pub(super) width: usize,
    /// Standard deviation of its noise.
    pub(super) noise: f64,
    pub(super) rounds: usize,
    pub(super) operator: &'a Operator,
    pub(super) local: &'a Local,
}

/// A picture, or a way to change one, and what the lens makes of it.
struct Seen {
    plane: Vec<f32>,
    blurred: Vec<f32>,
}

/// The quadratic of one round.
struct Bowl {
    /// 1 / s^2 and r.
    fit: f64,
    stiff: f64,
}

/// The plane without its blur.
///
/// # Errors
/// If `progress`, told the share done, says to stop.
pub(super) fn solve(task: &Task, progress: &dyn Fn(f64) -> bool) -> Result<Vec<f32>> {
    let Task { blurred, width, .. } = *task;
    let peak = blurred.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
    if peak == 0.0 {
        return Ok(blurred.to_vec());
    }
    let noise = task.noise.max(LEAST_NOISE * f64::from(peak));
    let fit = noise.powi(-2);
    let mut picture = task.seen(start(task, fit))?;
    let mut multiplier: Option<Slopes> = None;
    let mut last: Option<Seen> = None;
    for round in 0..task.rounds {
        if !progress(round as f64 / task.rounds as f64) {
            return Err(stopped());
        }
        let slopes = Slopes::of(&picture.plane, width);
        let scale = slopes.mean_length();
        if scale == 0.0 {
            break;
        }

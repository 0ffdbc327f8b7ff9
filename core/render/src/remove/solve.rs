//! One plane without its blur: the picture that fits the plate as well as its noise allows and has few slopes.
//!
//! Sought is the x with the least |A x - b|^2 / (2 s^2) + l sum |D x|, b being the plate, s its noise, A the lens and D
//! the differences of the prior. It begins with a Wiener filter by local spectra. Then the slopes z are set apart
//! (alternating directions: z shortened by l / r, its multiplier u summed up), and x goes to the least of
//! |A x - b|^2 / (2 s^2) + r |D x - z + u|^2 / 2 over two directions: the slope of that as the local spectra
//! would have it, and the step before.

use super::canvas::Canvas;
use super::prior::{Slopes, slope_lengths, slope_of_noise, slope_products};
use super::sums::{Typical, add, dot, weighted_products};
use super::trust::Trust;
use super::view::{Care, View};
use crate::cancelled;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use seidel_optics::error::Result;

/// Weight l of slopes times the mean slope of the picture so far: of a picture whose slopes are spread as a
/// Laplacian it would be one; that pictures are smoother than their slopes tell was found on photographs.
const WEIGHT: f64 = 0.15;
/// Most that the mean slope can be, in root mean square slopes of the plate, its noise apart: what is steeper at first is noise that
/// was made louder.
const STEEPEST: f64 = 2.0;
/// A picture that leaves less than this share of the noise unexplained follows noise: slopes then weigh more, up to so
/// many times more in a round, and so much in all.
const FOLLOWED: f64 = 0.94;
const HEAVIER: [f64; 2] = [4.0, 8.0];
/// By how much slopes are shortened, l / r, as a share of their mean.
const SHORTER: f64 = 1.5;
/// How often the strength of slopes is told from the picture found so far, before the rounds.
const TELLINGS: usize = 2;
/// Least mean square slope that the Wiener filter reckons with, in variances of the noise: below, it would damp what
/// the windows of its squares alone are made of.
const LEAST_STRENGTH: f64 = 20.0;
/// Share of what the local spectra's picture leaves unexplained that is never gone after: where a lens changes so much within
/// a square that they tell little, directions are poor, and a picture would ring long before it fits.
const STEEP: f64 = 0.25;

/// A plane on its canvas.
pub(super) struct Task<'a> {
    pub(super) blurred: &'a [f32],
    pub(super) canvas: Canvas,
    /// Which of the canvas's samples are the plate's own.
    pub(super) known: &'a [bool],
    /// Standard deviation of its noise.
    pub(super) noise: f64,
    /// How exactly operators and lenses are known, as a share of the light.
    pub(super) inexact: f64,
    pub(super) rounds: usize,
    /// Whether detail is told from noise by the picture's own spectra in the end.
    pub(super) detailed: bool,
    pub(super) view: &'a View,
}

/// A picture, or a way to change one, and what the lens makes of it.
pub(super) struct Seen {
    pub(super) plane: Vec<f32>,
    pub(super) blurred: Vec<f32>,
}

/// The quadratic of one round.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bowl {
    /// 1 / s^2 and r.
    fit: f64,
    stiff: f64,
}

/// The plane without its blur.
///
/// # Errors
/// If `progress`, told the share done, says to stop.
pub(super) fn solve(task: &Task, progress: &dyn Fn(f64) -> bool) -> Result<(Seen, Bowl)> {
    let width = task.canvas.size().0;
    let trust = task.trust();
    let weights = task.weights(&trust);
    let fit = trust.deviation().powi(-2);
    let mut picture = task.seen_well(start(task, fit)?)?;
    let mut multiplier = Slopes::none(task.blurred.len(), width);
    let mut last: Option<Seen> = None;
    let mut scale = STEEPEST * task.plate_slopes();
    let (mut weight, mut first_misfit) = (WEIGHT, 0.0_f64);
    let mut bowl = Bowl { fit, stiff: 0.0 };
    for round in 0..task.rounds {
        if !progress(round as f64 / task.rounds as f64) {
            return Err(cancelled());
        }
        // Ringing has slopes of its own, which must not be taken for the picture's.
        scale = Typical::of(slope_lengths(&picture.plane, width))
            .mean
            .min(scale);
        if scale == 0.0 {
            break;
        }
        let misfit = task.misfit(&picture, &weights) / trust.deviation();
        if round > 0 {
            let followed = misfit * trust.deviation() / (FOLLOWED * task.noise);
            weight = (weight * followed.powi(-4).clamp(1.0, HEAVIER[0])).min(HEAVIER[1]);
        }
        bowl.stiff = weight / (SHORTER * scale * scale);
        let pull = multiplier.turned(&picture.plane, (SHORTER * scale) as f32);
        // What the picture so far leaves unexplained counts as noise: to go after it at once would make it ring.
        first_misfit = first_misfit.max(misfit);
        let least = (STEEP * first_misfit).max(1.0);
        bowl.fit = fit / misfit.max(least).powi(2);
        let descent = task.descent(&bowl, &picture, &pull, &weights)?;
        let mut ways = vec![task.seen(task.eased(&bowl, &descent)?)?];
        ways.extend(last.take());
        let step = bowl.lowest(&descent, ways, &weights, width);
        picture.add(&step, 1.0);
        last = Some(step);
        if round + 1 == task.rounds / 2 {
            // What the quick operator gets wrong would be taken for the picture's.
            picture = task.seen_well(picture.plane)?;
        }
    }
    picture = task.seen_well(picture.plane)?;
    if task.detailed {
        let change = task.detail(&picture, &weights, trust.deviation())?;
        add(&mut picture.plane, &change, 1.0);
        picture = task.seen_well(picture.plane)?;
    }
    Ok((picture, bowl))
}

/// A Wiener filter by local spectra, slopes being as strong as those of what it gives.
fn start(task: &Task, fit: f64) -> Result<Vec<f32>> {
    let Task { blurred, .. } = *task;
    let width = task.canvas.size().0;
    let square = |plane: &[f32]| {
        let slopes = Typical::of(slope_lengths(plane, width));
        slopes.root_mean_square.powi(2)
    };
    // The blurred picture's are less steep, and noise has slopes of its own.
    let mut strength = 2.0 * square(blurred);
    let least = LEAST_STRENGTH / fit;
    let mut found = blurred.to_vec();
    for _ in 0..TELLINGS {
        let prior = (2.0 / (fit * strength.max(least))) as f32;
        found = task.view.filtered(blurred, |h, slope| {
            h.conj() / (h.norm_sqr() + prior * slope)
        })?;
        strength = square(&found);
    }
    Ok(found)
}

impl Task<'_> {
    fn trust(&self) -> Trust {
        Trust::new(self.blurred, self.noise, self.inexact)
    }

    /// Root mean square slope of the plate, its noise apart.
    fn plate_slopes(&self) -> f64 {
        let width = self.canvas.size().0;
        let typical = Typical::of(slope_lengths(self.blurred, width)).root_mean_square;
        let noise = self.noise * self.noise * slope_of_noise();
        // Slopes of noise are not told exactly.
        (typical * typical - noise).max(0.1 * noise).sqrt()
    }

    /// What `picture` does not explain of the plate, none where nothing is known, and the root of its mean square in standard deviations of what is not known.
    pub(super) fn rest(&self, picture: &Seen) -> (Vec<f32>, f64) {
        let trust = self.trust();
        let weights = self.weights(&trust);
        let both = self.blurred.par_iter().zip(&picture.blurred).zip(&weights);
        let rest: Vec<f32> = both
            .map(|((b, seen), weight)| if *weight > 0.0 { b - seen } else { 0.0 })
            .collect();
        let misfit = self.misfit(picture, &weights) / trust.deviation();
        (self.canvas.cropped(&rest), misfit)
    }

    /// Root of the weighted mean square of what `picture` does not explain.
    fn misfit(&self, picture: &Seen, weights: &[f32]) -> f64 {
        let both = self.blurred.par_iter().zip(&picture.blurred).zip(weights);
        let rest: Vec<f32> = both
            .map(|((b, seen), weight)| (b - seen) * weight.sqrt())
            .collect();
        let count: f64 = weights.iter().map(|weight| f64::from(*weight)).sum();
        (dot(&rest, &rest) / count.max(1.0)).sqrt()
    }

    /// By how much `picture` changes where its own spectra tell detail from noise.
    fn detail(&self, picture: &Seen, weights: &[f32], deviation: f64) -> Result<Vec<f32>> {
        let both = self.blurred.par_iter().zip(&picture.blurred).zip(weights);
        let rest: Vec<f32> = both
            .map(|((b, seen), weight)| weight * (b - seen))
            .collect();
        self.view.change(&picture.plane, &rest, deviation)
    }

    /// What the lens makes of `plane`, told more exactly.
    fn seen_well(&self, plane: Vec<f32>) -> Result<Seen> {
        Ok(Seen {
            blurred: self.view.blurred(&plane, Care::Exact)?,
            plane,
        })
    }

    fn seen(&self, plane: Vec<f32>) -> Result<Seen> {
        Ok(Seen {
            blurred: self.view.blurred(&plane, Care::Quick)?,
            plane,
        })
    }

    /// How much each pixel counts.
    fn weights(&self, trust: &Trust) -> Vec<f32> {
        let both = self.blurred.par_iter().zip(self.known);
        both.map(|(b, known)| if *known { trust.weight(*b) } else { 0.0 })
            .collect()
    }

    /// Against the slope of the bowl at `picture`: A^T W (b - A x) / s^2 + r D^T `pull`.
    fn descent(
        &self,
        bowl: &Bowl,
        picture: &Seen,
        pull: &Slopes,
        weights: &[f32],
    ) -> Result<Vec<f32>> {
        let both = self.blurred.par_iter().zip(&picture.blurred).zip(weights);
        let rest = both.map(|((b, seen), weight)| weight * (b - seen) * bowl.fit as f32);
        let mut descent = self.view.adjoint(rest.collect())?;
        add(&mut descent, &pull.gathered(), bowl.stiff as f32);
        Ok(descent)
    }

    /// The way to the bottom if the lens's blur were as local spectra have it.
    fn eased(&self, bowl: &Bowl, descent: &[f32]) -> Result<Vec<f32>> {
        let (fit, stiff) = (bowl.fit as f32, bowl.stiff as f32);
        self.view.eased(descent, |h, slope| {
            Complex::new((h.norm_sqr() * fit + stiff * slope).recip(), 0.0)
        })
    }
}

impl Bowl {
    /// The share of a wave that is told by the plate and not by the prior, from the lens's transfer function and |D|^2.
    pub(super) fn told(&self, h: Complex<f32>, slope: f32) -> f32 {
        let fit = h.norm_sqr() * self.fit as f32;
        let all = fit + self.stiff as f32 * slope;
        if all > 0.0 { fit / all } else { 1.0 }
    }

    /// The step along `ways`, one or two, to the lowest point that they reach.
    fn lowest(&self, descent: &[f32], mut ways: Vec<Seen>, weights: &[f32], width: usize) -> Seen {
        let last = ways.split_off(1).pop();
        let mut way = ways.swap_remove(0);
        // <W A v, A v> / s^2 + r <D v, D v> of the ways, and of one with the other.
        let other = last.as_ref().unwrap_or(&way);
        let seen = weighted_products(&way.blurred, &other.blurred, weights);
        let slopes = slope_products(&way.plane, &other.plane, width);
        let curve = |k: usize| self.fit * seen[k] + self.stiff * slopes[k];
        let [a, b, c] = [curve(0), curve(1), curve(2)];
        let p = dot(descent, &way.plane);
        let alone = if a > 0.0 { p / a } else { 0.0 };
        let Some(last) = last else {
            way.scale(alone);
            return way;
        };
        let q = dot(descent, &last.plane);
        let determinant = a * c - b * b;
        if determinant > 1e-9 * a * c {
            way.scale((p * c - q * b) / determinant);
            way.add(&last, (q * a - p * b) / determinant);
        } else {
            way.scale(alone);
        }
        way
    }
}

impl Seen {
    fn add(&mut self, other: &Self, gain: f64) {
        add(&mut self.plane, &other.plane, gain as f32);
        add(&mut self.blurred, &other.blurred, gain as f32);
    }

    fn scale(&mut self, gain: f64) {
        for plane in [&mut self.plane, &mut self.blurred] {
            plane
                .par_iter_mut()
                .for_each(|sample| *sample *= gain as f32);
        }
    }
}

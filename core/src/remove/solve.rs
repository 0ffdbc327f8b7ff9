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
use crate::render::{Operator, stopped};
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
        let bowl = Bowl {
            fit,
            stiff: WEIGHT / (SHORTER * scale * scale),
        };
        let pulled = match &multiplier {
            Some(multiplier) => slopes.plus(multiplier, 1.0),
            None => slopes.clone(),
        };
        let apart = pulled.shortened((SHORTER * scale) as f32);
        let next = pulled.plus(&apart, -1.0);
        // z - u - D x.
        let pull = apart.plus(&next, -1.0).plus(&slopes, -1.0);
        let descent = task.descent(&bowl, &picture, &pull)?;
        let mut ways = vec![task.seen(task.eased(&bowl, &descent))?];
        ways.extend(last.take());
        let step = bowl.lowest(&descent, &ways, width);
        picture.add(&step);
        last = Some(step);
        multiplier = Some(next);
    }
    Ok(picture.plane)
}

/// A Wiener filter by local spectra, slopes being as strong as those of what it gives.
fn start(task: &Task, fit: f64) -> Vec<f32> {
    let Task { blurred, width, .. } = *task;
    let count = blurred.len() as f64;
    let square = |slopes: Slopes| slopes.dot(&slopes) / count;
    // The blurred picture's are less steep, and noise has slopes of its own.
    let mut strength = 2.0 * square(Slopes::of(blurred, width));
    let least = LEAST_STRENGTH / fit;
    let mut found = blurred.to_vec();
    for _ in 0..TELLINGS {
        let prior = (2.0 / (fit * strength.max(least))) as f32;
        found = task.local.filtered(blurred, false, |h, slope| {
            h.conj() / (h.norm_sqr() + prior * slope)
        });
        strength = square(Slopes::of(&found, width));
    }
    found
}

impl Task<'_> {
    fn seen(&self, plane: Vec<f32>) -> Result<Seen> {
        let mut planes = vec![plane];
        let mut blurred = self.operator.apply(&planes)?;
        Ok(Seen {
            blurred: blurred.swap_remove(0),
            plane: planes.swap_remove(0),
        })
    }

    /// Against the slope of the bowl at `picture`: A^T (b - A x) / s^2 + r D^T `pull`.
    fn descent(&self, bowl: &Bowl, picture: &Seen, pull: &Slopes) -> Result<Vec<f32>> {
        let rest = self.blurred.iter().zip(&picture.blurred);
        let rest = rest.map(|(b, seen)| (f64::from(b - seen) * bowl.fit) as f32);
        let mut descent = self.operator.adjoint(&[rest.collect()])?.swap_remove(0);
        for (out, pull) in descent.iter_mut().zip(pull.gathered(self.width)) {
            *out += bowl.stiff as f32 * pull;
        }
        Ok(descent)
    }

    /// The way to the bottom if the lens's blur were as local spectra have it.
    fn eased(&self, bowl: &Bowl, descent: &[f32]) -> Vec<f32> {
        let (fit, stiff) = (bowl.fit as f32, bowl.stiff as f32);
        // Were it not folded it would not be symmetric, and rounds would come to a stop.
        self.local.filtered(descent, true, |h, slope| {
            Complex::new((h.norm_sqr() * fit + stiff * slope).recip(), 0.0)
        })
    }
}

impl Bowl {
    /// The step along `ways`, one or two, to the lowest point that they reach.
    fn lowest(&self, descent: &[f32], ways: &[Seen], width: usize) -> Seen {
        let slopes: Vec<Slopes> = ways.iter().map(|w| Slopes::of(&w.plane, width)).collect();
        let curve = |i: usize, j: usize| {
            self.fit * dot(&ways[i].blurred, &ways[j].blurred)
                + self.stiff * slopes[i].dot(&slopes[j])
        };
        let along = |i: usize| dot(descent, &ways[i].plane);
        let (a, p) = (curve(0, 0), along(0));
        let alone = [if a > 0.0 { p / a } else { 0.0 }, 0.0];
        let gains = if ways.len() == 2 {
            let (b, c, q) = (curve(0, 1), curve(1, 1), along(1));
            let determinant = a * c - b * b;
            if determinant > 1e-9 * a * c {
                [(p * c - q * b) / determinant, (q * a - p * b) / determinant]
            } else {
                alone
            }
        } else {
            alone
        };
        let join = |of: fn(&Seen) -> &[f32]| {
            let mut sum = vec![0.0; descent.len()];
            for (way, gain) in ways.iter().zip(gains) {
                add(&mut sum, of(way), gain as f32);
            }
            sum
        };
        Seen {
            plane: join(|way| &way.plane),
            blurred: join(|way| &way.blurred),
        }
    }
}

impl Seen {
    fn add(&mut self, other: &Self) {
        add(&mut self.plane, &other.plane, 1.0);
        add(&mut self.blurred, &other.blurred, 1.0);
    }
}

fn add(out: &mut [f32], other: &[f32], gain: f32) {
    for (out, other) in out.iter_mut().zip(other) {
        *out += gain * other;
    }
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

//! A direction that the blur of the whole frame shares: motion of the camera, or a squeezed picture. A lens that is symmetric about
//! its axis has none.

use seidel_optics::numeric::median;

use super::{Concern, Severity};
use crate::photograph::Photograph;
use crate::robust_fit::linear_fit;

/// Variance of that direction, over the variance along both axes, from which on the lens is less exact, and from which on useless.
const MIN_SHARE: f64 = 0.015;
const MAX_SHARE: f64 = 0.05;
/// Multiple of its own error from which on the direction is beyond doubt.
const MIN_SIGMAS: f64 = 6.0;

/// Second moments of the blur at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    /// Frame position, px.
    pub at: [f64; 2],
    /// Covariance xx, xy, yy, px².
    pub covariance: [f64; 3],
}

/// The constant part of (xx - yy, 2 xy) in one channel, its error, and the mean variance.
struct Direction {
    value: [f64; 2],
    sigma: f64,
    variance: f64,
}

fn direction(photo: &Photograph, blurs: &[Blur]) -> Option<Direction> {
    let half = photo.width as f64 / 2.0;
    let (mut rows, mut values, mut variances) = (Vec::new(), Vec::new(), Vec::new());
    for blur in blurs {
        let [xx, xy, yy] = blur.covariance;
        let x = blur.at[0] / half - 1.0;
        let y = (blur.at[1] - photo.height as f64 / 2.0) / half;
        // Complex powers of the place, z, z² and |z|² z²: coma and astigmatism about an axis near the middle.
        let (re, im, r2) = (x * x - y * y, 2.0 * x * y, x * x + y * y);
        rows.push(vec![1.0, 0.0, x, -y, re, -im, r2 * re, -r2 * im]);
        values.push(xx - yy);
        rows.push(vec![0.0, 1.0, y, x, im, re, r2 * im, r2 * re]);
        values.push(2.0 * xy);
        variances.push((xx + yy) / 2.0);
    }
    let fit = linear_fit(&rows, &values)?;
    Some(Direction {
        value: [fit.coefficients[0], fit.coefficients[1]],
        sigma: fit.sigmas[0].max(fit.sigmas[1]),
        variance: median(&mut variances),
    })
}

/// Returns whether all `things` of `photo` are longer along one direction of the frame, from their `blurs` by channel.
pub fn check(photo: &Photograph, things: &str, blurs: &[Vec<Blur>]) -> Option<Concern> {
    let all: Vec<Direction> = blurs.iter().filter_map(|b| direction(photo, b)).collect();
    let weight: f64 = all.iter().map(|d| d.sigma.powi(-2)).sum();
    let mean = [0, 1].map(|k| {
        let weighted = all.iter().map(|d| d.value[k] / (d.sigma * d.sigma));
        weighted.sum::<f64>() / weight
    });
    let variance = all.iter().map(|d| d.variance).sum::<f64>() / all.len().max(1) as f64;
    let length = mean[0].hypot(mean[1]);
    let share = length / (2.0 * variance);
    if all.is_empty() || share < MIN_SHARE || length * weight.sqrt() < MIN_SIGMAS {
        return None;
    }
    let angle = (mean[1].atan2(mean[0]) / 2.0).to_degrees();
    let severity = if share > MAX_SHARE {
        Severity::Refuse
    } else {
        Severity::Widen(share)
    };
    Some(Concern::new(
        severity,
        &photo.name,
        format!(
            "shows motion or a squeezed picture: all {things} are longer along {angle:.0}° from the right towards the bottom, by a variance of {length:.2} px², that of a motion of {:.1} px",
            (12.0 * length).sqrt()
        ),
        "photograph again from a tripod with a self-timer; give a squeezed picture as the sensor recorded it",
    ))
}

//! Least-squares fit of an edge to the raw pixels of one channel: its line, its levels, its light and its width.
//!
//! The model is a step blurred by a Gaussian, along a parabola, in light that changes linearly:
//!
//!   v(s, t) = (dark + step Phi((t - c0 - c1 s - c2 s²) / sigma)) (1 + g_t t + g_s s)
//!
//! The blur of a lens is no Gaussian. What differs is a function of t alone, so that slope and curvature of the line are not
//! biased by it.

use nalgebra::{SMatrix, SVector};

use seidel_optics::numeric::{StandardNormal, scatter};

use super::damped_steps::{Limits, minimise};

/// Unknowns: dark, step, g_t, g_s, c0, c1, c2, sigma.
const UNKNOWNS: usize = 8;
const LIMITS: Limits = Limits {
    iterations: 40,
    tries: 8,
    min_gain: 1e-7,
};
/// Residuals beyond which a pixel is defective, in scatters of all residuals.
const OUTLIER_SCATTERS: f64 = 6.0;
/// Share of defective pixels above which it is not pixels that are wrong.
pub(super) const MAX_OUTLIERS: f64 = 0.04;
/// Pixels that a fit needs.
pub(super) const MIN_PIXELS: usize = 40;
/// Least standard deviation of the width, px.
const LEAST_SIGMA: f64 = 0.15;

/// A pixel about an edge: its place along the line and its normal, px, and its counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgePixel {
    pub(super) s: f64,
    pub(super) t: f64,
    pub(super) value: f64,
}

/// The fitted edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LineFit {
    pub(super) dark: f64,
    pub(super) step: f64,
    /// Relative gradient of the light along the normal and along the line, 1/px.
    pub(super) light: [f64; 2],
    /// Offset, slope and curvature of the line: t = c0 + c1 s + c2 s².
    pub(super) line: [f64; 3],
    /// Standard deviation of the Gaussian, px.
    pub(super) sigma: f64,
    /// Scatter of the residuals, counts.
    pub(super) scatter: f64,
}

impl LineFit {
    /// Returns the distance of a pixel from the line along its normal, px.
    pub(super) fn distance(&self, pixel: &EdgePixel) -> f64 {
        let [c0, c1, c2] = self.line;
        let s = pixel.s;
        (pixel.t - c0 - (c1 + c2 * s) * s) / (c1 + 2.0 * c2 * s).hypot(1.0)
    }

    /// Returns the light at a pixel relative to that at the middle of the edge.
    pub(super) fn light_at(&self, pixel: &EdgePixel) -> f64 {
        1.0 + self.light[0] * pixel.t + self.light[1] * pixel.s
    }

    /// Returns the value of the model at a pixel.
    pub(super) fn value(&self, pixel: &EdgePixel) -> f64 {
        self.terms(pixel).0
    }

    /// Returns the model value and its derivatives.
    fn terms(&self, pixel: &EdgePixel) -> (f64, SVector<f64, UNKNOWNS>) {
        let (s, t) = (pixel.s, pixel.t);
        let [c0, c1, c2] = self.line;
        let z = (t - c0 - (c1 + c2 * s) * s) / self.sigma;
        let StandardNormal {
            density,
            cumulative: phi,
        } = StandardNormal::at(z);
        let base = self.dark + self.step * phi;
        let light = self.light_at(pixel);
        let shift = -self.step * density / self.sigma * light;
        let derivatives = SVector::from([
            light,
            phi * light,
            base * t,
            base * s,
            shift,
            shift * s,
            shift * s * s,
            shift * z,
        ]);
        (base * light, derivatives)
    }

    fn moved(&self, step: &SVector<f64, UNKNOWNS>) -> Self {
        Self {
            dark: self.dark + step[0],
            step: self.step + step[1],
            light: [self.light[0] + step[2], self.light[1] + step[3]],
            line: [
                self.line[0] + step[4],
                self.line[1] + step[5],
                self.line[2] + step[6],
            ],
            sigma: (self.sigma + step[7])
                .clamp(LEAST_SIGMA.max(0.5 * self.sigma), 2.0 * self.sigma),
            scatter: self.scatter,
        }
    }
}

/// Fits an edge to `pixels`, starting at a width of `sigma`, and removes defective pixels from them. `None` where the pixels
/// do not determine it.
pub(super) fn fit(pixels: &mut Vec<EdgePixel>, sigma: f64) -> Option<LineFit> {
    let mean = |bright: bool| {
        let side = pixels
            .iter()
            .filter(|p| (p.t > sigma) == bright && p.t.abs() > sigma);
        let (sum, count) = side.fold((0.0, 0), |(sum, n), p| (sum + p.value, n + 1));
        (count > 0).then(|| sum / f64::from(count))
    };
    let (dark, bright) = (mean(false)?, mean(true)?);
    let mut fit = LineFit {
        dark,
        step: bright - dark,
        light: [0.0; 2],
        line: [0.0; 3],
        sigma,
        scatter: 0.0,
    };
    let before = pixels.len();
    for _ in 0..3 {
        if pixels.len() < MIN_PIXELS {
            return None;
        }
        fit = minimised(pixels, fit)?;
        let residuals: Vec<f64> = pixels.iter().map(|p| p.value - fit.value(p)).collect();
        fit.scatter = scatter(&residuals);
        // The Gaussian does not describe all blurs, so the limit is not below a share of the step.
        let limit = (OUTLIER_SCATTERS * fit.scatter).max(0.08 * fit.step.abs());
        let mut kept = residuals.iter().map(|r| r.abs() <= limit);
        let all = pixels.len();
        pixels.retain(|_| kept.next().unwrap_or(true));
        if pixels.len() == all {
            break;
        }
        if pixels.len() as f64 <= (1.0 - MAX_OUTLIERS) * before as f64 {
            return None;
        }
    }
    (fit.step.is_finite() && fit.sigma.is_finite()).then_some(fit)
}

fn minimised(pixels: &[EdgePixel], start: LineFit) -> Option<LineFit> {
    let cost = |fit: &LineFit| -> f64 {
        let squares = pixels.iter().map(|p| (p.value - fit.value(p)).powi(2));
        squares.sum()
    };
    let equations = |fit: &LineFit| {
        let mut normal = SMatrix::zeros();
        let mut right = SVector::zeros();
        for pixel in pixels {
            let (value, row) = fit.terms(pixel);
            normal += row * row.transpose();
            right += row * (pixel.value - value);
        }
        (normal, right)
    };
    minimise(start, cost, equations, LineFit::moved, LIMITS).map(|(fit, _)| fit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    #[test]
    fn line_levels_light_and_width_are_recovered_beside_a_defective_pixel() {
        let truth = LineFit {
            dark: 200.0,
            step: 3000.0,
            light: [0.002, -0.001],
            line: [0.3, 0.02, 0.0004],
            sigma: 1.7,
            scatter: 0.0,
        };
        let mut random = SplitMix64::new(3);
        let mut pixels: Vec<EdgePixel> = (0..400)
            .map(|_| {
                let mut pixel = EdgePixel {
                    s: 24.0 * random.unit() - 12.0,
                    t: 20.0 * random.unit() - 10.0,
                    value: 0.0,
                };
                pixel.value = truth.value(&pixel) + 10.0 * (random.unit() - 0.5);
                pixel
            })
            .collect();
        pixels[17].value += 4000.0;
        let fit = fit(&mut pixels, 1.2).expect("determined");
        assert_eq!(pixels.len(), 399);
        assert!((fit.sigma - 1.7).abs() < 0.01, "{fit:?}");
        assert!((fit.line[0] - 0.3).abs() < 0.01 && (fit.line[1] - 0.02).abs() < 1e-3);
        assert!((fit.line[2] - 4e-4).abs() < 1e-4 && (fit.light[0] - 0.002).abs() < 2e-4);
        assert!((fit.step - 3000.0).abs() < 8.0, "{fit:?}");
    }
}

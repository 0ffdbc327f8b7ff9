//! The profile of an edge across its line, and its moments: a Gauss-Hermite fit.
//!
//! The line spread function is a Gaussian times Hermite polynomials He_3 to He_6, so that the edge is
//!
//!   E(t) = Phi(z) - phi(z) (h3 He_2 + h4 He_3 + h5 He_4 + h6 He_5)(z),  z = (t - c) / sigma
//!
//! With no term of first or second order its centroid is c, its variance sigma² and its third moment 6 h3 sigma³, whatever the
//! higher terms are. Levels and the gradient of the light are fitted together with it: integrals of the profile would need
//! them beforehand, and multiply their errors by the square of the profile's length.

use nalgebra::{SMatrix, SVector};
use seidel_optics::edges::ProfileBin;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::numeric::StandardNormal;

use super::damped_steps::{Equations, Limits, minimise};
use super::line_fit::{EdgePixel, LineFit};

/// Width of a bin, px.
const BIN_PX: f64 = 0.5;
/// Unknowns: dark, step, gradient of light, centroid, sigma, h3 to h6.
const UNKNOWNS: usize = 9;
/// Index of h3.
const FIRST_HERMITE: usize = 5;
const LIMITS: Limits = Limits {
    iterations: 60,
    tries: 10,
    min_gain: 1e-6,
};

/// A profile with its moments.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Profile {
    /// Bins; zero distance is the centroid.
    pub(super) bins: Vec<ProfileBin>,
    /// Distance of the centroid from the line of the fit, px.
    pub(super) centroid: f64,
    /// Variance without that of the pixel, px², and its standard deviation.
    pub(super) variance: [f64; 2],
    /// Third central moment, px³, and its standard deviation.
    pub(super) third: [f64; 2],
    /// Chi squared per degree of freedom.
    pub(super) chi2: f64,
    /// Largest overshoot beyond the levels, over the step, and its standard deviation.
    pub(super) overshoot: [f64; 2],
    /// Largest gap between neighbouring bins within the blur, px.
    pub(super) gap_px: f64,
}

/// Noise of pixels: variance `dark` + `gain` x signal, counts².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgeNoise {
    pub(super) dark: f64,
    pub(super) gain: f64,
}

impl EdgeNoise {
    pub(super) fn variance(&self, signal: f64) -> f64 {
        self.dark + self.gain * signal.max(0.0)
    }
}

/// Returns the mean level of pixels in bins of their distance from the line.
pub(super) fn bins(pixels: &[EdgePixel], line: &LineFit, noise: EdgeNoise) -> Vec<ProfileBin> {
    let mut sorted: Vec<(f64, f64, f64)> = (pixels.iter())
        .map(|pixel| {
            let light = line.light_at(pixel);
            let variance = noise.variance(line.value(pixel)) / (light * light);
            let level = (pixel.value / light - line.dark) / line.step;
            (line.distance(pixel), level, variance / line.step.powi(2))
        })
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let same =
        |a: &(f64, f64, f64), b: &(f64, f64, f64)| (a.0 / BIN_PX).floor() == (b.0 / BIN_PX).floor();
    let bins = sorted.chunk_by(same).map(|bin| {
        let count = bin.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64, f64)) -> f64| bin.iter().map(of).sum::<f64>() / count;
        let t_px = mean(&|p| p.0);
        ProfileBin {
            t_px,
            level: mean(&|p| p.1),
            sigma: (mean(&|p| p.2) / count).sqrt(),
            spread_px2: mean(&|p| (p.0 - t_px).powi(2)),
        }
    });
    bins.collect()
}

/// Fits the moments of a profile of `bins`, starting at a width of `sigma`. `None` where they are not determined.
pub(super) fn fit(mut bins: Vec<ProfileBin>, sigma: f64, dark_over_step: f64) -> Option<Profile> {
    if bins.len() < UNKNOWNS + 3 {
        return None;
    }
    let start = Model {
        dark_over_step,
        values: SVector::from([0.0, 1.0, 0.0, 0.0, sigma, 0.0, 0.0, 0.0, 0.0]),
    };
    let mut normal = SMatrix::zeros();
    let equations = |model: &Model| {
        let equations = model.equations(&bins);
        normal = equations.0;
        equations
    };
    let (model, least) = minimise(start, |m| m.chi2(&bins), equations, Model::moved, LIMITS)?;
    let covariance = normal.try_inverse()?;
    let freedom = (bins.len() - UNKNOWNS) as f64;
    let chi2 = least / freedom;
    let inflation = chi2.max(1.0);
    let [.., centroid, width, h3, _, _, _] = <[f64; UNKNOWNS]>::from(model.values);
    let (variance, third) = (width * width, 6.0 * h3 * width.powi(3));
    let of_third = [18.0 * h3 * width * width, 6.0 * width.powi(3)];
    let third_square = of_third[0].powi(2) * covariance[(4, 4)]
        + 2.0 * of_third[0] * of_third[1] * covariance[(4, 5)]
        + of_third[1].powi(2) * covariance[(5, 5)];
    let sigma_of = |square: f64| (square.max(0.0) * inflation).sqrt();
    model.normalise(&mut bins);
    let (overshoot, gap_px) = (overshoot(&bins), gap(&bins, width));
    let profile = Profile {
        centroid,
        variance: [
            variance - PIXEL_VARIANCE_PX2,
            sigma_of(4.0 * variance * covariance[(4, 4)]),
        ],
        third: [third, sigma_of(third_square)],
        chi2,
        overshoot,
        gap_px,
        bins,
    };
    let numbers = profile.variance.iter().chain(&profile.third);
    numbers.copied().all(f64::is_finite).then_some(profile)
}

#[derive(Clone)]
struct Model {
    dark_over_step: f64,
    values: SVector<f64, UNKNOWNS>,
}

impl Model {
    /// Returns the level of the model at a bin and its derivatives.
    fn terms(&self, bin: &ProfileBin) -> (f64, SVector<f64, UNKNOWNS>) {
        let [dark, step, light, centroid, sigma, h3, h4, h5, h6] =
            <[f64; UNKNOWNS]>::from(self.values);
        // Pixels of a bin at different distances blur it further.
        let width = (sigma * sigma + bin.spread_px2).sqrt();
        let z = (bin.t_px - centroid) / width;
        let StandardNormal {
            density: phi,
            cumulative: cdf,
        } = StandardNormal::at(z);
        let he = hermite(z);
        let edge = cdf - phi * (h3 * he[2] + h4 * he[3] + h5 * he[4] + h6 * he[5]);
        // The derivative of phi He_n is -phi He_(n + 1).
        let slope = phi * (1.0 + h3 * he[3] + h4 * he[4] + h5 * he[5] + h6 * he[6]);
        let scale = 1.0 + light * bin.t_px;
        let base = dark + step * edge;
        let level = base + light * bin.t_px * (self.dark_over_step + base);
        let per_edge = step * scale;
        let derivatives = SVector::from([
            scale,
            edge * scale,
            bin.t_px * (self.dark_over_step + base),
            -per_edge * slope / width,
            -per_edge * slope * z * sigma / (width * width),
            -per_edge * phi * he[2],
            -per_edge * phi * he[3],
            -per_edge * phi * he[4],
            -per_edge * phi * he[5],
        ]);
        (level, derivatives)
    }

    fn chi2(&self, bins: &[ProfileBin]) -> f64 {
        let squares = bins
            .iter()
            .map(|bin| ((bin.level - self.terms(bin).0) / bin.sigma).powi(2));
        let hermite = self.values.iter().skip(FIRST_HERMITE);
        let prior = hermite
            .zip(HERMITE_SIZE)
            .map(|(h, size)| (h / size).powi(2));
        squares.sum::<f64>() + prior.sum::<f64>()
    }

    fn equations(&self, bins: &[ProfileBin]) -> Equations<UNKNOWNS> {
        let mut normal = SMatrix::zeros();
        let mut right = SVector::zeros();
        for bin in bins {
            let (level, row) = self.terms(bin);
            let row = row / bin.sigma;
            normal += row * row.transpose();
            right += row * ((bin.level - level) / bin.sigma);
        }
        for (k, size) in (FIRST_HERMITE..UNKNOWNS).zip(HERMITE_SIZE) {
            let ridge = 1.0 / (size * size);
            normal[(k, k)] += ridge;
            right[k] -= ridge * self.values[k];
        }
        (normal, right)
    }

    fn moved(&self, step: &SVector<f64, UNKNOWNS>) -> Self {
        let mut values = self.values + step;
        let sigma = self.values[4];
        values[4] = values[4].clamp((0.6 * sigma).max(0.1), 1.6 * sigma);
        Self { values, ..*self }
    }

    /// Sets the levels of `bins` to 0 and 1 on both sides, without the gradient of the light, and their zero to the centroid.
    fn normalise(&self, bins: &mut [ProfileBin]) {
        let [dark, step, light, centroid, ..] = <[f64; UNKNOWNS]>::from(self.values);
        for bin in bins {
            let scale = 1.0 + light * bin.t_px;
            let base = (bin.level + self.dark_over_step) / scale - self.dark_over_step;
            bin.level = (base - dark) / step;
            bin.sigma /= scale * step;
            bin.t_px -= centroid;
        }
    }
}

/// Standard deviations of h3 to h6 in the blur of lenses, before any pixel is seen: they are skewness / 6, excess kurtosis / 24
/// and so on, of which a disc has 0, -1/24, 0 and 5/720, and strong coma 0.12 and more. Levels and light hardly differ from
/// the higher terms in short profiles.
const HERMITE_SIZE: [f64; 4] = [0.1, 0.04, 0.015, 0.01];

/// Returns the probabilists' Hermite polynomials He_0 to He_6.
fn hermite(z: f64) -> [f64; 7] {
    let mut he = [1.0, z, 0.0, 0.0, 0.0, 0.0, 0.0];
    for n in 1..6 {
        he[n + 1] = z * he[n] - n as f64 * he[n - 1];
    }
    he
}

/// Returns the largest mean of three neighbouring bins beyond the levels, and its standard deviation.
fn overshoot(bins: &[ProfileBin]) -> [f64; 2] {
    let means = bins.windows(3).map(|three| {
        let beyond = |b: &ProfileBin| {
            if b.t_px > 0.0 {
                b.level - 1.0
            } else {
                -b.level
            }
        };
        let mean = three.iter().map(beyond).sum::<f64>() / 3.0;
        let variance = three.iter().map(|b| b.sigma * b.sigma).sum::<f64>() / 9.0;
        [mean, variance.sqrt()]
    });
    means
        .max_by(|a, b| a[0].total_cmp(&b[0]))
        .unwrap_or([0.0, 1.0])
}

/// Returns the largest distance of neighbouring bins within one and a half widths of the centroid, px.
fn gap(bins: &[ProfileBin], width: f64) -> f64 {
    let near = bins
        .windows(2)
        .filter(|two| two[0].t_px < 1.5 * width && two[1].t_px > -1.5 * width);
    near.map(|two| two[1].t_px - two[0].t_px)
        .fold(0.0, f64::max)
}

//! Gauss-Hermite fit of a light in one channel: flux, centroid, covariance and skewness from whichever pixels there are.
//!
//! The model is a Gaussian times a polynomial, in coordinates in which the Gaussian is round and of unit variance:
//!
//!   f(u, v) = G(u, v) sum of h_mn He_m(u) He_n(v), m + n <= 4
//!
//! with probabilists' Hermite polynomials He. By their orthogonality the mean of u is h_10 / h_00, its variance
//! 1 + 2 h_20 / h_00 less the squared mean, and its third moment 6 h_30 / h_00. For a given Gaussian the h_mn are a linear
//! least-squares problem. The Gaussian is first fitted by itself: terms up to second order move it to their mean and covariance
//! until they vanish, which is the least-squares Gaussian. Terms up to fourth order are then fitted once. The result has the
//! moments of the light without sums over pixels, so that gaps of a mosaic do not matter.

use nalgebra::{DMatrix, DVector};
use seidel_optics::numeric::dot;

/// Largest number of iterations, and the shift of the centroid in px below which they end.
const MAX_ITERATIONS: usize = 40;
const CONVERGED_PX: f64 = 1e-4;
/// Pixels per coefficient that a fit needs.
const MIN_PIXELS_PER_TERM: usize = 2;
/// Smallest variance of the Gaussian, px²: pixel area and a little optics.
const MIN_VARIANCE_PX2: f64 = 0.2;
/// Largest relative standard deviation of a flux that is determined.
const MAX_RELATIVE_FLUX_SIGMA: f64 = 0.3;
/// Largest relative change of the covariance in one iteration, along any direction, and largest shift in standard deviations.
const MAX_CHANGE: f64 = 0.5;
const MAX_SHIFT: f64 = 1.0;

/// A pixel of a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPixel {
    /// Centre of the pixel, px.
    pub x: f64,
    /// Centre of the pixel, px.
    pub y: f64,
    /// Signal above background, counts.
    pub value: f64,
}

/// Noise of pixels: variance `sigma`² + `gain` x signal + (`model_error` x peak)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelNoise {
    /// Standard deviation of a dark pixel, counts.
    pub sigma: f64,
    /// Counts per electron; zero if unknown.
    pub gain: f64,
    /// Error of the model relative to the largest signal of the light.
    pub model_error: f64,
}

impl PixelNoise {
    fn variance(&self, signal: f64, peak: f64) -> f64 {
        let (signal, peak) = (signal.max(0.0), peak.max(0.0));
        self.sigma * self.sigma + self.gain * signal + (self.model_error * peak).powi(2)
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// A fitted profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Centroid, px.
    pub centroid: [f64; 2],
    /// Standard deviation of the centroid along x and y, px.
    pub centroid_sigma: f64,
    /// Total light, counts, and its standard deviation.
    pub flux: f64,
    /// Standard deviation of the flux, counts.
    pub flux_sigma: f64,
    /// Covariance (xx, xy, yy), px², pixel area included.
    pub covariance: [f64; 3],
    /// Third moments mu30, mu21, mu12, mu03, px³.
    pub third: [f64; 4],
    /// Standard deviations of [`Profile::shape`].
    pub shape_sigma: [f64; 7],
    /// Chi squared per degree of freedom.
    pub chi2: f64,
    /// Model value of every pixel, counts, in the order given.
    pub model: Vec<f64>,
    /// Number of coefficients.
    pub terms: usize,
}

impl Profile {
    /// Returns the second and third moments: mu20, mu11, mu02, mu30, mu21, mu12, mu03.
    pub fn shape(&self) -> [f64; 7] {
        let [a, b, c] = self.covariance;
        let [d, e, f, g] = self.third;
        [a, b, c, d, e, f, g]
    }

    /// Returns the standard deviation along the widest direction, px.
    pub fn largest_sigma_px(&self) -> f64 {
        let [xx, xy, yy] = self.covariance;
        let half = (xx - yy) / 2.0;
        ((xx + yy) / 2.0 + half.hypot(xy)).sqrt()
    }
}

/// Share of the variance of residuals that the mean over the pixels of a channel does not see, as residuals of neighbours are
/// alike. An estimate: with it the stated errors of one simulated photograph covered 92 to 94 % of the true ones.
const GAP_VARIANCE: f64 = 0.3;

impl Profile {
    /// Moves the centroid to the first moment of the light: that of the model plus that of the residuals, where `share` is the
    /// share of all pixels that were fitted. A series of fourth order does not follow strong coma; its residuals are small and
    /// smooth, so that a sum over the pixels of one colour integrates them well.
    pub fn refine_centroid(&mut self, pixels: &[LightPixel], noise: PixelNoise, share: f64) {
        let mut shift = [0.0; 2];
        let mut flux = self.flux;
        for (pixel, model) in pixels.iter().zip(&self.model) {
            let residual = (pixel.value - model) / share;
            flux += residual;
            shift[0] += residual * (pixel.x - self.centroid[0]);
            shift[1] += residual * (pixel.y - self.centroid[1]);
        }
        if flux <= 0.5 * self.flux {
            // Noise alone: the fitted profile is the better estimate.
            return;
        }
        let centroid = [0, 1].map(|axis| self.centroid[axis] + shift[axis] / flux);
        let mut variance = 0.0;
        for (pixel, model) in pixels.iter().zip(&self.model) {
            let of_noise = noise.sigma * noise.sigma + noise.gain * model.max(0.0);
            let of_gaps = GAP_VARIANCE * (1.0 - share) * (pixel.value - model).powi(2);
            let square = (pixel.x - centroid[0]).powi(2) + (pixel.y - centroid[1]).powi(2);
            variance += (of_noise + of_gaps) * square / 2.0;
        }
        self.centroid = centroid;
        self.centroid_sigma = variance.sqrt() / (share * flux);
        self.flux = flux;
    }
}

/// Lower Cholesky factor of a covariance: x - centroid = L (u, v).
#[derive(Clone, Copy)]
struct Shape {
    centre: [f64; 2],
    l11: f64,
    l21: f64,
    l22: f64,
}

impl Shape {
    fn new(centre: [f64; 2], covariance: [f64; 3], least_variance: f64) -> Self {
        let [xx, xy, yy] = covariance;
        let l11 = xx.max(least_variance).sqrt();
        let l21 = xy / l11;
        let l22 = (yy - l21 * l21).max(0.5 * least_variance).sqrt();
        Self {
            centre,
            l11,
            l21,
            l22,
        }
    }

    fn white(&self, x: f64, y: f64) -> [f64; 2] {
        let u = (x - self.centre[0]) / self.l11;
        [u, (y - self.centre[1] - self.l21 * u) / self.l22]
    }

    fn rows(&self) -> [[f64; 2]; 2] {
        [[self.l11, 0.0], [self.l21, self.l22]]
    }
}

/// The start of a fit, and the narrowest Gaussian it may end in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Centre of the light, px.
    pub centre: [f64; 2],
    /// Variance along every direction, px².
    pub variance_px2: f64,
    /// Least variance, px². Pixels two apart determine no narrower Gaussian.
    pub least_variance_px2: f64,
}

/// Fits `pixels` from `start`. `None` where there are too few pixels, or they hold no light of positive flux.
pub fn fit(pixels: &[LightPixel], noise: PixelNoise, start: Start) -> Option<Profile> {
    let mut orders = (2..=4).rev();
    // Fewer terms where more are not determined.
    orders.find_map(|order| {
        fit_order(pixels, noise, start, order)
            .filter(|p| p.flux_sigma < MAX_RELATIVE_FLUX_SIGMA * p.flux)
    })
}

/// Fits the flux alone of `pixels`, with the place and the Gaussian of `like`: for a channel too faint to show its own. `None` where they hold
/// no light of positive flux.
pub fn fit_flux(pixels: &[LightPixel], noise: PixelNoise, like: &Profile) -> Option<Profile> {
    let shape = Shape::new(like.centroid, like.covariance, MIN_VARIANCE_PX2);
    let values: Vec<f64> = pixels.iter().map(|p| p.value).collect();
    let solved = solve(pixels, noise, &shape, 0, &values)?;
    let profile = solved.profile(pixels, noise, &shape)?;
    let relative = profile.flux_sigma / profile.flux;
    (profile.flux > 0.0 && relative < MAX_RELATIVE_FLUX_SIGMA).then(|| Profile {
        // That of a matched filter.
        centroid_sigma: like.largest_sigma_px() * relative,
        third: like.third,
        shape_sigma: (like.shape_sigma).map(|sigma| sigma * relative * like.flux / like.flux_sigma),
        ..profile
    })
}

fn fit_order(
    pixels: &[LightPixel],
    noise: PixelNoise,
    start: Start,
    order: usize,
) -> Option<Profile> {
    if pixels.len() < MIN_PIXELS_PER_TERM * terms_of(order) {
        return None;
    }
    let Start {
        centre,
        variance_px2,
        least_variance_px2,
    } = start;
    let least = least_variance_px2.max(MIN_VARIANCE_PX2);
    let mut shape = Shape::new(centre, [variance_px2, 0.0, variance_px2], least);
    let mut expected: Vec<f64> = pixels.iter().map(|p| p.value).collect();
    for _ in 0..MAX_ITERATIONS {
        let solved = solve(pixels, noise, &shape, 2, &expected)?;
        let (centroid, covariance) = solved.moments(&shape)?;
        let moved = (centroid[0] - shape.centre[0]).hypot(centroid[1] - shape.centre[1]);
        let reach = 4.0 * variance_px2.sqrt() + 2.0;
        if (centroid[0] - centre[0]).hypot(centroid[1] - centre[1]) > reach {
            return None;
        }
        shape = Shape::new(centroid, covariance, least);
        expected = solved.model;
        if moved < CONVERGED_PX {
            break;
        }
    }
    let last = solve(pixels, noise, &shape, order, &expected)?;
    last.profile(pixels, noise, &shape)
}

fn terms_of(order: usize) -> usize {
    (order + 1) * (order + 2) / 2
}

/// Powers (m, n) of the terms up to `order`.
fn powers(order: usize) -> Vec<(usize, usize)> {
    (0..=order)
        .flat_map(|sum| (0..=sum).map(move |n| (sum - n, n)))
        .collect()
}

fn hermite(u: f64) -> [f64; 5] {
    let u2 = u * u;
    [1.0, u, u2 - 1.0, u * (u2 - 3.0), u2 * u2 - 6.0 * u2 + 3.0]
}

/// Coefficients of one linear fit.
struct Solution {
    powers: Vec<(usize, usize)>,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
    model: Vec<f64>,
}

fn solve(
    pixels: &[LightPixel],
    noise: PixelNoise,
    shape: &Shape,
    order: usize,
    expected: &[f64],
) -> Option<Solution> {
    let powers = powers(order);
    let count = powers.len();
    let mut normal: DMatrix<f64> = DMatrix::zeros(count, count);
    let mut right: DVector<f64> = DVector::zeros(count);
    let scale = 1.0 / (std::f64::consts::TAU * shape.l11 * shape.l22);
    let mut rows = Vec::with_capacity(pixels.len() * count);
    let peak = largest(expected);
    for (pixel, expected) in pixels.iter().zip(expected) {
        let [u, v] = shape.white(pixel.x, pixel.y);
        let gauss = scale * (-0.5 * (u * u + v * v)).exp();
        let (hu, hv) = (hermite(u), hermite(v));
        let row: Vec<f64> = powers.iter().map(|&(m, n)| gauss * hu[m] * hv[n]).collect();
        let weight = 1.0 / noise.variance(*expected, peak);
        for a in 0..count {
            right[a] += weight * row[a] * pixel.value;
            for b in 0..=a {
                normal[(a, b)] += weight * row[a] * row[b];
            }
        }
        rows.extend(row);
    }
    for a in 0..count {
        for b in 0..a {
            normal[(b, a)] = normal[(a, b)];
        }
        normal[(a, a)] *= 1.0 + 1e-10;
    }
    let covariance = normal.cholesky()?.inverse();
    let coefficients: DVector<f64> = &covariance * right;
    let model = rows
        .chunks_exact(count)
        .map(|row| dot(row, coefficients.as_slice()))
        .collect();
    Some(Solution {
        powers,
        coefficients,
        covariance,
        model,
    })
}

impl Solution {
    fn index(&self, m: usize, n: usize) -> Option<usize> {
        self.powers.iter().position(|p| *p == (m, n))
    }

    /// Returns h_mn / h_00; zero for terms that were not fitted.
    fn ratio(&self, m: usize, n: usize) -> f64 {
        let h = self.index(m, n).map_or(0.0, |k| self.coefficients[k]);
        h / self.coefficients[0]
    }

    /// Returns the standard deviation of h_mn / h_00.
    fn ratio_sigma(&self, m: usize, n: usize) -> f64 {
        let Some(k) = self.index(m, n) else {
            return 0.0;
        };
        let ratio = self.ratio(m, n);
        let c = &self.covariance;
        let variance = c[(k, k)] - 2.0 * ratio * c[(k, 0)] + ratio * ratio * c[(0, 0)];
        variance.max(0.0).sqrt() / self.coefficients[0].abs()
    }

    /// Returns the centroid and covariance of the fitted profile, changed by a limited step; `None` without light.
    fn moments(&self, shape: &Shape) -> Option<([f64; 2], [f64; 3])> {
        let flux = self.coefficients[0];
        if !(flux.is_finite() && flux > 0.0) {
            return None;
        }
        let [u, v] = [self.ratio(1, 0), self.ratio(0, 1)];
        let short = MAX_SHIFT / u.hypot(v).max(MAX_SHIFT);
        let mean = [u * short, v * short];
        let l = shape.rows();
        let centroid = [0, 1].map(|r| shape.centre[r] + l[r][0] * mean[0] + l[r][1] * mean[1]);
        let change = [
            2.0 * self.ratio(2, 0) - mean[0] * mean[0],
            self.ratio(1, 1) - mean[0] * mean[1],
            2.0 * self.ratio(0, 2) - mean[1] * mean[1],
        ];
        // Scaled as a whole, so that the covariance stays positive.
        let half = (change[0] - change[2]) / 2.0;
        let largest = ((change[0] + change[2]) / 2.0).abs() + half.hypot(change[1]);
        let short = MAX_CHANGE / largest.max(MAX_CHANGE);
        let [uu, uv, vv] = change.map(|v| v * short);
        let white = [1.0 + uu, uv, 1.0 + vv];
        let covariance = transformed(l, white);
        let sound = covariance.iter().chain(&centroid).all(|v| v.is_finite());
        sound.then_some((centroid, covariance))
    }

    fn profile(self, pixels: &[LightPixel], noise: PixelNoise, shape: &Shape) -> Option<Profile> {
        let flux = self.coefficients[0];
        if !(flux.is_finite() && flux > 0.0) {
            return None;
        }
        let (centroid, covariance) = self.moments(shape)?;
        let residuals = pixels.iter().zip(&self.model);
        let peak = largest(&self.model);
        let chi2: f64 = residuals
            .map(|(p, m)| (p.value - m).powi(2) / noise.variance(*m, peak))
            .sum();
        let freedom = (pixels.len() - self.powers.len()).max(1) as f64;
        let chi2 = chi2 / freedom;
        // Where the model does not describe the light, its residuals say how far the result may be off.
        let inflation = chi2.max(1.0).sqrt();
        let l = shape.rows();
        let along = [self.ratio_sigma(1, 0), self.ratio_sigma(0, 1)];
        let of_axis = |r: usize| (l[r][0] * along[0]).hypot(l[r][1] * along[1]);
        let white = [
            6.0 * self.ratio(3, 0),
            2.0 * self.ratio(2, 1),
            2.0 * self.ratio(1, 2),
            6.0 * self.ratio(0, 3),
        ];
        let (s1, s2) = (shape.l11, shape.l22);
        let sigma = |m: usize, n: usize, factor: f64| {
            let size = s1.powi(m as i32) * s2.powi(n as i32);
            factor * size * self.ratio_sigma(m, n) * inflation
        };
        Some(Profile {
            centroid,
            centroid_sigma: ((of_axis(0).powi(2) + of_axis(1).powi(2)) / 2.0).sqrt() * inflation,
            flux,
            flux_sigma: self.covariance[(0, 0)].max(0.0).sqrt() * inflation,
            covariance,
            third: rotated_third(l, white),
            shape_sigma: [
                sigma(2, 0, 2.0),
                sigma(1, 1, 1.0),
                sigma(0, 2, 2.0),
                sigma(3, 0, 6.0),
                sigma(2, 1, 2.0),
                sigma(1, 2, 2.0),
                sigma(0, 3, 6.0),
            ],
            chi2,
            terms: self.powers.len(),
            model: self.model,
        })
    }
}

/// Returns L W L' for a symmetric W (uu, uv, vv).
fn transformed(l: [[f64; 2]; 2], white: [f64; 3]) -> [f64; 3] {
    let [uu, uv, vv] = white;
    let entry = |a: [f64; 2], b: [f64; 2]| {
        a[0] * b[0] * uu + (a[0] * b[1] + a[1] * b[0]) * uv + a[1] * b[1] * vv
    };
    [entry(l[0], l[0]), entry(l[0], l[1]), entry(l[1], l[1])]
}

/// Returns the third moments of L (u, v) for those of (u, v): uuu, uuv, uvv, vvv.
fn rotated_third(l: [[f64; 2]; 2], white: [f64; 4]) -> [f64; 4] {
    let moment = |axes: [usize; 3]| {
        let mut sum = 0.0;
        for k in 0..8 {
            let pick = [k & 1, (k >> 1) & 1, (k >> 2) & 1];
            let factor: f64 = (axes.iter().zip(pick))
                .map(|(axis, p)| l[*axis][p])
                .product();
            sum += factor * white[pick.iter().sum::<usize>()];
        }
        sum
    };
    [[0, 0, 0], [0, 0, 1], [0, 1, 1], [1, 1, 1]].map(moment)
}

//! SIMD code that samples skew-normal densities.
//!
//! It is plain single-precision arithmetic in blocks of [`LANES`], without branches and without fused
//! multiply-adds, so that every instruction set gives the same bits. Callers enter it through
//! `pulp::Arch::dispatch`, which selects the instruction set at run time.

use super::{SampleGrid, SkewNormalDensity};
use std::ops::Range;

/// Samples per block: the widest SIMD vector of 32-bit numbers (AVX-512).
pub(super) const LANES: usize = 16;

/// Samples below 2^-23 of the peak of the underlying normal are drawn as zero. They are below the rounding of the
/// peak, and skipping them saves the corners of slanted kernels.
const CUT_BITS: f64 = 23.0;
/// Argument beyond which the distribution function is taken as 0 or 1: it is within 6e-8 of either.
const CDF_REACH: f64 = 5.3;
/// Slope (px^-1) below which the distribution function is constant along a row of any realistic length.
const LEVEL_SLOPE: f64 = 1e-9;

/// Adds `weight` times the density of `part` at the pixel centres of `window` to `out`.
pub(super) fn sample_rows_f32(
    part: &SkewNormalDensity,
    weight: f64,
    window: &SampleGrid,
    out: &mut [f32],
) {
    if window.is_empty() {
        return;
    }
    pulp::Arch::new().dispatch(Sampling {
        part,
        weight,
        window,
        out,
    });
}

/// [`sample_rows_f32`] for `pulp::Arch::dispatch`. Not a closure: the shim around a closure is not always inlined,
/// and its body is then compiled without the vector instructions.
struct Sampling<'a> {
    part: &'a SkewNormalDensity,
    weight: f64,
    window: &'a SampleGrid,
    out: &'a mut [f32],
}

impl pulp::WithSimd for Sampling<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let scan = Scan::new(self.part, self.weight, self.window);
        for (row, line) in self.out.chunks_exact_mut(self.window.width).enumerate() {
            let Some((curve, span)) = scan.row(row) else {
                continue;
            };
            for (block, samples) in line[span.clone()].chunks_mut(LANES).enumerate() {
                let mut drawn = [0.0; LANES];
                curve.sample(span.start + block * LANES, &mut drawn);
                for (sample, drawn) in samples.iter_mut().zip(&drawn) {
                    *sample += drawn;
                }
            }
        }
    }
}

/// A density prepared for sampling row by row on one grid.
///
/// With z the offset from the mean of the underlying normal, the exponent is `root² (z1 + tilt z2)² + across z2²` in
/// bits (powers of two). Both terms are non-negative, which avoids the cancellation that the expanded quadratic
/// suffers for long slanted kernels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scan {
    root: f64,
    per_root: f64,
    tilt: f64,
    across: f64,
    /// Offset of column 0 and row 0 from the mean of the underlying normal, px.
    first: [f64; 2],
    eta: [f64; 2],
    /// 1 / eta[0], or 0 if the distribution function is constant along rows.
    per_eta: f64,
    peak: f32,
    skewed: bool,
    last_column: f64,
}

impl Scan {
    /// Prepares `weight` times `part` on `window`, which must not be empty.
    #[inline(always)]
    pub(super) fn new(part: &SkewNormalDensity, weight: f64, window: &SampleGrid) -> Self {
        let [a, b, c] = part.inverse;
        let bits = 0.5 * std::f64::consts::LOG2_E;
        let root = (bits * a).sqrt();
        let tilt = b / a;
        let skewed = part.eta != [0.0, 0.0];
        let level = part.eta[0].abs() < LEVEL_SLOPE;
        let half = if skewed { 1.0 } else { 0.5 };
        Self {
            root,
            per_root: 1.0 / root,
            tilt,
            across: bits * (c - b * tilt),
            first: [
                window.first_x_px + part.offset[0],
                window.first_y_px + part.offset[1],
            ],
            eta: part.eta,
            per_eta: if level { 0.0 } else { 1.0 / part.eta[0] },
            peak: (half * weight * part.peak) as f32,
            skewed,
            last_column: (window.width - 1) as f64,
        }
    }

    /// Returns the density along `row` and the columns where it is not negligible; `None` if there are none.
    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> Option<(Curve, Range<usize>)> {
        let z2 = self.first[1] + row as f64;
        let base = self.across * z2 * z2;
        if base >= CUT_BITS {
            return None;
        }
        let centre = -self.first[0] - self.tilt * z2;
        let half = (CUT_BITS - base).sqrt() * self.per_root;
        let (mut low, mut high) = (centre - half, centre + half);
        // Argument of the distribution function at column 0.
        let cdf_start = self.eta[0] * self.first[0] + self.eta[1] * z2;
        if self.skewed {
            let rise = (-CDF_REACH - cdf_start) * self.per_eta;
            if self.per_eta > 0.0 {
                low = low.max(rise);
            } else if self.per_eta < 0.0 {
                high = high.min(rise);
            } else if cdf_start < -CDF_REACH {
                return None;
            }
        }
        let low = low.ceil().max(0.0);
        let high = high.floor().min(self.last_column);
        if low > high {
            return None;
        }
        // Positions are split into a whole column, exact in single precision, and the value there,
        // which is small where the curve is steep and so keeps its precision.
        let origin = centre.round_ties_even().clamp(0.0, self.last_column);
        let cdf_origin = (-cdf_start * self.per_eta)
            .round_ties_even()
            .clamp(0.0, self.last_column);
        let slope = if self.per_eta == 0.0 {
            0.0
        } else {
            self.eta[0]
        };
        let curve = Curve {
            step: self.root as f32,
            origin: origin as f32,
            at_origin: (self.root * (origin - centre)) as f32,
            base: base as f32,
            peak: self.peak,
            skewed: self.skewed,
            slope: slope as f32,
            cdf_origin: cdf_origin as f32,
            cdf_at_origin: (cdf_start + slope * cdf_origin) as f32,
        };
        Some((curve, low as usize..high as usize + 1))
    }
}

/// A density along one row, as a function of the column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    step: f32,
    origin: f32,
    at_origin: f32,
    base: f32,
    peak: f32,
    skewed: bool,
    slope: f32,
    cdf_origin: f32,
    cdf_at_origin: f32,
}

impl Curve {
    /// Samples the density at columns `first`, `first + 1`, ... `first + LANES - 1`.
    #[inline(always)]
    pub(super) fn sample(&self, first: usize, out: &mut [f32; LANES]) {
        let first = first as f32;
        let start = first - self.origin;
        for (lane, sample) in out.iter_mut().enumerate() {
            let t = (start + lane as f32) * self.step + self.at_origin;
            *sample = self.peak * exp2_of_minus(t * t + self.base);
        }
        if self.skewed {
            let start = first - self.cdf_origin;
            // The argument is linear: if both ends are past the reach, the factor is 1 everywhere.
            let reach = CDF_REACH as f32;
            if self.cdf_argument(start) >= reach
                && self.cdf_argument(start + (LANES - 1) as f32) >= reach
            {
                return;
            }
            for (lane, sample) in out.iter_mut().enumerate() {
                *sample *= cdf(self.cdf_argument(start + lane as f32));
            }
        }
    }

    /// Returns the argument of the distribution function `columns` away from where it is steepest.
    #[inline(always)]
    fn cdf_argument(&self, columns: f32) -> f32 {
        columns * self.slope + self.cdf_at_origin
    }
}

/// Returns 2^-`bits` for `bits` of at least 0, within 2.5e-7 relative; zero beyond [`CUT_BITS`].
#[inline(always)]
fn exp2_of_minus(bits: f32) -> f32 {
    // Adding 1.5 * 2^23 rounds to an integer and leaves it in the low bits.
    const ROUND: f32 = 12_582_912.0;
    const ONE: u32 = 127 << 23;
    // Minimax (relative) on [-1/2, 1/2].
    const C: [f32; 6] = [
        1.000_000_1,
        0.693_146_97,
        0.240_221_2,
        0.055_507_13,
        0.009_675_541,
        0.001_327_647_2,
    ];
    let cut = CUT_BITS as f32;
    let clamped = if bits < cut { bits } else { cut };
    let rounded = clamped + ROUND;
    let f = (rounded - ROUND) - clamped;
    let p = C[0] + f * (C[1] + f * (C[2] + f * (C[3] + f * (C[4] + f * C[5]))));
    let whole = rounded.to_bits().wrapping_sub(ROUND.to_bits());
    let power = f32::from_bits(ONE.wrapping_sub(whole << 23));
    if bits <= cut { p * power } else { 0.0 }
}

/// Returns the normal distribution function within 3e-7; never negative.
#[inline(always)]
fn cdf(w: f32) -> f32 {
    // cdf(w) - 1/2 = w P(w²) / Q(w²), minimax (absolute) on [-CDF_REACH, CDF_REACH]: 7.2e-8.
    const P: [f32; 5] = [
        0.398_941_83,
        0.052_070_985,
        0.005_699_439,
        0.000_341_629_07,
        0.000_006_264_922,
    ];
    const Q: [f32; 6] = [
        1.0,
        0.297_181_94,
        0.038_830_097,
        0.002_863_516,
        0.000_122_536_08,
        0.000_000_529_834_94,
    ];
    let reach = CDF_REACH as f32;
    let w = if w < reach { w } else { reach };
    let w = if w > -reach { w } else { -reach };
    let u = w * w;
    let p = P[0] + u * (P[1] + u * (P[2] + u * (P[3] + u * P[4])));
    let q = Q[0] + u * (Q[1] + u * (Q[2] + u * (Q[3] + u * (Q[4] + u * Q[5]))));
    let value = 0.5 + w * p / q;
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::psf::{Mixture, T_MAX, normal_cdf};

    #[test]
    fn approximations_hold_their_bounds() {
        for k in 0..=230_000 {
            let bits = k as f32 * 1e-4;
            let exact = (-f64::from(bits)).exp2();
            let error = (f64::from(exp2_of_minus(bits)) - exact).abs();
            assert!(error <= 2.5e-7 * exact, "2^-{bits}: off by {error:e}");
        }
        assert_eq!(exp2_of_minus(23.001), 0.0);
        assert_eq!(exp2_of_minus(f32::INFINITY), 0.0);
        for k in -100_000..=100_000 {
            let w = k as f32 * 1e-4;
            let value = cdf(w);
            let error = (f64::from(value) - normal_cdf(f64::from(w))).abs();
            assert!(
                error <= 3.0e-7 && value >= 0.0,
                "cdf({w}): off by {error:e}"
            );
        }
    }

    /// A fixed sequence of numbers in [0, 1).
    struct Draws(u64);

    impl Draws {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn between(&mut self, low: f64, high: f64) -> f64 {
            low + (high - low) * self.next()
        }
    }

    /// Returns a random density: sizes from a thirtieth of a pixel to `largest` px, any slant, any admissible skew.
    fn any_density(draws: &mut Draws, largest: f64) -> SkewNormalDensity {
        let size = |d: &mut Draws| d.between(0.0316_f64.ln(), largest.ln()).exp();
        let (along, across) = (size(draws), size(draws));
        let (sin, cos) = draws.between(0.0, std::f64::consts::TAU).sin_cos();
        let covariance = [
            (along * cos).powi(2) + (across * sin).powi(2),
            (along * along - across * across) * cos * sin,
            (along * sin).powi(2) + (across * cos).powi(2),
        ];
        // Skew in units of the ellipse: a third of the densities have none, a third the limit.
        let skew = match (draws.next() * 3.0) as u32 {
            0 => 0.0,
            1 => 0.999 * T_MAX.sqrt(),
            _ => draws.next() * T_MAX.sqrt() * 0.999,
        };
        let (v, u) = draws.between(0.0, std::f64::consts::TAU).sin_cos();
        let (u, v) = (skew * along * u, skew * across * v);
        SkewNormalDensity::new(covariance, [cos * u - sin * v, sin * u + cos * v])
    }

    fn worst_error(mixture: &Mixture, window: &SampleGrid) -> f64 {
        let mut exact = vec![0.0; window.len()];
        let mut fast = vec![0.0; window.len()];
        mixture.sample(window, &mut exact);
        mixture.sample_f32(window, &mut fast);
        exact
            .iter()
            .zip(&fast)
            .map(|(e, f)| (e - f64::from(*f)).abs())
            .fold(0.0, f64::max)
    }

    /// The peak is at least half that of the normal: the distribution function is 1/2 there.
    #[test]
    fn vector_samples_are_within_a_millionth_of_the_peak() {
        let mut draws = Draws(7);
        let mut worst = 0.0_f64;
        for case in 0..3000 {
            let largest = if case % 10 == 0 { 70.0 } else { 8.0 };
            let density = any_density(&mut draws, largest);
            let width = 1 + (draws.next() * draws.next() * 90.0) as usize;
            let height = 1 + (draws.next() * draws.next() * 90.0) as usize;
            let window = SampleGrid::for_tile(
                width,
                height,
                draws.between(-2.0, width as f64 + 2.0),
                draws.between(-2.0, height as f64 + 2.0),
            );
            let error = worst_error(&Mixture::One(density), &window) / (0.5 * density.peak);
            assert!(
                error <= 1e-6,
                "case {case}: {error:e} of the peak, {density:?}"
            );
            worst = worst.max(error);
        }
        assert!(worst > 0.0, "single precision is not exact");
    }

    #[test]
    fn the_largest_kernels_and_pairs_are_as_accurate() {
        let mut draws = Draws(11);
        for width in [1, 2, 15, 16, 17, 31, 333, 700] {
            let size = width as f64 / 10.0 + 0.04;
            let first = any_density(&mut draws, size.max(0.04));
            let mut second = first;
            second.eta = [-first.eta[1], first.eta[0]];
            let window = SampleGrid::for_tile(width, 40, width as f64 / 2.0, 20.3);
            for mixture in [Mixture::One(first), Mixture::Two([first, second])] {
                let error = worst_error(&mixture, &window) / (0.5 * first.peak);
                assert!(error <= 1e-6, "{width} px: {error:e} of the peak");
            }
        }
    }
}

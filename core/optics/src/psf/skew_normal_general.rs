//! The skew-normal PSF fitted without mirror symmetry, for measured moments.

use super::skew_normal_density::{PHI, SKEW_CAP, T_MAX};
use super::{LocalBlur, Mixture, MomentPsf, SkewNormalDensity};
use crate::moments::CentralMoments;

/// The skew-normal density closest in third moments, with weights (1, 3, 3, 1).
///
/// These weights make the fit invariant to rotation of the axes.
#[derive(Debug, Clone, Copy)]
pub struct SkewNormalGeneral;

impl MomentPsf for SkewNormalGeneral {
    const ID: &'static str = "skew-normal-general";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        density(&blur.moments, [1.0, 3.0, 3.0, 1.0])
    }
}

/// [`SkewNormalGeneral`] with the paper's equal weights (Eq 43), for comparison with the paper.
///
/// The fit depends on the orientation of the axes.
#[derive(Debug, Clone, Copy)]
pub struct SkewNormalEq43;

impl MomentPsf for SkewNormalEq43 {
    const ID: &'static str = "skew-normal-eq43";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        density(&blur.moments, [1.0; 4])
    }
}

fn density(m: &CentralMoments, weights: [f64; 4]) -> Mixture {
    let (s, _) = best_skew(m, weights);
    Mixture::One(SkewNormalDensity::new([m.mu20, m.mu11, m.mu02], s))
}

/// Directions sampled over the full turn before refinement; the misfit has at most a few minima.
const DIRECTIONS: usize = 360;
/// Golden-section steps: the bracket of two directions shrinks below 1e-10 rad.
const REFINEMENTS: usize = 44;

/// Returns the skew vector s (px) whose third moments PHI s_i s_j s_k are closest to those of `m`, and the misfit.
///
/// The misfit is the sum of squares over (mu30, mu21, mu12, mu03) with `weights`. It is minimised globally over the
/// admissible s' Sigma^-1 s <= 0.999² T_MAX: the best length has a closed form, so only the direction is searched. The
/// covariance must be positive definite.
pub fn best_skew(m: &CentralMoments, weights: [f64; 4]) -> ([f64; 2], f64) {
    let target = [m.mu30, m.mu21, m.mu12, m.mu03];
    if target == [0.0; 4] {
        return ([0.0, 0.0], 0.0);
    }
    // Cholesky factor of the covariance: u = L (cos, sin) has u' Sigma^-1 u = 1.
    let l11 = m.mu20.sqrt();
    let l21 = m.mu11 / l11;
    let l22 = (m.mu02 - l21 * l21).max(0.0).sqrt();
    let longest = SKEW_CAP * T_MAX.sqrt();
    let at = |angle: f64| -> (f64, [f64; 2]) {
        let (sin, cos) = angle.sin_cos();
        let u = [l11 * cos, l21 * cos + l22 * sin];
        let third = |a: f64, b: f64| {
            [a * a * a, a * a * b, a * b * b, b * b * b].map(|product| PHI * product)
        };
        let unit = third(u[0], u[1]);
        let (mut along, mut norm) = (0.0, 0.0);
        for k in 0..4 {
            along += weights[k] * unit[k] * target[k];
            norm += weights[k] * unit[k] * unit[k];
        }
        let length = (along / norm).max(0.0).cbrt().min(longest);
        let s = [length * u[0], length * u[1]];
        let got = third(s[0], s[1]);
        let misfit = (0..4)
            .map(|k| weights[k] * (target[k] - got[k]) * (target[k] - got[k]))
            .sum();
        (misfit, s)
    };
    let step = std::f64::consts::TAU / DIRECTIONS as f64;
    let misfits: Vec<f64> = (0..DIRECTIONS).map(|k| at(k as f64 * step).0).collect();
    let mut best = (f64::INFINITY, [0.0, 0.0]);
    for k in 0..DIRECTIONS {
        let before = misfits[(k + DIRECTIONS - 1) % DIRECTIONS];
        let after = misfits[(k + 1) % DIRECTIONS];
        if misfits[k] > before || misfits[k] > after {
            continue;
        }
        let found = at(least_angle(
            &at,
            (k as f64 - 1.0) * step,
            (k as f64 + 1.0) * step,
        ));
        if found.0 < best.0 {
            best = found;
        }
    }
    (best.1, best.0)
}

/// Returns the angle of the least misfit between two angles, by golden-section search.
fn least_angle(at: &impl Fn(f64) -> (f64, [f64; 2]), mut low: f64, mut high: f64) -> f64 {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    for _ in 0..REFINEMENTS {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if at(a).0 < at(b).0 {
            high = b;
        } else {
            low = a;
        }
    }
    (low + high) / 2.0
}

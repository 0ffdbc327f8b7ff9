//! The five reduced numbers of a third-order lens at one depth, and their conversion to and from S1..S10.

use super::MomentCoefficients;

/// The five numbers that determine all moments of a third-order lens (X-frame, docs/background/model.md section 3).
///
/// With u in the unit pupil disc and X the field position, a ray lands off the chief ray by
/// `(alpha + beta |u|² + delta |X|²) u + gamma X (X.u) - phi (|u|² X + 2 u (X.u))`. Units follow
/// from those of PSF and field: alpha and beta are PSF lengths, gamma and delta PSF lengths per
/// field², phi PSF length per field. (alpha, beta, gamma, delta) and minus all four give the same PSF.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReducedNumbers {
    /// Defocus: radius of the on-axis disc. The only one that depends on depth for fixed B..F.
    pub alpha: f64,
    /// Spherical aberration.
    pub beta: f64,
    /// Astigmatism.
    pub gamma: f64,
    /// Field curvature (sagittal).
    pub delta: f64,
    /// Coma.
    pub phi: f64,
}

impl ReducedNumbers {
    /// Returns S1..S10 (docs/background/model.md section 4).
    pub fn coefficients(&self) -> MomentCoefficients {
        let Self {
            alpha: a,
            beta: b,
            gamma: g,
            delta: d,
            phi: p,
        } = *self;
        let k = a / 2.0 + b / 3.0;
        MomentCoefficients([
            a * a / 4.0 + a * b / 3.0 + b * b / 8.0,
            g * k + p * p / 3.0,
            d * k + p * p / 6.0,
            g * (g + 2.0 * d) / 4.0,
            d * d / 4.0,
            -p * (g + d) * (g + d) / 6.0,
            -p * (g + d) * (g + 2.0 * d) / 6.0,
            -p * (g + d) * (a + 7.0 * b / 8.0) - p.powi(3) / 4.0,
            -p * (a * (g + 2.0 * d) / 6.0 + b * (3.0 * g + 7.0 * d) / 24.0) - p.powi(3) / 12.0,
            -p * (a * a / 6.0 + 7.0 * a * b / 24.0 + b * b / 8.0),
        ])
    }

    /// Returns the five numbers whose S1..S10 are closest to `s` over a field of radius `field_radius`.
    ///
    /// Evaluates the closed form of docs/background/model.md section 4 with all four choices of sign and keeps the
    /// best match; delta >= 0 by convention. `None` if S4 + S5 is not positive, as for a lens without astigmatism and
    /// field curvature: these moments then do not determine the numbers. The result is a start for least squares.
    pub fn from_coefficients(s: &MomentCoefficients, field_radius: f64) -> Option<Self> {
        let misfit = |numbers: &Self| numbers.coefficients().distance(s, field_radius);
        Self::branches(s)?
            .into_iter()
            .min_by(|a, b| misfit(a).total_cmp(&misfit(b)))
    }

    /// Returns all four sign choices of the closed form (docs/background/model.md section 4), with delta >= 0: two of
    /// gamma + delta, and for each two of beta.
    ///
    /// `None` like [`ReducedNumbers::from_coefficients`].
    pub fn branches(s: &MomentCoefficients) -> Option<[Self; 4]> {
        let [s1, s2, s3, s4, s5, s6, ..] = s.0;
        let sum = s4 + s5;
        if !(sum > 0.0 && s5 >= 0.0) {
            return None;
        }
        let delta = 2.0 * s5.sqrt();
        let phi = -1.5 * s6 / sum;
        let meridional = 2.0 * sum.sqrt();
        Some(
            [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(first, second)| {
                let gamma = first * meridional - delta;
                let k = (gamma * (s2 - phi * phi / 3.0) + delta * (s3 - phi * phi / 6.0))
                    / (gamma * gamma + delta * delta);
                let beta = second * (72.0 * (s1 - k * k).max(0.0)).sqrt();
                Self {
                    alpha: 2.0 * (k - beta / 3.0),
                    beta,
                    gamma,
                    delta,
                    phi,
                }
            }),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_recovers_the_numbers_up_to_pupil_inversion() {
        for signs in 0..16 {
            let sign = |bit: u32| if signs & (1 << bit) == 0 { 1.0 } else { -1.0 };
            let numbers = ReducedNumbers {
                alpha: 3.0 * sign(0),
                beta: 1.2 * sign(1),
                gamma: 0.7 * sign(2),
                delta: 0.4,
                phi: 0.3 * sign(3),
            };
            let found = ReducedNumbers::from_coefficients(&numbers.coefficients(), 1.0)
                .expect("astigmatic");
            for (got, want) in [
                (found.alpha, numbers.alpha),
                (found.beta, numbers.beta),
                (found.gamma, numbers.gamma),
                (found.delta, numbers.delta),
                (found.phi, numbers.phi),
            ] {
                assert!((got - want).abs() < 1e-9, "{found:?} for {numbers:?}");
            }
        }
    }

    #[test]
    fn the_branches_hold_the_lens_and_share_s4_and_s5() {
        let numbers = ReducedNumbers {
            alpha: 3.0,
            beta: -1.2,
            gamma: 0.7,
            delta: 0.4,
            phi: 0.3,
        };
        let s = numbers.coefficients();
        let branches = ReducedNumbers::branches(&s).expect("astigmatic");
        for branch in branches {
            for k in [3, 4] {
                let got = branch.coefficients().0[k];
                assert!((got - s.0[k]).abs() < 1e-12, "S{}: {branch:?}", k + 1);
            }
        }
        assert!(
            (branches[1].beta - numbers.beta).abs() < 1e-9,
            "{branches:?}"
        );
    }

    #[test]
    fn least_on_axis_variance_is_beta_squared_over_72() {
        let numbers = ReducedNumbers {
            alpha: -2.0,
            beta: 3.0,
            ..ReducedNumbers::default()
        };
        assert!((numbers.coefficients().0[0] - 9.0 / 72.0).abs() < 1e-15);
    }

    #[test]
    fn without_astigmatism_and_curvature_there_is_no_inverse() {
        let coma = ReducedNumbers {
            alpha: 1.0,
            phi: 0.5,
            ..ReducedNumbers::default()
        };
        assert_eq!(
            ReducedNumbers::from_coefficients(&coma.coefficients(), 1.0),
            None
        );
    }
}

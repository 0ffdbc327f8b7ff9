//! Fourth central moments of a third-order lens (docs/background/model.md section 8).

use super::ReducedNumbers;
use crate::field::FieldPoint;
use crate::moments::FourthMoments;

/// The twelve coefficients of the fourth moments over the field, functions of the five [`ReducedNumbers`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourthCoefficients {
    /// W0, W2, W4, W6, W8: the isotropic part by even powers of field radius.
    pub w: [f64; 5],
    /// Q0, Q2, Q4, Q6.
    pub q: [f64; 4],
    /// P0, P2, P4.
    pub p: [f64; 3],
}

impl ReducedNumbers {
    /// Returns the twelve coefficients of the fourth moments (docs/background/model.md section 8).
    pub fn fourth_coefficients(&self) -> FourthCoefficients {
        FourthCoefficients::new(self)
    }
}

impl FourthCoefficients {
    fn new(numbers: &ReducedNumbers) -> Self {
        let ReducedNumbers {
            alpha: a,
            beta: k,
            gamma: g,
            delta: d,
            phi,
        } = *numbers;
        let p2 = phi * phi;
        let (a2, a3, a4) = (a * a, a * a * a, a * a * a * a);
        let (k2, k3, k4) = (k * k, k * k * k, k * k * k * k);
        // Polynomials in defocus and spherical aberration common to several coefficients.
        let cubic = 20.0 * a3 + 45.0 * a2 * k + 36.0 * a * k2 + 10.0 * k3;
        let square = 10.0 * a2 + 15.0 * a * k + 6.0 * k2;
        let line = 4.0 * a + 3.0 * k;
        Self {
            w: [
                (35.0 * a4 + 105.0 * a3 * k + 126.0 * a2 * k2 + 70.0 * a * k3 + 15.0 * k4) / 840.0,
                (d * cubic + p2 * (15.0 * a2 + 24.0 * a * k + 10.0 * k2)) / 120.0,
                (d * d * square + p2 * d * (10.0 * a + 8.0 * k) + p2 * p2) / 40.0,
                d * d * (d * line + 3.0 * p2) / 24.0,
                d.powi(4) / 24.0,
            ],
            q: [
                (g * cubic + p2 * (40.0 * a2 + 68.0 * a * k + 30.0 * k2)) / 240.0,
                (g * (6.0 * d + g) * square
                    + p2 * (d * (80.0 * a + 68.0 * k) + g * (70.0 * a + 60.0 * k))
                    + 16.0 * p2 * p2)
                    / 240.0,
                (g * d * (3.0 * d + g) * line + p2 * (8.0 * d * d + 14.0 * d * g + 3.0 * g * g))
                    / 48.0,
                d * d * g * (2.0 * d + g) / 24.0,
            ],
            p: [
                (g * g * square + p2 * g * (20.0 * a + 16.0 * k) + 4.0 * p2 * p2) / 20.0,
                g * (g * (2.0 * d + g) * line + 8.0 * p2 * (d + g)) / 8.0,
                (g * (2.0 * d + g)).powi(2) / 8.0,
            ],
        }
    }

    /// Returns the fourth central moments at field point `at`, in image axes.
    pub fn moments(&self, at: FieldPoint) -> FourthMoments {
        let FieldPoint { x, y } = at;
        let r2 = x * x + y * y;
        let series = |c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum * r2 + c);
        let (w, q, p) = (series(&self.w), series(&self.q), series(&self.p));
        let (x2, y2, xy) = (x * x, y * y, x * y);
        FourthMoments {
            mu40: p * x2 * x2 + 6.0 * q * x2 + 3.0 * w,
            mu31: p * x2 * xy + 3.0 * q * xy,
            mu22: p * x2 * y2 + q * r2 + w,
            mu13: p * xy * y2 + 3.0 * q * xy,
            mu04: p * y2 * y2 + 6.0 * q * y2 + 3.0 * w,
        }
    }
}

//! S1..S10: the polynomial coefficients of second and third moments over the field (Eqs 18-24).

use crate::field::FieldPoint;
use crate::moments::{CentralMoments, MeridionalMoments};

/// Degree in field position of the polynomial that each of S1..S10 multiplies.
pub const BASIS_DEGREE: [i32; 10] = [0, 2, 2, 4, 4, 5, 5, 3, 3, 1];

/// Order of the moments that each of S1..S10 enters: 2 or 3.
pub const MOMENT_ORDER: [i32; 10] = [2, 2, 2, 2, 2, 3, 3, 3, 3, 3];

/// S1..S10 of one channel at one depth in the X-frame: S_k is in PSF px to [`MOMENT_ORDER`] per field
/// unit to [`BASIS_DEGREE`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MomentCoefficients(pub [f64; 10]);

impl MomentCoefficients {
    /// Returns the 7 x 10 matrix of the linear system moments = matrix . S at field point `at` (Eqs 18-24).
    ///
    /// Rows are mu20, mu11, mu02, mu30, mu21, mu12, mu03; columns are S1..S10.
    pub fn basis(at: FieldPoint) -> [[f64; 10]; 7] {
        let FieldPoint { x, y } = at;
        let r2 = x * x + y * y;
        let r4 = r2 * r2;
        // Third moments are P x_i x_j x_k + Q (x_i d_jk + x_j d_ik + x_k d_ij), with
        // P = S8 - 3 S9 + (6 S6 - 3 S7) r2 and Q = S10 + S9 r2 + (S7 - S6) r4.
        let third = |p: f64, q: f64| {
            [
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                6.0 * r2 * p - r4 * q,
                -3.0 * r2 * p + r4 * q,
                p,
                -3.0 * p + r2 * q,
                q,
            ]
        };
        [
            [1.0, x * x, r2, r2 * x * x, r4, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, x * y, 0.0, r2 * x * y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, y * y, r2, r2 * y * y, r4, 0.0, 0.0, 0.0, 0.0, 0.0],
            third(x * x * x, 3.0 * x),
            third(x * x * y, y),
            third(x * y * y, x),
            third(y * y * y, 3.0 * y),
        ]
    }

    /// Returns the second and third central moments at field point `at`, in image axes.
    pub fn moments(&self, at: FieldPoint) -> CentralMoments {
        let [s1, s2, s3, s4, s5, s6, s7, s8, s9, s10] = self.0;
        let FieldPoint { x, y } = at;
        let r2 = x * x + y * y;
        let round = s1 + r2 * (s3 + s5 * r2);
        let long = s2 + s4 * r2;
        let p = s8 - 3.0 * s9 + (6.0 * s6 - 3.0 * s7) * r2;
        let q = s10 + r2 * (s9 + (s7 - s6) * r2);
        CentralMoments {
            mu20: round + long * x * x,
            mu11: long * x * y,
            mu02: round + long * y * y,
            mu30: x * (p * x * x + 3.0 * q),
            mu21: y * (p * x * x + q),
            mu12: x * (p * y * y + q),
            mu03: y * (p * y * y + 3.0 * q),
        }
    }

    /// Returns the moments at field radius `h`, in the meridional frame.
    pub fn meridional(&self, h: f64) -> MeridionalMoments {
        let m = self.moments(FieldPoint::new(h, 0.0));
        MeridionalMoments {
            mu20: m.mu20,
            mu02: m.mu02,
            mu30: m.mu30,
            mu12: m.mu12,
        }
    }

    /// Returns the coefficients with PSF lengths multiplied by `psf` and field lengths by `field`: for example, a
    /// conversion from millimetres for both to pixels and half frame widths.
    #[must_use]
    pub fn rescaled(&self, psf: f64, field: f64) -> Self {
        let mut s = self.0;
        for (k, value) in s.iter_mut().enumerate() {
            *value *= psf.powi(MOMENT_ORDER[k]) / field.powi(BASIS_DEGREE[k]);
        }
        Self(s)
    }

    /// Returns the coefficients with `variance_px2` added to the PSF at all field positions: only S1 changes.
    #[must_use]
    pub fn with_added_variance(&self, variance_px2: f64) -> Self {
        let mut s = *self;
        s.0[0] += variance_px2;
        s
    }

    /// Returns the smallest meridional or sagittal variance up to `field_radius`, px².
    pub fn least_variance(&self, field_radius: f64) -> f64 {
        let [s1, s2, s3, s4, s5, ..] = self.0;
        // Both variances are quadratic in h²: the minimum is at an end or at the vertex.
        let end = field_radius * field_radius;
        let least = |a: f64, b: f64, c: f64| {
            let at = |t: f64| a + t * (b + t * c);
            let vertex = if c > 0.0 {
                (-b / (2.0 * c)).clamp(0.0, end)
            } else {
                0.0
            };
            at(0.0).min(at(end)).min(at(vertex))
        };
        least(s1, s3, s5).min(least(s1, s2 + s3, s4 + s5))
    }

    /// Returns the root mean square difference to `other`, without unit.
    ///
    /// Each coefficient is weighted by its contribution to the moments at `field_radius`, relative to the size of the
    /// PSF there.
    pub fn distance(&self, other: &Self, field_radius: f64) -> f64 {
        let m = other.meridional(field_radius);
        let size = (other.0[0].abs() + m.mu20.abs() + m.mu02.abs())
            .sqrt()
            .max(f64::MIN_POSITIVE);
        let sum: f64 = (0..10)
            .map(|k| {
                let unit = size.powi(MOMENT_ORDER[k]) / field_radius.powi(BASIS_DEGREE[k]);
                ((self.0[k] - other.0[k]) / unit).powi(2)
            })
            .sum();
        (sum / 10.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: MomentCoefficients =
        MomentCoefficients([9.0, 1.5, -0.8, 0.4, 0.3, 0.2, -0.1, 0.7, 0.25, -0.6]);

    #[test]
    fn basis_times_coefficients_is_the_moments() {
        for (x, y) in [(0.3, -0.5), (0.0, 0.0), (-0.9, 0.2), (0.0, 0.7)] {
            let at = FieldPoint::new(x, y);
            let want = S.moments(at).to_array();
            for (row, want) in MomentCoefficients::basis(at).iter().zip(want) {
                let got: f64 = row.iter().zip(S.0).map(|(b, s)| b * s).sum();
                assert!((got - want).abs() < 1e-14, "{got} {want}");
            }
        }
    }

    #[test]
    fn basis_equals_the_printed_equations() {
        // Eqs 18-24 term by term, at a point with no symmetry of its own.
        let (x, y) = (0.37_f64, -0.62_f64);
        let r2 = x * x + y * y;
        let (x2, y2) = (x * x, y * y);
        let (x4, y4) = (x2 * x2, y2 * y2);
        let printed_mu30 = [
            3.0 * x4 * x - 3.0 * x * y4,
            3.0 * x2 * x * y2 + 3.0 * x * y4,
            x2 * x,
            3.0 * x * y2,
            3.0 * x,
        ];
        let printed_mu21 = [
            5.0 * x4 * y + 4.0 * x2 * y2 * y - y4 * y,
            y4 * y - 2.0 * x4 * y - x2 * y2 * y,
            x2 * y,
            y2 * y - 2.0 * x2 * y,
            y,
        ];
        let basis = MomentCoefficients::basis(FieldPoint::new(x, y));
        for k in 0..5 {
            assert!(
                (basis[3][5 + k] - printed_mu30[k]).abs() < 1e-14,
                "mu30 {k}"
            );
            assert!(
                (basis[4][5 + k] - printed_mu21[k]).abs() < 1e-14,
                "mu21 {k}"
            );
        }
        assert!((basis[0][3] - (x4 + x2 * y2)).abs() < 1e-14);
        assert!((basis[0][4] - r2 * r2).abs() < 1e-14);
    }

    #[test]
    fn least_variance_finds_the_vertex() {
        // Sagittal variance 1 - 4 t + 4 t², t = h²: zero at t = 1/2.
        let s = MomentCoefficients([1.0, 0.0, -4.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(s.least_variance(1.0).abs() < 1e-15);
        assert!(s.least_variance(0.5) > 0.2);
        assert!(s.with_added_variance(-0.1).least_variance(1.0) < 0.0);
    }
}

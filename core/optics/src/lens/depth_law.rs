//! S1..S10 over depth, as polynomials in vergence v (docs/background/model.md section 5a).
//!
//! If the aberrations of a lens do not change with depth, S1..S10 are polynomials of exactly the degrees
//! [`DEGREE_IN_VERGENCE`]. Aberrations of real lenses change (section 5b); these degrees then fail near focus, where
//! small moments are differences of large ones. A quadratic for every S is close: within a few per cent on real designs
//! with one of five planes left out. So the degrees of 5a are used if the planes agree with them, quadratics otherwise.
//! Linear interpolation of S would be wrong by tens of per cent.

use nalgebra::{DMatrix, DVector};

use super::{BASIS_DEGREE, MOMENT_ORDER, MomentCoefficients};
use crate::error::{Error, Result};

/// Degrees of S1..S10 (X-frame) in v = 1 / distance, for a lens whose aberrations do not change with depth.
pub const DEGREE_IN_VERGENCE: [usize; 10] = [2, 1, 1, 0, 0, 0, 0, 1, 1, 2];

/// Degree of every S if aberrations change with depth.
const CHANGING_DEGREE: usize = 2;
/// Planes agree with the degrees of 5a within this share of the PSF size to the power of the order of the moment...
const AGREEMENT_SHARE: f64 = 0.005;
/// ...or within this many standard errors.
const AGREEMENT_SIGMAS: f64 = 3.0;
/// Field radius at which the shares are computed, half frame widths.
const AGREEMENT_FIELD: f64 = 1.0;

/// S1..S10 fitted at one object distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthPlane {
    /// Vergence of the object, 1/m.
    pub vergence_per_m: f64,
    /// S1..S10 at that vergence.
    pub s: MomentCoefficients,
    /// Their standard errors; zero if unknown.
    pub s_sigma: [f64; 10],
}

/// S1..S10 as functions of object vergence, exact at the planes that they were fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthLaw {
    /// Coefficients of each S_k by increasing power of v (1/m).
    polynomials: [Vec<f64>; 10],
    /// Residuals of the polynomials at each plane, by increasing vergence; interpolated linearly between planes.
    remainders: Vec<(f64, [f64; 10])>,
    aberrations_change: bool,
}

impl DepthLaw {
    /// Fits the law to `planes`.
    ///
    /// `defocus` is Z2 R / M in PSF px per 1/m, if the camera is known. Its square over 4 is the v² coefficient of S1,
    /// which two planes cannot determine.
    ///
    /// # Errors
    /// Rejects an empty list, two planes at one vergence, and values that are not finite.
    pub fn fit(planes: &[DepthPlane], defocus: Option<f64>) -> Result<Self> {
        check(planes)?;
        let mut planes = planes.to_vec();
        planes.sort_by(|a, b| a.vergence_per_m.total_cmp(&b.vergence_per_m));
        let constant = Self::of_degrees(&planes, DEGREE_IN_VERGENCE, defocus)?;
        if planes.len() <= CHANGING_DEGREE || constant.agrees(&planes) {
            return Ok(constant);
        }
        let mut changing = Self::of_degrees(&planes, [CHANGING_DEGREE; 10], None)?;
        changing.aberrations_change = true;
        Ok(changing)
    }

    /// Returns S1..S10 at vergence `v`, 1/m.
    pub fn at(&self, v: f64) -> MomentCoefficients {
        let (before, after, share) = self.bracket(v);
        MomentCoefficients(std::array::from_fn(|k| {
            self.polynomial(k, v) + before[k] + share * (after[k] - before[k])
        }))
    }

    /// Returns whether aberrations change with depth: the planes differ by more than defocus.
    pub fn aberrations_change(&self) -> bool {
        self.aberrations_change
    }

    /// Returns the S_k (1-based) whose dependence on depth needs more planes.
    pub fn undetermined(&self) -> Vec<usize> {
        (0..10)
            .filter(|&k| self.polynomials[k].len() <= DEGREE_IN_VERGENCE[k])
            .map(|k| k + 1)
            .collect()
    }

    fn polynomial(&self, k: usize, v: f64) -> f64 {
        self.polynomials[k]
            .iter()
            .rev()
            .fold(0.0, |sum, coefficient| sum * v + coefficient)
    }

    /// Returns the residuals on both sides of `v` and the interpolation weight of the second.
    fn bracket(&self, v: f64) -> (&[f64; 10], &[f64; 10], f64) {
        let after = self.remainders.partition_point(|(at, _)| *at < v);
        let last = self.remainders.len() - 1;
        if after == 0 || after > last {
            let end = &self.remainders[after.min(last)].1;
            return (end, end, 0.0);
        }
        let ((low, before), (high, beyond)) =
            (&self.remainders[after - 1], &self.remainders[after]);
        (before, beyond, (v - low) / (high - low))
    }

    fn of_degrees(
        planes: &[DepthPlane],
        degrees: [usize; 10],
        defocus: Option<f64>,
    ) -> Result<Self> {
        let allowed = planes.len() - 1;
        let mut polynomials: [Vec<f64>; 10] = std::array::from_fn(|_| Vec::new());
        for (k, polynomial) in polynomials.iter_mut().enumerate() {
            let known = match defocus {
                Some(slope) if k == 0 && allowed == 1 => Some(slope * slope / 4.0),
                _ => None,
            };
            let points: Vec<(f64, f64)> = planes
                .iter()
                .map(|plane| {
                    let v = plane.vergence_per_m;
                    (v, plane.s.0[k] - known.unwrap_or(0.0) * v * v)
                })
                .collect();
            *polynomial = least_squares_polynomial(&points, degrees[k].min(allowed))?;
            polynomial.extend(known);
        }
        let mut law = Self {
            polynomials,
            remainders: Vec::new(),
            aberrations_change: false,
        };
        law.remainders = planes
            .iter()
            .map(|plane| {
                let v = plane.vergence_per_m;
                let rest = std::array::from_fn(|k| plane.s.0[k] - law.polynomial(k, v));
                (v, rest)
            })
            .collect();
        Ok(law)
    }

    /// Returns whether every plane agrees with the polynomials within the tolerances.
    fn agrees(&self, planes: &[DepthPlane]) -> bool {
        planes
            .iter()
            .zip(&self.remainders)
            .all(|(plane, (_, rest))| {
                let m = plane.s.meridional(AGREEMENT_FIELD);
                let size = (m.mu20.abs() + m.mu02.abs()).sqrt();
                (0..10).all(|k| {
                    let share = rest[k].abs() * AGREEMENT_FIELD.powi(BASIS_DEGREE[k]);
                    share <= AGREEMENT_SHARE * size.powi(MOMENT_ORDER[k])
                        || rest[k].abs() <= AGREEMENT_SIGMAS * plane.s_sigma[k]
                })
            })
    }
}

fn check(planes: &[DepthPlane]) -> Result<()> {
    if planes.is_empty() {
        return Err(Error::new(
            "depth law",
            "has no plane",
            "fit at least one object distance",
        ));
    }
    for (index, plane) in planes.iter().enumerate() {
        let v = plane.vergence_per_m;
        if !v.is_finite() || plane.s.0.iter().any(|x| !x.is_finite()) {
            return Err(Error::new(
                format!("depth plane {index}"),
                format!("holds a number that is not finite (v = {v})"),
                "check the observations at that distance",
            ));
        }
        if planes[..index].iter().any(|p| p.vergence_per_m == v) {
            return Err(Error::new(
                format!("depth plane {index}"),
                format!("has the same vergence {v} 1/m as another"),
                "merge the observations of one distance into one plane",
            ));
        }
    }
    Ok(())
}

/// Returns the least-squares polynomial of `degree` through points (x, y), by increasing power.
///
/// Points have equal weight: weights by PSF size did worse at focus, where sizes differ most.
fn least_squares_polynomial(points: &[(f64, f64)], degree: usize) -> Result<Vec<f64>> {
    let matrix = DMatrix::from_fn(points.len(), degree + 1, |r, c| points[r].0.powi(c as i32));
    let target = DVector::from_fn(points.len(), |r, _| points[r].1);
    let solution = matrix
        .svd(true, true)
        .solve(&target, 1e-14)
        .map_err(|problem| {
            Error::new(
                "depth law",
                problem,
                "give object distances that differ more",
            )
        })?;
    Ok(solution.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::ReducedNumbers;

    fn plane_of(v: f64, gamma: f64) -> DepthPlane {
        let numbers = ReducedNumbers {
            alpha: 40.0 * (v - 0.5),
            beta: 1.5,
            gamma,
            delta: 0.9,
            phi: 0.4,
        };
        DepthPlane {
            vergence_per_m: v,
            s: numbers.coefficients(),
            s_sigma: [0.0; 10],
        }
    }

    fn plane(v: f64) -> DepthPlane {
        plane_of(v, -0.6)
    }

    #[test]
    fn two_planes_and_the_camera_do_what_three_planes_do() {
        let two = DepthLaw::fit(&[plane(0.0), plane(0.9)], Some(40.0)).expect("valid");
        let three = DepthLaw::fit(&[plane(0.0), plane(0.4), plane(0.9)], None).expect("valid");
        assert_eq!(three.undetermined(), Vec::<usize>::new());
        assert_eq!(two.undetermined(), vec![10]);
        for v in [0.1, 0.5, 0.7, 1.4] {
            let (a, b) = (two.at(v), three.at(v));
            for k in 0..9 {
                assert!((a.0[k] - b.0[k]).abs() < 1e-10, "S{} at {v}", k + 1);
            }
        }
    }

    #[test]
    fn one_plane_is_constant_and_reports_undetermined_coefficients() {
        let one = DepthLaw::fit(&[plane(0.3)], None).expect("valid");
        assert_eq!(one.at(2.0), one.at(0.0));
        assert_eq!(one.undetermined(), vec![1, 2, 3, 8, 9, 10]);
    }

    #[test]
    fn invalid_planes_are_rejected() {
        assert!(DepthLaw::fit(&[], None).is_err());
        assert!(DepthLaw::fit(&[plane(0.3), plane(0.3)], None).is_err());
        assert!(DepthLaw::fit(&[plane(f64::NAN)], None).is_err());
    }

    #[test]
    fn changing_aberrations_are_detected_and_planes_reproduced_exactly() {
        let steady: Vec<_> = [0.0, 0.2, 0.5, 0.9].map(plane).to_vec();
        assert!(
            !DepthLaw::fit(&steady, None)
                .expect("valid")
                .aberrations_change()
        );
        let changing: Vec<_> = [0.0, 0.2, 0.5, 0.9]
            .map(|v| plane_of(v, -0.6 + 0.8 * v * v))
            .to_vec();
        let law = DepthLaw::fit(&changing, None).expect("valid");
        assert!(law.aberrations_change());
        for plane in &changing {
            let got = law.at(plane.vergence_per_m);
            for k in 0..10 {
                assert!((got.0[k] - plane.s.0[k]).abs() < 1e-12);
            }
        }
        // Between planes: a plane left out is predicted to a few per cent of its size.
        let left_out = plane_of(0.35, -0.6 + 0.8 * 0.35 * 0.35);
        let m = law.at(0.35).meridional(0.8);
        let want = left_out.s.meridional(0.8);
        assert!((m.mu20.sqrt() / want.mu20.sqrt() - 1.0).abs() < 0.03);
        assert!((m.mu02.sqrt() / want.mu02.sqrt() - 1.0).abs() < 0.03);
    }
}

//! S1..S10 across depth: polynomials in vergence v of the degrees that the model gives them
//! (model.md section 5a). Never linear interpolation of S, which is wrong by tens of per cent.

use nalgebra::{DMatrix, DVector};

use super::MomentCoefficients;
use crate::error::{Error, Result};

/// Degree in v = 1 / distance of each of S1..S10 in the X-frame, for a lens whose aberrations do not
/// change with depth.
pub const DEGREE_IN_VERGENCE: [usize; 10] = [2, 1, 1, 0, 0, 0, 0, 1, 1, 2];

/// S1..S10 as polynomials of object vergence.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthLaw {
    /// Coefficients of each S_k by rising power of v (1/m); as many as its degree plus one, fewer
    /// where the planes do not allow it.
    pub polynomials: [Vec<f64>; 10],
}

impl DepthLaw {
    /// The law through `planes`, pairs of vergence (1/m) and S1..S10: exact where there are as few
    /// planes as coefficients, least squares otherwise. Each plane counts by the inverse of its PSF
    /// size, so that planes near focus, whose small moments matter most, are met as closely in
    /// proportion as far ones.
    ///
    /// # Errors
    /// No plane, two planes at one vergence, or values that are not finite.
    pub fn fit(planes: &[(f64, MomentCoefficients)]) -> Result<Self> {
        Self::fit_with_defocus(planes, None)
    }

    /// As [`DepthLaw::fit`], the v² coefficient of S1 being known from the camera where the planes
    /// are too few to find it: `defocus` = Z2 R / M in PSF px per 1/m, of which it is the square / 4.
    ///
    /// # Errors
    /// As [`DepthLaw::fit`].
    pub fn fit_with_defocus(
        planes: &[(f64, MomentCoefficients)],
        defocus: Option<f64>,
    ) -> Result<Self> {
        check(planes)?;
        let mut polynomials: [Vec<f64>; 10] = std::array::from_fn(|_| Vec::new());
        for (k, polynomial) in polynomials.iter_mut().enumerate() {
            let law = DEGREE_IN_VERGENCE[k];
            let allowed = planes.len() - 1;
            let known = match defocus {
                Some(slope) if k == 0 && allowed == 1 => Some(slope * slope / 4.0),
                _ => None,
            };
            let points: Vec<(f64, f64, f64)> = planes
                .iter()
                .map(|(v, s)| {
                    let value = s.0[k] - known.unwrap_or(0.0) * v * v;
                    (*v, value, 1.0 / plane_size(s).powi(super::MOMENT_ORDER[k]))
                })
                .collect();
            *polynomial = weighted_polynomial(&points, law.min(allowed))?;
            polynomial.extend(known);
        }
        Ok(Self { polynomials })
    }

    /// S1..S10 at vergence `v`, 1/m.
    pub fn at(&self, v: f64) -> MomentCoefficients {
        MomentCoefficients(std::array::from_fn(|k| {
            self.polynomials[k]
                .iter()
                .rev()
                .fold(0.0, |sum, coefficient| sum * v + coefficient)
        }))
    }

    /// The S_k (1-based) whose dependence on depth the planes were too few to find.
    pub fn undetermined(&self) -> Vec<usize> {
        (0..10)
            .filter(|&k| self.polynomials[k].len() <= DEGREE_IN_VERGENCE[k])
            .map(|k| k + 1)
            .collect()
    }
}

/// PSF size (px) of a plane over the field out to one half frame width.
fn plane_size(s: &MomentCoefficients) -> f64 {
    let m = s.meridional(0.7);
    (m.mu20.abs() + m.mu02.abs()).sqrt().max(1e-3)
}

fn check(planes: &[(f64, MomentCoefficients)]) -> Result<()> {
    if planes.is_empty() {
        return Err(Error::new(
            "depth law",
            "has no plane",
            "fit at least one object distance",
        ));
    }
    for (index, (v, s)) in planes.iter().enumerate() {
        if !v.is_finite() || s.0.iter().any(|x| !x.is_finite()) {
            return Err(Error::new(
                format!("depth plane {index}"),
                format!("holds a number that is not finite (v = {v})"),
                "check the observations at that distance",
            ));
        }
        if planes[..index].iter().any(|(other, _)| other == v) {
            return Err(Error::new(
                format!("depth plane {index}"),
                format!("has the same vergence {v} 1/m as another"),
                "merge the observations of one distance into one plane",
            ));
        }
    }
    Ok(())
}

/// Least-squares polynomial of `degree` through points (x, y, weight), by rising power.
fn weighted_polynomial(points: &[(f64, f64, f64)], degree: usize) -> Result<Vec<f64>> {
    let rows = points.len();
    let matrix = DMatrix::from_fn(rows, degree + 1, |r, c| {
        points[r].2 * points[r].0.powi(c as i32)
    });
    let target = DVector::from_fn(rows, |r, _| points[r].2 * points[r].1);
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

    fn plane(v: f64) -> (f64, MomentCoefficients) {
        let numbers = ReducedNumbers {
            alpha: 40.0 * (v - 0.5),
            beta: 1.5,
            gamma: -0.6,
            delta: 0.9,
            phi: 0.4,
        };
        (v, numbers.coefficients())
    }

    #[test]
    fn two_planes_and_the_camera_do_what_three_planes_do() {
        let two = DepthLaw::fit_with_defocus(&[plane(0.0), plane(0.9)], Some(40.0)).expect("valid");
        let three = DepthLaw::fit(&[plane(0.0), plane(0.4), plane(0.9)]).expect("valid");
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
    fn one_plane_is_constant_and_says_what_it_cannot_know() {
        let one = DepthLaw::fit(&[plane(0.3)]).expect("valid");
        assert_eq!(one.at(2.0), one.at(0.0));
        assert_eq!(one.undetermined(), vec![1, 2, 3, 8, 9, 10]);
    }

    #[test]
    fn planes_that_cannot_be_are_refused() {
        assert!(DepthLaw::fit(&[]).is_err());
        assert!(DepthLaw::fit(&[plane(0.3), plane(0.3)]).is_err());
        assert!(DepthLaw::fit(&[(f64::NAN, MomentCoefficients::default())]).is_err());
    }
}

//! The wavefront over the pupil of one image point: a polynomial whose slope gives the landing points of rays.
//!
//! The third order comes from the five [`ReducedNumbers`]; effects add further terms. With u in the unit pupil disc, W
//! is scaled so that `P(u) = grad W(u)` is the ray's offset on the sensor in px.

mod radial;

pub(super) use radial::{Directions, SlopesAlong};

use super::ReducedNumbers;
use crate::field::{FieldPoint, Meridian};

/// Largest degree of a wavefront polynomial: that of seventh-order aberrations.
pub const DEGREE: usize = 8;

/// Number of monomials `u_x^i u_y^j` with 1 <= i + j <= [`DEGREE`].
pub const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2 - 1;

/// The wavefront of one image point in one channel, in image axes; its slope is in px.
#[derive(Debug, Clone, Copy)]
pub struct Wavefront {
    /// Coefficients of `u_x^i u_y^j`, by rising degree i + j and within it by rising j.
    coefficients: [f64; TERMS],
    /// Degree above which all coefficients are zero: most lenses need no more than third order.
    degree: usize,
}

impl Default for Wavefront {
    fn default() -> Self {
        Self {
            coefficients: [0.0; TERMS],
            degree: 1,
        }
    }
}

impl PartialEq for Wavefront {
    fn eq(&self, other: &Self) -> bool {
        self.coefficients == other.coefficients
    }
}

/// Returns the index of `u_x^i u_y^j` among the coefficients.
const fn index(i: usize, j: usize) -> usize {
    let n = i + j;
    n * (n + 1) / 2 - 1 + j
}

/// Returns the powers (i, j) of every coefficient, in order.
pub fn powers() -> impl Iterator<Item = (usize, usize)> {
    powers_up_to(DEGREE)
}

/// Returns the powers (i, j) of the coefficients up to `degree`, in order.
fn powers_up_to(degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (1..=degree).flat_map(|n| (0..=n).map(move |j| (n - j, j)))
}

impl Wavefront {
    /// Returns the wavefront of a third-order lens at field position `at`: Eqs 5-6 without distortion.
    pub fn third_order(numbers: &ReducedNumbers, at: FieldPoint) -> Self {
        let mut sum = Self::default();
        let (h, meridian) = (at.radius(), at.meridian());
        let h2 = h * h;
        sum.add(1, 0, meridian, (numbers.alpha + numbers.delta * h2) / 2.0);
        sum.add(2, 0, meridian, numbers.beta / 4.0);
        sum.add(0, 2, meridian, numbers.gamma * h2 / 2.0);
        sum.add(1, 1, meridian, -numbers.phi * h);
        sum
    }

    /// Adds the term `coefficient |u|^(2 round) (u.m)^along`, with m the direction of `meridian`.
    ///
    /// # Panics
    /// If the term's degree is zero or above [`DEGREE`].
    pub fn add(&mut self, round: usize, along: usize, meridian: Meridian, coefficient: f64) {
        let degree = 2 * round + along;
        assert!(
            (1..=DEGREE).contains(&degree),
            "a wavefront term has degree 1 to {DEGREE}, not {degree}"
        );
        self.degree = self.degree.max(degree);
        for k in 0..=round {
            for j in 0..=along {
                let share = binomial(round, k)
                    * binomial(along, j)
                    * meridian.cos.powi((along - j) as i32)
                    * meridian.sin.powi(j as i32);
                let (i, j) = (2 * (round - k) + along - j, 2 * k + j);
                self.coefficients[index(i, j)] += coefficient * share;
            }
        }
    }

    /// Adds `coefficient u_x^i u_y^j`.
    ///
    /// # Panics
    /// If the term's degree is zero or above [`DEGREE`].
    pub fn add_monomial(&mut self, i: usize, j: usize, coefficient: f64) {
        assert!(
            (1..=DEGREE).contains(&(i + j)),
            "a wavefront term has degree 1 to {DEGREE}, not {}",
            i + j
        );
        self.degree = self.degree.max(i + j);
        self.coefficients[index(i, j)] += coefficient;
    }

    /// A degree above which all coefficients are zero; at least one.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The coefficients of `u_x^i u_y^j`, in the order of [`powers`].
    pub fn coefficients(&self) -> &[f64; TERMS] {
        &self.coefficients
    }

    /// The wavefront with these coefficients, in the order of [`powers`].
    pub fn from_coefficients(coefficients: [f64; TERMS]) -> Self {
        let used = powers().zip(&coefficients).filter(|(_, c)| **c != 0.0);
        let degree = used.map(|((i, j), _)| i + j).last().unwrap_or(1);
        Self {
            coefficients,
            degree,
        }
    }

    /// The tilt that moves every ray by (`dx`, `dy`) px.
    pub fn tilt(dx: f64, dy: f64) -> Self {
        let mut tilt = Self::default();
        tilt.coefficients[index(1, 0)] = dx;
        tilt.coefficients[index(0, 1)] = dy;
        tilt
    }

    /// Returns the sum of this and `factor` times `other`.
    #[must_use]
    pub fn add_scaled(&self, factor: f64, other: &Self) -> Self {
        let mut sum = *self;
        sum.degree = self.degree.max(other.degree);
        for (mine, theirs) in sum.coefficients.iter_mut().zip(&other.coefficients) {
            *mine += factor * theirs;
        }
        sum
    }

    /// Returns the wavefront on a grid with `scale` times as many pixels along each axis.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        Self {
            coefficients: self.coefficients.map(|c| c * scale),
            degree: self.degree,
        }
    }

    /// Returns the wavefront of the same lens for a pupil `ratio` times as wide.
    ///
    /// The slope of a term of degree n at the new rim changes by ratio^(n-1).
    #[must_use]
    pub fn with_pupil(&self, ratio: f64) -> Self {
        let mut changed = *self;
        for ((i, j), c) in powers().zip(&mut changed.coefficients) {
            *c *= ratio.powi((i + j) as i32 - 1);
        }
        changed
    }

    /// Returns the wavefront with u_x replaced by `ratio` u_x.
    #[must_use]
    pub fn stretched_x(&self, ratio: f64) -> Self {
        let mut changed = *self;
        for ((i, _), c) in powers().zip(&mut changed.coefficients) {
            *c *= ratio.powi(i as i32);
        }
        changed
    }

    /// Returns the wavefront mirrored along x and y, as `along` says: u_x or u_y with the other sign.
    #[must_use]
    pub fn mirrored(&self, along: [bool; 2]) -> Self {
        let mut changed = *self;
        for ((i, j), c) in powers().zip(&mut changed.coefficients) {
            let odd = (along[0] && i % 2 == 1) != (along[1] && j % 2 == 1);
            if odd {
                *c = -*c;
            }
        }
        changed
    }

    /// Returns the height W at pupil point `u`, px.
    pub fn height(&self, u: [f64; 2]) -> f64 {
        let (x, y) = (power_table(u[0]), power_table(u[1]));
        powers_up_to(self.degree)
            .zip(&self.coefficients)
            .map(|((i, j), c)| c * x[i] * y[j])
            .sum()
    }

    /// Returns the gradient of W at pupil point `u`: the landing point relative to the chief ray, px.
    #[inline]
    pub fn slope(&self, u: [f64; 2]) -> [f64; 2] {
        let (x, y) = (power_table(u[0]), power_table(u[1]));
        let c = &self.coefficients;
        let mut slope = [0.0; 2];
        for n in 1..=self.degree {
            for j in 0..=n {
                let (i, c) = (n - j, c[index(n - j, j)]);
                if i > 0 {
                    slope[0] += c * i as f64 * x[i - 1] * y[j];
                }
                if j > 0 {
                    slope[1] += c * j as f64 * x[i] * y[j - 1];
                }
            }
        }
        slope
    }

    /// Returns the mean slope over the unit disc: the centroid of an unclipped pupil, px.
    pub fn mean_slope(&self) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for ((i, j), c) in powers_up_to(self.degree).zip(&self.coefficients) {
            if i > 0 {
                sum[0] += c * i as f64 * disc_mean(i - 1, j);
            }
            if j > 0 {
                sum[1] += c * j as f64 * disc_mean(i, j - 1);
            }
        }
        sum
    }

    /// Returns the second derivatives of W (xx, xy, yy) at pupil point `u`: the Jacobian of the ray map.
    pub fn hessian(&self, u: [f64; 2]) -> [f64; 3] {
        let (x, y) = (power_table(u[0]), power_table(u[1]));
        let mut sum = [0.0; 3];
        for ((i, j), c) in powers_up_to(self.degree).zip(&self.coefficients) {
            let (a, b) = (i as f64, j as f64);
            if i > 1 {
                sum[0] += c * a * (a - 1.0) * x[i - 2] * y[j];
            }
            if i > 0 && j > 0 {
                sum[1] += c * a * b * x[i - 1] * y[j - 1];
            }
            if j > 1 {
                sum[2] += c * b * (b - 1.0) * x[i] * y[j - 2];
            }
        }
        sum
    }

    /// Returns the norm of the third derivatives of W at pupil point `u`, px: the nonlinearity of the ray map.
    pub fn third_derivative_norm(&self, u: [f64; 2]) -> f64 {
        let (x, y) = (power_table(u[0]), power_table(u[1]));
        // xxx, xxy, xyy, yyy.
        let mut sum = [0.0; 4];
        let falling = |n: usize, k: usize| (0..k).map(|m| (n - m) as f64).product::<f64>();
        for ((i, j), c) in powers_up_to(self.degree).zip(&self.coefficients) {
            for (by_y, sum) in sum.iter_mut().enumerate() {
                let by_x = 3 - by_y;
                if i >= by_x && j >= by_y {
                    *sum += c * falling(i, by_x) * falling(j, by_y) * x[i - by_x] * y[j - by_y];
                }
            }
        }
        // Each mixed derivative occurs twice among the second derivatives of the slope.
        (sum[0].powi(2) + 2.0 * (sum[1].powi(2) + sum[2].powi(2)) + sum[3].powi(2)).sqrt()
    }

    /// Returns the Laplacian of W as a polynomial, without its constant term, which has no slope.
    #[must_use]
    pub fn laplacian(&self) -> Self {
        let mut result = Self {
            degree: self.degree.saturating_sub(2).max(1),
            ..Self::default()
        };
        for ((i, j), c) in powers_up_to(self.degree).zip(&self.coefficients) {
            if i + j <= 2 {
                continue;
            }
            if i > 1 {
                result.coefficients[index(i - 2, j)] += c * (i * (i - 1)) as f64;
            }
            if j > 1 {
                result.coefficients[index(i, j - 2)] += c * (j * (j - 1)) as f64;
            }
        }
        result
    }

    /// Returns whether every coefficient is finite.
    pub fn is_finite(&self) -> bool {
        self.coefficients.iter().all(|c| c.is_finite())
    }
}

fn power_table(x: f64) -> [f64; DEGREE + 1] {
    let mut table = [1.0; DEGREE + 1];
    for k in 1..=DEGREE {
        table[k] = table[k - 1] * x;
    }
    table
}

/// Returns the mean of `u_x^a u_y^b` over the unit disc.
fn disc_mean(a: usize, b: usize) -> f64 {
    if a % 2 == 1 || b % 2 == 1 {
        return 0.0;
    }
    let odds = |n: usize| (1..n).step_by(2).map(|k| k as f64).product::<f64>();
    let evens = (2..=a + b).step_by(2).map(|k| k as f64).product::<f64>();
    odds(a) * odds(b) / evens * 2.0 / (a + b + 2) as f64
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers() -> ReducedNumbers {
        ReducedNumbers {
            alpha: 1.3,
            beta: -0.7,
            gamma: 0.4,
            delta: 0.9,
            phi: -0.5,
        }
    }

    #[test]
    fn the_slope_is_that_of_equations_5_and_6() {
        let (n, at) = (numbers(), FieldPoint::new(0.6, -0.4));
        let wavefront = Wavefront::third_order(&n, at);
        for u in [[0.2, 0.5], [-0.7, 0.1], [0.0, 0.0]] {
            let u2 = u[0] * u[0] + u[1] * u[1];
            let along = at.x * u[0] + at.y * u[1];
            let h2 = at.x * at.x + at.y * at.y;
            let radial = n.alpha + n.beta * u2 + n.delta * h2 - 2.0 * n.phi * along;
            let chief = n.gamma * along - n.phi * u2;
            let slope = wavefront.slope(u);
            assert!((slope[0] - (radial * u[0] + chief * at.x)).abs() < 1e-14);
            assert!((slope[1] - (radial * u[1] + chief * at.y)).abs() < 1e-14);
        }
    }

    #[test]
    fn slope_curvature_and_laplacian_are_derivatives_of_the_height() {
        let mut wavefront = Wavefront::third_order(&numbers(), FieldPoint::new(0.6, -0.4));
        let meridian = FieldPoint::new(0.3, 0.8).meridian();
        for (round, along) in [(3, 0), (2, 1), (1, 2), (0, 3), (1, 3), (0, 6)] {
            wavefront.add(round, along, meridian, 0.3 + along as f64 * 0.1);
        }
        let step = 1e-4;
        let laplacian = wavefront.laplacian();
        let middle = |u: [f64; 2]| {
            let c = wavefront.hessian(u);
            c[0] + c[2]
        };
        for u in [[0.2, 0.5], [-0.7, 0.1], [0.0, 0.0]] {
            let slope = wavefront.slope(u);
            let curvature = wavefront.hessian(u);
            for axis in 0..2 {
                let (mut low, mut high) = (u, u);
                low[axis] -= step;
                high[axis] += step;
                let numeric = (wavefront.height(high) - wavefront.height(low)) / (2.0 * step);
                assert!((slope[axis] - numeric).abs() < 1e-6);
                let (a, b) = (wavefront.slope(low), wavefront.slope(high));
                for other in 0..2 {
                    let numeric = (b[other] - a[other]) / (2.0 * step);
                    assert!((curvature[axis + other] - numeric).abs() < 1e-6);
                }
            }
            let constant = middle([0.0, 0.0]);
            assert!((laplacian.height(u) + constant - middle(u)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_narrower_pupil_has_the_same_wavefront() {
        let wide = Wavefront::third_order(&numbers(), FieldPoint::new(0.6, -0.4));
        let narrow = wide.with_pupil(0.5);
        let (a, b) = (narrow.slope([0.8, -0.2]), wide.slope([0.4, -0.1]));
        assert!((a[0] - b[0]).abs() < 1e-14 && (a[1] - b[1]).abs() < 1e-14);
    }
}

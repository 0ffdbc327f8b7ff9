//! Fourth central moments in image axes.

use crate::field::Meridian;
use crate::numeric::dot;

/// The fourth central moments, px⁴.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FourthMoments {
    /// Mean of x⁴.
    pub mu40: f64,
    /// Mean of x³ y.
    pub mu31: f64,
    /// Mean of x² y².
    pub mu22: f64,
    /// Mean of x y³.
    pub mu13: f64,
    /// Mean of y⁴.
    pub mu04: f64,
}

impl FourthMoments {
    /// Returns the moments in the order mu40, mu31, mu22, mu13, mu04.
    pub fn to_array(self) -> [f64; 5] {
        [self.mu40, self.mu31, self.mu22, self.mu13, self.mu04]
    }

    /// Creates the moments from the order of [`FourthMoments::to_array`].
    pub fn from_array([mu40, mu31, mu22, mu13, mu04]: [f64; 5]) -> Self {
        Self {
            mu40,
            mu31,
            mu22,
            mu13,
            mu04,
        }
    }

    /// Returns the moments in rotated axes: the new x axis lies along `meridian`, the new y axis 90° further.
    #[must_use]
    pub fn rotated_into(&self, meridian: Meridian) -> Self {
        let Meridian { cos, sin } = meridian;
        let old = self.to_array();
        Self::from_array(std::array::from_fn(|k| {
            // Expands (cos x + sin y)^(4-k) (-sin x + cos y)^k in powers of y.
            let mut polynomial = [1.0, 0.0, 0.0, 0.0, 0.0];
            for factor in 0..4 {
                let (a, b) = if factor < 4 - k {
                    (cos, sin)
                } else {
                    (-sin, cos)
                };
                for power in (0..5).rev() {
                    let lower = if power > 0 {
                        polynomial[power - 1]
                    } else {
                        0.0
                    };
                    polynomial[power] = a * polynomial[power] + b * lower;
                }
            }
            dot(&polynomial, &old)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_is_that_of_the_points() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let of = |points: &[(f64, f64)]| {
            FourthMoments::from_array(std::array::from_fn(|k| {
                points
                    .iter()
                    .map(|(x, y)| x.powi(4 - k as i32) * y.powi(k as i32))
                    .sum()
            }))
        };
        let points = [(1.0, 0.3), (-0.4, 0.9), (0.2, -1.1)];
        let turned = points.map(|(x, y)| (cos * x + sin * y, -sin * x + cos * y));
        let got = of(&points).rotated_into(Meridian { cos, sin });
        for (got, want) in got.to_array().iter().zip(of(&turned).to_array()) {
            assert!((got - want).abs() < 1e-13, "{got} {want}");
        }
    }
}

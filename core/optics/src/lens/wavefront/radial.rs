//! The slope of a wavefront along a straight line through a pupil point, as a polynomial in the distance from it.

use super::{DEGREE, Wavefront, binomial, index, power_table, powers_up_to};

/// The slope of a wavefront along a line: polynomials in the distance from its origin.
pub(in crate::lens) struct SlopeAlong {
    /// Coefficients of rising powers for the x and the y component, px.
    coefficients: [[f64; 2]; DEGREE],
    /// Number of coefficients in use.
    count: usize,
}

impl SlopeAlong {
    /// Returns the slope at distance `r` from the origin, px.
    #[inline]
    pub(in crate::lens) fn at(&self, r: f64) -> [f64; 2] {
        let used = self.coefficients[..self.count].iter().rev();
        used.fold([0.0; 2], |[x, y], [cx, cy]| [x * r + cx, y * r + cy])
    }
}

impl Wavefront {
    /// Returns the wavefront as a polynomial in u - `origin`, without its constant.
    #[must_use]
    pub(in crate::lens) fn about(&self, origin: [f64; 2]) -> Self {
        if origin == [0.0; 2] {
            return *self;
        }
        let (x, y) = (power_table(origin[0]), power_table(origin[1]));
        let mut moved = Self {
            degree: self.degree,
            ..Self::default()
        };
        for ((i, j), c) in powers_up_to(self.degree).zip(&self.coefficients) {
            if *c == 0.0 {
                continue;
            }
            for a in 0..=i {
                for b in 0..=j {
                    if a + b > 0 {
                        let share = binomial(i, a) * binomial(j, b) * x[i - a] * y[j - b];
                        moved.coefficients[index(a, b)] += c * share;
                    }
                }
            }
        }
        moved
    }

    /// Returns the slope along the line from the origin in `direction`, its cosine and sine.
    pub(in crate::lens) fn slope_along(&self, direction: [f64; 2]) -> SlopeAlong {
        let (cos, sin) = (power_table(direction[0]), power_table(direction[1]));
        let mut slope = SlopeAlong {
            coefficients: [[0.0; 2]; DEGREE],
            count: self.degree,
        };
        for (n, sums) in (1..=self.degree).zip(&mut slope.coefficients) {
            let terms = &self.coefficients[index(n, 0)..][..=n];
            for (j, c) in terms.iter().enumerate() {
                let i = n - j;
                if i > 0 {
                    sums[0] += c * i as f64 * cos[i - 1] * sin[j];
                }
                if j > 0 {
                    sums[1] += c * j as f64 * cos[i] * sin[j - 1];
                }
            }
        }
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_along_a_line_is_that_of_the_wavefront() {
        let mut wavefront = Wavefront::default();
        for (k, (i, j)) in powers_up_to(DEGREE).enumerate() {
            wavefront.add_monomial(i, j, 0.3 + 0.1 * k as f64 - 0.02 * (k * k) as f64);
        }
        for origin in [[0.0, 0.0], [0.3, -0.2], [-0.5, 0.1]] {
            let about = wavefront.about(origin);
            for angle in [0.1_f64, 1.3, 2.0, 4.4] {
                let direction = [angle.cos(), angle.sin()];
                let along = about.slope_along(direction);
                for r in [0.0, 0.2, 0.7, 1.1] {
                    let u = [0, 1].map(|axis| origin[axis] + r * direction[axis]);
                    let (got, want) = (along.at(r), wavefront.slope(u));
                    for (g, w) in got.iter().zip(want) {
                        assert!((g - w).abs() < 1e-11 * w.abs().max(1.0), "{got:?} {want:?}");
                    }
                }
            }
        }
    }
}

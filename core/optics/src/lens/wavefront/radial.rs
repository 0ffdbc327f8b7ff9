//! The slope of a wavefront along straight lines through a pupil point, as polynomials in the distance from it.

use super::{Wavefront, binomial, index, power_table, powers, powers_up_to};

/// Directions in a pupil, with what each monomial of a wavefront adds to the slope along each of them.
pub(in crate::lens) struct Directions {
    /// Cosine and sine of each.
    vectors: Vec<[f64; 2]>,
    /// For each monomial, the factors on its coefficient in the x and in the y component of the slope, by direction.
    factors: Vec<[Vec<f64>; 2]>,
}

/// The slope of a wavefront along each of [`Directions`]: for rising powers of the distance, the coefficients of the x and of the y
/// component by direction, px.
pub(in crate::lens) struct SlopesAlong(pub(in crate::lens) Vec<[Vec<f64>; 2]>);

impl Directions {
    /// `count` directions, evenly spread.
    pub(in crate::lens) fn new(count: usize) -> Self {
        let angle = |k: usize| std::f64::consts::TAU * (k as f64 + 0.5) / count as f64;
        Self::of_vectors(
            (0..count)
                .map(|k| [angle(k).cos(), angle(k).sin()])
                .collect(),
        )
    }

    fn of_vectors(vectors: Vec<[f64; 2]>) -> Self {
        let tables: Vec<_> = vectors.iter().map(|v| v.map(power_table)).collect();
        let factors = powers().map(|(i, j)| {
            let along_x = tables.iter().map(|[cos, sin]| match i {
                0 => 0.0,
                _ => i as f64 * cos[i - 1] * sin[j],
            });
            let along_y = tables.iter().map(|[cos, sin]| match j {
                0 => 0.0,
                _ => j as f64 * cos[i] * sin[j - 1],
            });
            [along_x.collect(), along_y.collect()]
        });
        Self {
            factors: factors.collect(),
            vectors,
        }
    }

    /// Cosine and sine of each direction.
    pub(in crate::lens) fn vectors(&self) -> &[[f64; 2]] {
        &self.vectors
    }

    /// Returns the slope of `wavefront` along the line from the origin in each direction.
    #[inline(always)]
    pub(in crate::lens) fn slopes(&self, wavefront: &Wavefront) -> SlopesAlong {
        let zeros = || vec![0.0; self.vectors.len()];
        let mut slopes: Vec<[Vec<f64>; 2]> =
            (0..wavefront.degree).map(|_| [zeros(), zeros()]).collect();
        let terms = powers_up_to(wavefront.degree).zip(&wavefront.coefficients);
        for (((i, j), c), factors) in terms.zip(&self.factors) {
            if *c == 0.0 {
                continue;
            }
            for (sums, factors) in slopes[i + j - 1].iter_mut().zip(factors) {
                for (sum, factor) in sums.iter_mut().zip(factors) {
                    *sum += c * factor;
                }
            }
        }
        SlopesAlong(slopes)
    }
}

impl SlopesAlong {
    /// Writes the components of the slope at distance `r` in each direction to `x` and `y`, px.
    #[inline(always)]
    pub(in crate::lens) fn at(&self, r: &[f64], x: &mut [f64], y: &mut [f64]) {
        for (axis, out) in [x, y].into_iter().enumerate() {
            out.fill(0.0);
            for coefficients in self.0.iter().rev() {
                for ((out, r), c) in out.iter_mut().zip(r).zip(&coefficients[axis]) {
                    *out = *out * r + c;
                }
            }
        }
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
}

#[cfg(test)]
mod tests {
    use super::super::DEGREE;
    use super::*;

    #[test]
    fn the_slope_along_a_line_is_that_of_the_wavefront() {
        let mut wavefront = Wavefront::default();
        for (k, (i, j)) in powers_up_to(DEGREE).enumerate() {
            wavefront.add_monomial(i, j, 0.3 + 0.1 * k as f64 - 0.02 * (k * k) as f64);
        }
        let directions = [0.1_f64, 1.3, 2.0, 4.4].map(|angle| [angle.cos(), angle.sin()]);
        let directions = Directions::of_vectors(directions.to_vec());
        for origin in [[0.0, 0.0], [0.3, -0.2], [-0.5, 0.1]] {
            let slopes = directions.slopes(&wavefront.about(origin));
            for r in [0.0, 0.2, 0.7, 1.1] {
                let [mut x, mut y] = [[0.0; 4]; 2];
                slopes.at(&[r; 4], &mut x, &mut y);
                for (k, direction) in directions.vectors().iter().enumerate() {
                    let u = [0, 1].map(|axis| origin[axis] + r * direction[axis]);
                    let want = wavefront.slope(u);
                    for (got, want) in [x[k], y[k]].into_iter().zip(want) {
                        assert!(
                            (got - want).abs() < 1e-11 * want.abs().max(1.0),
                            "{got} {want}"
                        );
                    }
                }
            }
        }
    }
}

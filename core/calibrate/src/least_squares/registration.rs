//! The Gauss-Newton step of a shift in two dimensions.

/// Smallest determinant of the normal matrix, relative to the product of its diagonal, that is solved.
const LEAST_DETERMINANT: f64 = 1e-9;

/// Normal equations of a shift (x, y), summed over samples.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RegistrationSums {
    xx: f64,
    xy: f64,
    yy: f64,
    right: [f64; 2],
}

impl RegistrationSums {
    /// Adds a sample with `residual`, observed minus predicted, and the derivatives of the prediction by the shift.
    pub(crate) fn add(&mut self, residual: f64, [x, y]: [f64; 2]) {
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
        self.right[0] += x * residual;
        self.right[1] += y * residual;
    }

    /// Returns the step; `None` where the samples do not determine it.
    pub(crate) fn step(&self) -> Option<[f64; 2]> {
        let determinant = self.xx * self.yy - self.xy * self.xy;
        if determinant <= LEAST_DETERMINANT * self.xx * self.yy {
            return None;
        }
        let [x, y] = self.right;
        Some([
            (self.yy * x - self.xy * y) / determinant,
            (self.xx * y - self.xy * x) / determinant,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_shift_is_found_in_one_step() {
        let mut sums = RegistrationSums::default();
        for slopes in [[1.0, 0.5], [-0.3, 2.0], [0.7, 0.1]] {
            sums.add(0.4 * slopes[0] - 0.2 * slopes[1], slopes);
        }
        let [x, y] = sums.step().expect("determined");
        assert!((x - 0.4).abs() < 1e-12 && (y + 0.2).abs() < 1e-12);
        let mut line = RegistrationSums::default();
        line.add(1.0, [1.0, 2.0]);
        assert_eq!(line.step(), None);
    }
}

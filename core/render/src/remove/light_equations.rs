//! The weighted least-squares problem of a light, in the form in which coordinate descent needs fewer multiplications.

use super::light_kernels::Column;
use rayon::prelude::*;

/// The problem |W^(1/2) (y - C x)|² / 2, and the unknowns x so far. W is diagonal.
pub(super) struct Equations<'a> {
    pub(super) unknowns: Vec<f64>,
    form: Form<'a>,
}

/// The quantities that are kept up to date while unknowns change.
enum Form<'a> {
    /// Few unknowns: the normal equations, and the negative gradient Cᵀ W (y - C x).
    Normal {
        matrix: Vec<Vec<f32>>,
        right: Vec<f64>,
        descent: Vec<f64>,
    },
    /// Many unknowns: the weighted residual W (y - C x), as in iterative coordinate descent for tomography.
    Residual {
        columns: &'a [Column],
        /// The diagonal of W.
        weights: Vec<f32>,
        samples: &'a [f32],
        residual: Vec<f32>,
        curvatures: Vec<f64>,
        /// Columns of the window.
        width: usize,
    },
}

/// Returns about how many multiplications one fit by [`Equations`] takes, with `count` unknowns, columns of `area` samples,
/// `pairs` multiplications for all inner products of columns, and this number of sweeps.
pub(super) fn work(count: usize, area: usize, pairs: f64, sweeps: usize) -> f64 {
    let sweeps = sweeps as f64 * count as f64;
    (pairs + sweeps * count as f64).min(2.0 * sweeps * area as f64)
}

impl<'a> Equations<'a> {
    /// Prepares the problem with `columns` over a window `width` samples wide and zero unknowns. Samples have these
    /// `deviations`; those that are not `used` have no weight.
    pub(super) fn new(
        columns: &'a [Column],
        width: usize,
        samples: &'a [f32],
        deviations: &[f64],
        used: &[bool],
    ) -> Self {
        let root_weights: Vec<f32> = (deviations.iter().zip(used))
            .map(|(deviation, used)| if *used { deviation.recip() as f32 } else { 0.0 })
            .collect();
        let count = columns.len();
        let area = columns.iter().map(Column::area).sum::<usize>() / count.max(1);
        let unknowns = vec![0.0; count];
        let scaled = |column: &Column| column.scaled(&root_weights, width);
        if count > 2 * area {
            let curvature = |column: &Column| {
                let column = scaled(column);
                column.dot(&column)
            };
            return Self {
                unknowns,
                form: Form::Residual {
                    columns,
                    weights: root_weights.iter().map(|w| w * w).collect(),
                    samples,
                    residual: Vec::new(),
                    curvatures: columns.par_iter().map(curvature).collect(),
                    width,
                },
            };
        }
        let columns: Vec<Column> = columns.par_iter().map(scaled).collect();
        let samples = samples.iter().zip(&root_weights).map(|(v, w)| v * w);
        let samples = Column::full(width, samples.collect());
        let half: Vec<Vec<f32>> = (0..count)
            .into_par_iter()
            .map(|j| {
                (0..=j)
                    .map(|k| columns[j].dot(&columns[k]) as f32)
                    .collect()
            })
            .collect();
        Self {
            unknowns,
            form: Form::Normal {
                matrix: (0..count)
                    .map(|j| (0..count).map(|k| half[j.max(k)][j.min(k)]).collect())
                    .collect(),
                right: columns.iter().map(|column| column.dot(&samples)).collect(),
                descent: Vec::new(),
            },
        }
    }

    /// Computes the gradient anew from the unknowns, free of the rounding errors of changes.
    pub(super) fn refresh(&mut self) {
        match &mut self.form {
            Form::Normal {
                matrix,
                right,
                descent,
            } => {
                let product = |row: &Vec<f32>| -> f64 {
                    let products = row.iter().zip(&self.unknowns);
                    products.map(|(a, b)| f64::from(*a) * b).sum()
                };
                *descent = (matrix.iter().zip(right.iter()))
                    .map(|(row, right)| right - product(row))
                    .collect();
            }
            Form::Residual {
                columns,
                weights,
                samples,
                residual,
                width,
                ..
            } => {
                *residual = samples.to_vec();
                for (column, value) in columns.iter().zip(&self.unknowns) {
                    if *value != 0.0 {
                        column.add_to(residual, *width, -*value as f32);
                    }
                }
                for (residual, weight) in residual.iter_mut().zip(weights) {
                    *residual *= *weight;
                }
            }
        }
    }

    /// Returns element `j` of the negative gradient. [`Self::refresh`] must have been called.
    pub(super) fn descent(&self, j: usize) -> f64 {
        match &self.form {
            Form::Normal { descent, .. } => descent[j],
            Form::Residual {
                columns,
                residual,
                width,
                ..
            } => columns[j].dot_plane(residual, *width),
        }
    }

    /// Returns the second derivative along unknown `j`.
    pub(super) fn curvature(&self, j: usize) -> f64 {
        match &self.form {
            Form::Normal { matrix, .. } => f64::from(matrix[j][j]),
            Form::Residual { curvatures, .. } => curvatures[j],
        }
    }

    /// Sets unknown `j`.
    pub(super) fn set(&mut self, j: usize, value: f64) {
        let change = value - self.unknowns[j];
        if change == 0.0 {
            return;
        }
        self.unknowns[j] = value;
        match &mut self.form {
            Form::Normal {
                matrix, descent, ..
            } => {
                for (descent, element) in descent.iter_mut().zip(&matrix[j]) {
                    *descent -= f64::from(*element) * change;
                }
            }
            Form::Residual {
                columns,
                weights,
                residual,
                width,
                ..
            } => columns[j].add_weighted_to(residual, weights, *width, -change as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::NormalDeviates;
    use super::*;

    /// The two forms are the same problem.
    #[test]
    fn both_forms_have_the_same_gradient_and_curvature() {
        let (width, height) = (12, 5);
        let mut deviates = NormalDeviates(2);
        let mut plane = || deviates.plane(width * height);
        let samples = plane();
        let columns: Vec<Column> = (0..4).map(|_| Column::full(width, plane())).collect();
        let deviations: Vec<f64> = (0..samples.len()).map(|k| 0.5 + 0.1 * k as f64).collect();
        let used: Vec<bool> = (0..samples.len()).map(|k| k % 7 > 0).collect();
        let mut normal = Equations::new(&columns, width, &samples, &deviations, &used);
        assert!(matches!(normal.form, Form::Normal { .. }));
        let weights = (deviations.iter().zip(&used))
            .map(|(s, used)| if *used { s.powi(-2) as f32 } else { 0.0 });
        let mut residual = Equations {
            unknowns: vec![0.0; 4],
            form: Form::Residual {
                columns: &columns,
                weights: weights.collect(),
                samples: &samples,
                residual: Vec::new(),
                curvatures: (0..4).map(|j| normal.curvature(j)).collect(),
                width,
            },
        };
        for equations in [&mut normal, &mut residual] {
            equations.set_all(&[0.3, 0.0, -0.2, 0.1]);
            equations.refresh();
            equations.set(1, 0.7);
        }
        for j in 0..4 {
            let (a, b) = (normal.descent(j), residual.descent(j));
            assert!((a - b).abs() < 1e-4 * a.abs().max(1.0), "{a} {b}");
        }
    }

    impl Equations<'_> {
        fn set_all(&mut self, values: &[f64]) {
            self.unknowns.copy_from_slice(values);
        }
    }
}

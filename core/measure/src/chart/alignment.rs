//! Registration of a chart by Gauss-Newton on whole images (Lucas and Kanade 1981), from coarse to fine.

use nalgebra::{DMatrix, DVector, Matrix3};

use super::coarse::{Coarse, Plane};
use super::map::ChartMap;
use super::picture::{Aperture, ChartPicture};
use seidel_optics::numeric::dot;

/// Standard deviations of the filters of the homography's stages and of the polynomial's, px of the binned photograph.
const HOMOGRAPHY_SIGMAS: [f64; 3] = [5.0, 3.0, 2.0];
const POLYNOMIAL_SIGMAS: [f64; 3] = [3.0, 2.0, 1.2];
/// Iterations a stage, and the displacement at which it ends, px of the binned photograph.
const ITERATIONS: usize = 12;
const CONVERGED_PX: f64 = 0.01;
/// Terms of the correction that images determine: those up to third degree.
const CUBIC_TERMS: usize = 10;
/// Longest step of one iteration over the filter's standard deviation.
const MAX_STEP: f64 = 1.5;

/// A registered map, with the correlation that it reaches.
#[derive(Debug, Clone)]
pub(crate) struct Aligned {
    pub(crate) map: ChartMap,
    pub(crate) correlation: f64,
}

/// Refines the homography of `map` at the coarsest scale, and returns the correlation.
pub(crate) fn align_roughly(coarse: &Coarse, chart: &ChartPicture, map: ChartMap) -> Aligned {
    let mut aligned = Aligned {
        map,
        correlation: 0.0,
    };
    refine(
        coarse,
        chart,
        &mut aligned,
        HOMOGRAPHY_SIGMAS[0],
        Flow::Homography,
    );
    aligned
}

/// Refines the homography of `aligned` at the finer scales.
pub(crate) fn align_homography(coarse: &Coarse, chart: &ChartPicture, aligned: &mut Aligned) {
    for sigma in &HOMOGRAPHY_SIGMAS[1..] {
        refine(coarse, chart, aligned, *sigma, Flow::Homography);
    }
}

/// Refines the polynomial correction of `aligned`.
pub(crate) fn align_polynomial(coarse: &Coarse, chart: &ChartPicture, aligned: &mut Aligned) {
    for sigma in POLYNOMIAL_SIGMAS {
        refine(coarse, chart, aligned, sigma, Flow::Polynomial);
    }
}

/// The part of the map that a refinement changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flow {
    Homography,
    Polynomial,
}

fn refine(coarse: &Coarse, chart: &ChartPicture, aligned: &mut Aligned, sigma: f64, flow: Flow) {
    let mut best = aligned.clone();
    best.correlation = -1.0;
    for _ in 0..ITERATIONS {
        let step = Step::new(coarse, chart, &aligned.map, sigma, flow);
        aligned.correlation = step.correlation;
        if step.correlation > best.correlation {
            best = aligned.clone();
        }
        let Some(solution) = step.solution else {
            break;
        };
        let longest = aligned.map.apply(&solution, coarse, flow, MAX_STEP * sigma);
        if longest < CONVERGED_PX {
            break;
        }
    }
    let last = Step::new(coarse, chart, &aligned.map, sigma, flow);
    aligned.correlation = last.correlation;
    if last.correlation < best.correlation {
        *aligned = best;
    }
}

/// One linearisation.
struct Step {
    correlation: f64,
    /// Coefficients of the flow, in photograph pixels and normalised positions.
    solution: Option<DVector<f64>>,
}

impl Step {
    fn new(coarse: &Coarse, chart: &ChartPicture, map: &ChartMap, sigma: f64, flow: Flow) -> Self {
        let (columns, rows) = (coarse.plane.columns, coarse.plane.rows);
        let inside: Vec<bool> = (0..columns * rows)
            .map(|k| {
                let at = map.chart_of(coarse.grid.position(k % columns, k / columns));
                let [width, height] = chart.size().map(|v| v as f64);
                (0.0..width).contains(&at[0]) && (0.0..height).contains(&at[1])
            })
            .collect();
        let view = Plane {
            columns,
            rows,
            values: chart.rendered(map, &coarse.grid, Aperture::Pixel),
        };
        let (target, view) = (coarse.plane.band(sigma, &inside), view.band(sigma, &inside));
        let (mut both, mut of_target, mut of_view) = (0.0, 0.0, 0.0);
        for index in (0..inside.len()).filter(|k| inside[*k]) {
            let (a, b) = (target.values[index], view.values[index]);
            both += a * b;
            of_target += a * a;
            of_view += b * b;
        }
        let correlation = both / (of_target * of_view).sqrt().max(1e-30);
        let gain = both / of_view.max(1e-30);
        let mut normal: Option<(DMatrix<f64>, DVector<f64>)> = None;
        for y in 1..rows - 1 {
            for x in 1..columns - 1 {
                let index = y * columns + x;
                if !inside[index] {
                    continue;
                }
                let dx = (view.values[index + 1] - view.values[index - 1]) / 2.0 * gain;
                let dy = (view.values[index + columns] - view.values[index - columns]) / 2.0 * gain;
                let residual = target.values[index] - gain * view.values[index];
                let row = map.flow_row(coarse.grid.position(x, y), [dx, dy], flow);
                let (matrix, right) = normal.get_or_insert_with(|| {
                    (
                        DMatrix::zeros(row.len(), row.len()),
                        DVector::zeros(row.len()),
                    )
                });
                for (a, va) in row.iter().enumerate() {
                    right[a] += va * residual;
                    for (b, vb) in row.iter().enumerate().take(a + 1) {
                        matrix[(a, b)] += va * vb;
                    }
                }
            }
        }
        let solution = normal.and_then(|(mut matrix, right)| {
            matrix.fill_upper_triangle_with_lower_triangle();
            for k in 0..right.len() {
                matrix[(k, k)] *= 1.0 + 1e-6;
            }
            let solved = matrix.cholesky()?.solve(&right);
            // Gradients are of the binned photograph.
            Some(solved * coarse.grid.step)
        });
        Self {
            correlation,
            solution,
        }
    }
}

impl ChartMap {
    /// Returns the derivative of the view's value at `at` by every coefficient of `flow`, for a gradient of the view.
    fn flow_row(&self, at: [f64; 2], [dx, dy]: [f64; 2], flow: Flow) -> Vec<f64> {
        match flow {
            Flow::Homography => {
                let [x, y] = self.normalised(at);
                let radial = -(dx * x + dy * y);
                vec![
                    dx * x,
                    dx * y,
                    dx,
                    dy * x,
                    dy * y,
                    dy,
                    radial * x,
                    radial * y,
                ]
            }
            Flow::Polynomial => {
                let terms = self.correction_row(at).into_iter().take(CUBIC_TERMS);
                terms.flat_map(|t| [t * dx, t * dy]).collect()
            }
        }
    }

    /// Applies a step, shortened to at most `most` px of the binned photograph anywhere, and returns its length there.
    fn apply(&mut self, solution: &DVector<f64>, coarse: &Coarse, flow: Flow, most: f64) -> f64 {
        let (columns, rows) = (coarse.plane.columns, coarse.plane.rows);
        let corners = [
            (0, 0),
            (columns - 1, 0),
            (0, rows - 1),
            (columns - 1, rows - 1),
        ];
        let places = corners.into_iter().chain([(columns / 2, rows / 2)]);
        let longest = places
            .map(|(x, y)| {
                let at = coarse.grid.position(x, y);
                let along = |g: [f64; 2]| {
                    let row = self.flow_row(at, g, flow);
                    dot(&row, solution.as_slice())
                };
                along([1.0, 0.0]).hypot(along([0.0, 1.0])) / coarse.grid.step
            })
            .fold(0.0, f64::max);
        let share = (most / longest.max(1e-30)).min(1.0);
        let s = solution * share;
        match flow {
            Flow::Homography => {
                let flow = Matrix3::new(s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], 0.0);
                self.compose_normalised(flow);
            }
            Flow::Polynomial => {
                let pairs = s.as_slice().chunks(2).map(|c| [c[0], c[1]]);
                self.add_correction(pairs);
            }
        }
        longest
    }
}

//! S1..S10 from the moments of edges along their normals: two linear least squares.
//!
//! With n the unit normal at field position X, the variance along n is
//! `S1 + S3 r² + S5 r⁴ + (S2 + S4 r²) (X.n)²` and the third moment `P (X.n)³ + 3 Q (X.n)`, with P and Q linear in S6..S10
//! (docs/background/model.md section 4). Two orientations over the field determine all ten.

use nalgebra::{DMatrix, DVector, Vector2};

use crate::fit::axis::AxisEstimate;
use crate::fit::axis_problem::AxisProblem;
use crate::least_squares::{self, Damping, Stop};
use seidel_optics::edges::Edge;
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::MomentCoefficients;
use seidel_optics::numeric::{dot, median};

/// Iterations of reweighting.
const ITERATIONS: usize = 12;
/// Residual over the expected one from which on an edge loses weight.
const TOLERANCE: f64 = 3.0;
/// Step of the central differences of the axis, px.
const DIFFERENCE_STEP_PX: f64 = 1.0;
const DAMPING: Damping = Damping {
    increase: 8.0,
    least: 1e-9,
    max_tries: 20,
    negligible_change: 0.0,
};
const STOP: Stop = Stop {
    max_iterations: 30,
    min_decrease: f64::INFINITY,
    min_step: 0.02,
};
/// Starts of the axis: offsets from the centre over the frame's width.
const AXIS_STARTS: [f64; 3] = [-0.06, 0.0, 0.06];

/// S1..S10 of one channel at one distance, from edges.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MomentFit {
    pub(super) s: MomentCoefficients,
    pub(super) sigma: [f64; 10],
    /// Weights of the variances and of the third moments: one over the standard deviation, smaller for outliers.
    weights: [Vec<f64>; 2],
}

/// Returns the rows of S1..S5 and of S6..S10 for an edge with `normal` at `at`.
pub(super) fn rows(at: FieldPoint, [nx, ny]: [f64; 2]) -> [[f64; 5]; 2] {
    let r2 = at.x * at.x + at.y * at.y;
    let along = at.x * nx + at.y * ny;
    let (square, cube) = (along * along, along.powi(3));
    [
        [1.0, square, r2, r2 * square, r2 * r2],
        [
            6.0 * r2 * cube - 3.0 * r2 * r2 * along,
            -3.0 * r2 * cube + 3.0 * r2 * r2 * along,
            cube,
            -3.0 * cube + 3.0 * r2 * along,
            3.0 * along,
        ],
    ]
}

/// Returns the derivatives of the variance along `normal` at `at` by S1..S5.
pub(in crate::fit) fn variance_row(at: FieldPoint, normal: [f64; 2]) -> [f64; 5] {
    rows(at, normal)[0]
}

/// Returns a moment of an edge and its standard deviation: the variance (0) or the third moment (1).
pub(super) fn moment(edge: &Edge, which: usize) -> (f64, f64) {
    [
        (edge.variance_px2, edge.variance_sigma),
        (edge.third_px3, edge.third_sigma),
    ][which]
}

/// Fits S1..S10 to `edges`, of one channel at one distance.
///
/// # Errors
/// Too few edges, or edges that do not determine S1..S10.
pub(super) fn fit(frame: &Frame, edges: &[&Edge]) -> Result<MomentFit> {
    let (mut s, mut sigma) = ([0.0; 10], [0.0; 10]);
    let mut kept_weights = [Vec::new(), Vec::new()];
    for which in 0..2 {
        let rows: Vec<Vec<f64>> = (edges.iter())
            .map(|e| rows(frame.field_point(e.mid), e.normal)[which].to_vec())
            .collect();
        let (targets, sigmas): (Vec<f64>, Vec<f64>) =
            edges.iter().map(|e| moment(e, which)).unzip();
        // Errors of the model are not smaller than those of good edges.
        let floor = 0.5 * median(&mut sigmas.clone());
        let weights: Vec<f64> = sigmas.iter().map(|s| 1.0 / s.max(floor)).collect();
        let mut robust = weights.clone();
        let mut found = least_squares::solve(&rows, &targets, &robust)?;
        for _ in 0..ITERATIONS {
            let residuals: Vec<f64> = (rows.iter().zip(&targets))
                .map(|(row, target)| target - dot(row, &found.values))
                .collect();
            let scaled: Vec<f64> = (residuals.iter().zip(&weights))
                .map(|(r, w)| (r * w).abs())
                .collect();
            let scatter = (1.4826 * median(&mut scaled.clone())).max(1e-9);
            for ((robust, weight), r) in robust.iter_mut().zip(&weights).zip(&scaled) {
                *robust = weight / (1.0 + (r / (TOLERANCE * scatter)).powi(2)).sqrt();
            }
            found = least_squares::solve(&rows, &targets, &robust)?;
        }
        s[5 * which..][..5].copy_from_slice(&found.values);
        sigma[5 * which..][..5].copy_from_slice(&found.sigma);
        kept_weights[which] = robust;
    }
    Ok(MomentFit {
        s: MomentCoefficients(s),
        sigma,
        weights: kept_weights,
    })
}

/// Estimates the axis from groups of edges, each of one channel at one distance, by variable projection.
///
/// # Errors
/// As [`fit`].
pub(in crate::fit) fn find_axis(frame: &Frame, groups: &[Vec<&Edge>]) -> Result<AxisEstimate> {
    let centre = frame.axis();
    let mut best: Option<(f64, AxisEstimate)> = None;
    let mut first_error = None;
    for (x, y) in AXIS_STARTS
        .iter()
        .flat_map(|x| AXIS_STARTS.iter().map(move |y| (*x, *y)))
    {
        let width = f64::from(frame.width_px());
        let start = ImagePoint::new(centre.x_px + x * width, centre.y_px + y * width);
        match axis_from(&frame.with_axis(start)?, groups) {
            Ok((cost, found)) => {
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, found));
                }
            }
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    match (best, first_error) {
        (Some((_, found)), _) => Ok(found),
        (None, Some(error)) => Err(error),
        (None, None) => unreachable!("there are starts"),
    }
}

fn axis_from(start: &Frame, groups: &[Vec<&Edge>]) -> Result<(f64, AxisEstimate)> {
    let fits: Vec<MomentFit> = groups
        .iter()
        .map(|edges| fit(start, edges))
        .collect::<Result<_>>()?;
    let problem = AxisProblem {
        residuals: |axis: Vector2<f64>| {
            let frame = start.with_axis(ImagePoint::new(axis.x, axis.y)).ok()?;
            projected_residuals(&frame, groups, &fits)
        },
        cost: DVector::norm_squared,
        difference_px: DIFFERENCE_STEP_PX,
    };
    let found = problem.minimise(start.axis(), DAMPING, STOP);
    let residuals = found.point.residuals.as_ref();
    let count = residuals.map_or(0, |r| r.len());
    let freedom = count.saturating_sub(2 + 10 * fits.len()).max(1) as f64;
    let inverse = found.last_equations.matrix.clone().try_inverse();
    let sigma = |k: usize| {
        let square = inverse.as_ref().map_or(f64::INFINITY, |m| m[(k, k)]);
        (square * found.cost / freedom).sqrt()
    };
    let estimate = AxisEstimate {
        axis: ImagePoint::new(found.point.axis.x, found.point.axis.y),
        sigma_px: (sigma(0), sigma(1)),
        converged: found.converged,
    };
    // Weights differ between starts, so costs are compared per degree of freedom of all weights.
    let weights: f64 = fits
        .iter()
        .flat_map(|f| f.weights.iter().flatten())
        .map(|w| w * w)
        .sum();
    Ok((found.cost / weights, estimate))
}

/// Returns the residuals of the moments of all `groups` with the axis of `frame`, under the weights of `fits`; `None` where it
/// leaves S1..S10 undetermined.
fn projected_residuals(
    frame: &Frame,
    groups: &[Vec<&Edge>],
    fits: &[MomentFit],
) -> Option<DVector<f64>> {
    let mut all = Vec::new();
    for (edges, fit) in groups.iter().zip(fits) {
        for which in 0..2 {
            let matrix = DMatrix::from_fn(edges.len(), 5, |r, c| {
                let at = frame.field_point(edges[r].mid);
                rows(at, edges[r].normal)[which][c] * fit.weights[which][r]
            });
            let target = DVector::from_fn(edges.len(), |r, _| {
                moment(edges[r], which).0 * fit.weights[which][r]
            });
            let solution = matrix.clone().svd(true, true).solve(&target, 1e-12).ok()?;
            all.extend((target - matrix * solution).iter());
        }
    }
    Some(DVector::from_vec(all))
}

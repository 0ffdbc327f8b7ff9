//! Robust nonlinear least squares of moments of orders 2, 3 and 4 in six parameters.

use nalgebra::{DMatrix, DVector, Matrix6, Vector6};

use crate::least_squares::{Damping, LeastSquares, NormalEquations, Stop, Trial, minimise};
use crate::measure::MeasuredTile;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::ReducedNumbers;
use seidel_optics::numeric::median;

/// Alpha at mid vergence, its change over half the vergence range, beta, gamma, delta, phi.
pub(super) type Parameters = Vector6<f64>;

/// Number of moments that a mirror-symmetric PSF has in its meridional frame: mu20, mu02, mu30, mu12, mu40,
/// mu22, mu04.
const MOMENTS: usize = 7;
const ORDER: [i32; MOMENTS] = [2, 2, 3, 3, 4, 4, 4];
/// Weight of a squared residual: multiplicity of the moment in its symmetric tensor over the tensor's size.
const TENSOR_WEIGHT: [f64; MOMENTS] = [0.25, 0.25, 0.125, 0.375, 0.0625, 0.375, 0.0625];
/// The same for moments that vanish by mirror symmetry: mu11; mu21, mu03; mu31, mu13.
const ODD_TENSOR_WEIGHT: [f64; 3] = [0.5, 0.125, 0.25];
/// Weight per order. Fourth moments weigh less, because truncation of the tile biases them most.
const ORDER_WEIGHT: [f64; 5] = [0.0, 0.0, 1.0, 1.0, 0.5];
/// Relative error of a typical third-order lens. Noise above it lowers the weight.
const TYPICAL_MODEL_ERROR: f64 = 0.02;
/// Step of the central differences, in units of the parameter scales.
const DIFFERENCE_STEP: f64 = 1e-4;
const DAMPING: Damping = Damping {
    increase: 6.0,
    least: 1e-12,
    max_tries: usize::MAX,
    negligible_change: 0.0,
};
/// Relative decrease of the cost, and step in units of the parameter scales, at which a minimisation stops.
const MIN_DECREASE: f64 = 1e-9;
const MIN_STEP: f64 = 1e-5;
/// Ridge relative to the largest diagonal element of the normal matrix. It keeps parameters without influence
/// in place, such as the slope of alpha at a single distance.
const RIDGE: f64 = 1e-12;

/// Orders of the moments that enter a misfit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Orders {
    /// Orders 2, 3 and 4.
    All,
    /// Orders 2 and 3.
    BelowFourth,
}

/// Measured moments of one tile, scaled and weighted.
#[derive(Debug, Clone)]
pub(super) struct TileEquation {
    /// Index of the distinct distance.
    pub plane: usize,
    h: f64,
    /// Measured moments over size^order.
    measured: [f64; MOMENTS],
    /// size^-order.
    unit: [f64; MOMENTS],
    /// Weights of the squared residuals.
    weight: [f64; MOMENTS],
    /// Weighted squares of the moments that vanish by symmetry: below the fourth order, and of it.
    odd: [f64; 2],
}

impl TileEquation {
    /// Returns `None` where the tile's moments are not finite.
    pub(super) fn new(frame: &Frame, tile: &MeasuredTile, plane: usize) -> Option<Self> {
        let at = tile.field_point(frame);
        let central = tile.optical.rotated_into(at.meridian());
        let fourth = tile.fourth.rotated_into(at.meridian());
        let size = tile.size_px();
        let powers = [0, 1, 2, 3, 4].map(|n| size.powi(n));
        let mean =
            |sigma: &[f64]| (sigma.iter().map(|s| s * s).sum::<f64>() / sigma.len() as f64).sqrt();
        let (second, third) = (mean(&tile.noise[0..3]), mean(&tile.noise[3..7]));
        // Each order multiplies noise by about the radius of the tile's support.
        let last = if second > 0.0 {
            third * third / second
        } else {
            0.0
        };
        let order_weight: [f64; 5] = std::array::from_fn(|n| {
            let noise = [0.0, 0.0, second, third, last][n] / powers[n];
            ORDER_WEIGHT[n] / (1.0 + (noise / TYPICAL_MODEL_ERROR).powi(2))
        });
        let unit = ORDER.map(|n| 1.0 / powers[n as usize]);
        let raw = [
            central.mu20,
            central.mu02,
            central.mu30,
            central.mu12,
            fourth.mu40,
            fourth.mu22,
            fourth.mu04,
        ];
        let odd = |n: usize, square: f64| order_weight[n] * square / (powers[n] * powers[n]);
        let found = Self {
            plane,
            h: at.radius(),
            measured: std::array::from_fn(|m| raw[m] * unit[m]),
            unit,
            weight: std::array::from_fn(|m| TENSOR_WEIGHT[m] * order_weight[ORDER[m] as usize]),
            odd: [
                odd(2, ODD_TENSOR_WEIGHT[0] * central.mu11.powi(2))
                    + odd(3, 3.0 * ODD_TENSOR_WEIGHT[1] * central.mu21.powi(2))
                    + odd(3, ODD_TENSOR_WEIGHT[1] * central.mu03.powi(2)),
                odd(
                    4,
                    ODD_TENSOR_WEIGHT[2] * (fourth.mu31.powi(2) + fourth.mu13.powi(2)),
                ),
            ],
        };
        let finite = found.h.is_finite()
            && found.measured.iter().all(|m| m.is_finite())
            && found.odd.iter().all(|o| o.is_finite());
        finite.then_some(found)
    }
}

/// Equations of all tiles, and the parameter scales.
#[derive(Debug, Clone)]
pub(super) struct MomentProblem {
    pub equations: Vec<TileEquation>,
    /// Vergence of each distinct distance, scaled to -1..1; 0 for a single distance.
    pub scaled_vergences: Vec<f64>,
    /// Typical size of each parameter.
    pub scales: Parameters,
}

impl MomentProblem {
    /// Returns the reduced numbers at distance index `plane`.
    pub(super) fn reduced(&self, numbers: &Parameters, plane: usize) -> ReducedNumbers {
        ReducedNumbers {
            alpha: numbers[0] + numbers[1] * self.scaled_vergences[plane],
            beta: numbers[2],
            gamma: numbers[3],
            delta: numbers[4],
            phi: numbers[5],
        }
    }

    /// Returns the weighted residuals of every tile.
    fn residuals(&self, numbers: &Parameters) -> Vec<[f64; MOMENTS]> {
        let planes: Vec<_> = (0..self.scaled_vergences.len())
            .map(|plane| {
                let reduced = self.reduced(numbers, plane);
                (reduced.coefficients(), reduced.fourth_coefficients())
            })
            .collect();
        self.equations
            .iter()
            .map(|equation| {
                let (central, fourth) = &planes[equation.plane];
                let low = central.meridional(equation.h);
                let high = fourth.moments(FieldPoint::new(equation.h, 0.0));
                let model = [
                    low.mu20, low.mu02, low.mu30, low.mu12, high.mu40, high.mu22, high.mu04,
                ];
                std::array::from_fn(|m| {
                    equation.weight[m].sqrt() * (model[m] * equation.unit[m] - equation.measured[m])
                })
            })
            .collect()
    }

    /// Returns the squared relative misfit of every tile.
    fn squares(&self, residuals: &[[f64; MOMENTS]], orders: Orders) -> Vec<f64> {
        let (count, odd) = match orders {
            Orders::All => (MOMENTS, 2),
            Orders::BelowFourth => (4, 1),
        };
        residuals
            .iter()
            .zip(&self.equations)
            .map(|(r, equation)| {
                r[..count].iter().map(|x| x * x).sum::<f64>()
                    + equation.odd[..odd].iter().sum::<f64>()
            })
            .collect()
    }

    /// Returns the median relative misfit.
    pub(super) fn median_misfit(&self, numbers: &Parameters) -> f64 {
        let mut squares = self.squares(&self.residuals(numbers), Orders::All);
        median(&mut squares).sqrt()
    }

    /// Returns the robust relative misfit. Tiles far beyond `cauchy_scale` saturate; small misfits give the
    /// root mean square.
    pub(super) fn misfit(&self, numbers: &Parameters, cauchy_scale: f64, orders: Orders) -> f64 {
        let squares = self.squares(&self.residuals(numbers), orders);
        cauchy_scale * (cauchy_cost(&squares, cauchy_scale) / squares.len().max(1) as f64).sqrt()
    }

    /// Minimises the Cauchy loss of the tiles' misfits by Levenberg-Marquardt, for at most `max_iterations`.
    pub(super) fn minimise(
        &self,
        start: Parameters,
        cauchy_scale: f64,
        max_iterations: usize,
    ) -> Parameters {
        let robust = RobustProblem {
            moments: self,
            cauchy_scale,
        };
        let stop = Stop {
            max_iterations,
            min_decrease: MIN_DECREASE,
            min_step: MIN_STEP,
        };
        let start = robust.at(start);
        minimise(&robust, start, DAMPING, stop).point.numbers
    }
}

/// The moment equations under a Cauchy loss per tile, with the parameters in units of their scales.
struct RobustProblem<'a> {
    moments: &'a MomentProblem,
    /// Scale of the loss, relative misfit.
    cauchy_scale: f64,
}

/// Parameters with the misfits of all tiles.
struct MomentPoint {
    numbers: Parameters,
    residuals: Vec<[f64; MOMENTS]>,
    /// Squared relative misfit of every tile.
    squares: Vec<f64>,
}

impl RobustProblem<'_> {
    fn at(&self, numbers: Parameters) -> MomentPoint {
        let residuals = self.moments.residuals(&numbers);
        MomentPoint {
            numbers,
            squares: self.moments.squares(&residuals, Orders::All),
            residuals,
        }
    }

    /// Returns the derivatives of the residuals by parameter `k`, by central differences.
    fn derivatives(&self, numbers: &Parameters, k: usize) -> Vec<[f64; MOMENTS]> {
        let mut offset = Parameters::zeros();
        offset[k] = DIFFERENCE_STEP * self.moments.scales[k];
        let low = self.moments.residuals(&(numbers - offset));
        let mut derivatives = self.moments.residuals(&(numbers + offset));
        let pairs = derivatives.as_flattened_mut().iter_mut();
        for (high, low) in pairs.zip(low.as_flattened()) {
            *high = (*high - low) / (2.0 * DIFFERENCE_STEP);
        }
        derivatives
    }
}

impl LeastSquares for RobustProblem<'_> {
    type Point = MomentPoint;

    fn linearise(&self, point: &MomentPoint) -> NormalEquations {
        let jacobian: [_; 6] = std::array::from_fn(|k| self.derivatives(&point.numbers, k));
        let mut matrix = Matrix6::zeros();
        let mut right = Vector6::zeros();
        for (tile, (residuals, square)) in point.residuals.iter().zip(&point.squares).enumerate() {
            let weight = 1.0 / (1.0 + square / (self.cauchy_scale * self.cauchy_scale));
            for (m, residual) in residuals.iter().enumerate() {
                let row = Vector6::from_fn(|k, _| jacobian[k][tile][m]);
                matrix += row * row.transpose() * weight;
                right -= row * (residual * weight);
            }
        }
        let matrix = DMatrix::from_column_slice(6, 6, matrix.as_slice());
        let right = DVector::from_column_slice(right.as_slice());
        let ridge = RIDGE * matrix.diagonal().max() + f64::MIN_POSITIVE;
        NormalEquations {
            ridge: DVector::from_element(6, ridge),
            ..NormalEquations::new(
                matrix,
                right,
                cauchy_cost(&point.squares, self.cauchy_scale),
            )
        }
    }

    fn trial(
        &self,
        point: &MomentPoint,
        equations: &NormalEquations,
    ) -> Option<Trial<MomentPoint>> {
        let step = equations.damped_step(|_| true)?;
        let change = Parameters::from_column_slice(step.as_slice());
        let moved = self.at(point.numbers + change.component_mul(&self.moments.scales));
        let cost = cauchy_cost(&moved.squares, self.cauchy_scale);
        Some(Trial::new(moved, cost, &step))
    }
}

fn cauchy_cost(squares: &[f64], cauchy_scale: f64) -> f64 {
    squares
        .iter()
        .map(|s| (s / (cauchy_scale * cauchy_scale)).ln_1p())
        .sum()
}

//! The robust least squares of [`super`]: moments of orders 2, 3 and 4 against six numbers.

use nalgebra::{Matrix6, Vector6};

use crate::measure::MeasuredTile;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::lens::ReducedNumbers;

/// alpha at mid vergence, its change over half the range of vergence, beta, gamma, delta, phi.
pub(super) type Numbers = Vector6<f64>;

/// The moments of a mirror-symmetric PSF in its own meridional frame: mu20, mu02, mu30, mu12, mu40,
/// mu22, mu04.
const MOMENTS: usize = 7;
const ORDER: [i32; MOMENTS] = [2, 2, 3, 3, 4, 4, 4];
/// Weight of a squared residual: how often the moment occurs in its symmetric tensor, over the number
/// of the tensor's elements.
const SHARE: [f64; MOMENTS] = [0.25, 0.25, 0.125, 0.375, 0.0625, 0.375, 0.0625];
/// Same for the moments that vanish by mirror symmetry: mu11; mu21, mu03; mu31, mu13.
const ODD_SHARE: [f64; 3] = [0.5, 0.125, 0.25];
/// Fourth moments weigh less: the rims of tiles touch them most.
const ORDER_WEIGHT: [f64; 5] = [0.0, 0.0, 1.0, 1.0, 0.5];
/// Noise counts once it exceeds this share of size^order, which a third-order lens typically misses.
const USUAL_MISFIT: f64 = 0.02;
/// Steps of the numeric derivatives, in the numbers' scales.
const PROBE: f64 = 1e-4;

/// The orders of moments that a misfit may be taken over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Orders {
    /// 2, 3 and 4.
    All,
    /// 2 and 3.
    BelowFourth,
}

/// What one tile asks of the six numbers.
#[derive(Debug, Clone)]
pub(super) struct Equation {
    /// Index among the distinct distances.
    pub plane: usize,
    h: f64,
    /// Measured moments over size^order.
    measured: [f64; MOMENTS],
    /// size^-order.
    unit: [f64; MOMENTS],
    /// Weights of the squared residuals.
    weight: [f64; MOMENTS],
    /// Weighted square of what no symmetric lens gives, below the fourth order and of it.
    odd: [f64; 2],
}

impl Equation {
    /// `None` where the tile's moments are not finite.
    pub(super) fn new(frame: &Frame, tile: &MeasuredTile, plane: usize) -> Option<Self> {
        let at = tile.field_point(frame);
        let central = tile.optical.rotated_into(at.meridian());
        let fourth = tile.fourth.rotated_into(at.meridian());
        let size = tile.size_px();
        let powers = [0, 1, 2, 3, 4].map(|n| size.powi(n));
        let mean =
            |sigma: &[f64]| (sigma.iter().map(|s| s * s).sum::<f64>() / sigma.len() as f64).sqrt();
        let (second, third) = (mean(&tile.noise[0..3]), mean(&tile.noise[3..7]));
        // Each order multiplies noise by about the reach of the tile's support.
        let last = if second > 0.0 {
            third * third / second
        } else {
            0.0
        };
        let order_weight: [f64; 5] = std::array::from_fn(|n| {
            let noise = [0.0, 0.0, second, third, last][n] / powers[n];
            ORDER_WEIGHT[n] / (1.0 + (noise / USUAL_MISFIT).powi(2))
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
            weight: std::array::from_fn(|m| SHARE[m] * order_weight[ORDER[m] as usize]),
            odd: [
                odd(2, ODD_SHARE[0] * central.mu11.powi(2))
                    + odd(3, 3.0 * ODD_SHARE[1] * central.mu21.powi(2))
                    + odd(3, ODD_SHARE[1] * central.mu03.powi(2)),
                odd(
                    4,
                    ODD_SHARE[2] * (fourth.mu31.powi(2) + fourth.mu13.powi(2)),
                ),
            ],
        };
        let finite = found.h.is_finite()
            && found.measured.iter().all(|m| m.is_finite())
            && found.odd.iter().all(|o| o.is_finite());
        finite.then_some(found)
    }
}

/// The equations and the units in which steps are taken.
#[derive(Debug, Clone)]
pub(super) struct Problem {
    pub equations: Vec<Equation>,
    /// Each distinct distance's place between -1 and 1; 0 where there is but one.
    pub places: Vec<f64>,
    /// A natural change of each number.
    pub scales: Numbers,
}

impl Problem {
    /// The reduced numbers at distinct distance `plane`.
    pub(super) fn reduced(&self, numbers: &Numbers, plane: usize) -> ReducedNumbers {
        ReducedNumbers {
            alpha: numbers[0] + numbers[1] * self.places[plane],
            beta: numbers[2],
            gamma: numbers[3],
            delta: numbers[4],
            phi: numbers[5],
        }
    }

    /// Weighted residuals of every equation.
    fn residuals(&self, numbers: &Numbers) -> Vec<[f64; MOMENTS]> {
        let planes: Vec<_> = (0..self.places.len())
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

    /// Squared relative misfit of every tile.
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

    /// Median over tiles of their relative misfit.
    pub(super) fn typical(&self, numbers: &Numbers) -> f64 {
        let mut squares = self.squares(&self.residuals(numbers), Orders::All);
        squares.sort_by(f64::total_cmp);
        squares.get(squares.len() / 2).map_or(0.0, |s| s.sqrt())
    }

    /// Relative misfit over all tiles, those far beyond `bound` counting little more than it: for
    /// small misfits their root mean square.
    pub(super) fn misfit(&self, numbers: &Numbers, bound: f64, orders: Orders) -> f64 {
        let squares = self.squares(&self.residuals(numbers), orders);
        bound * (cost(&squares, bound) / squares.len().max(1) as f64).sqrt()
    }

    /// Levenberg-Marquardt from `start`, at most `most_steps` steps, on Cauchy's robust cost of the
    /// tiles' misfits with scale `bound`.
    pub(super) fn descend(&self, start: Numbers, bound: f64, most_steps: usize) -> Numbers {
        let mut here = start;
        let mut residuals = self.residuals(&here);
        let mut squares = self.squares(&residuals, Orders::All);
        let mut lowest = cost(&squares, bound);
        let mut damping = 1e-3;
        for _ in 0..most_steps {
            let (normal, gradient) = self.normal(&here, &residuals, &squares, bound);
            // Numbers that nothing depends on, as the slope of alpha at one distance, stay.
            let floor = 1e-12 * normal.diagonal().max() + f64::MIN_POSITIVE;
            let mut moved = None;
            while damping < 1e12 {
                let diagonal = normal.diagonal().map(|d| d * damping + floor);
                let step = (normal + Matrix6::from_diagonal(&diagonal))
                    .cholesky()
                    .map(|c| -c.solve(&gradient));
                if let Some(step) = step.filter(|s| s.iter().all(|x| x.is_finite())) {
                    let trial = here + step.component_mul(&self.scales);
                    let there = self.residuals(&trial);
                    let trial_squares = self.squares(&there, Orders::All);
                    let trial_cost = cost(&trial_squares, bound);
                    if trial_cost < lowest {
                        let gain = (lowest - trial_cost) / lowest;
                        here = trial;
                        residuals = there;
                        squares = trial_squares;
                        lowest = trial_cost;
                        damping = (damping * 0.2).max(1e-12);
                        moved = Some((step.norm(), gain));
                        break;
                    }
                }
                damping *= 6.0;
            }
            match moved {
                None => break,
                Some((step, gain)) if step < 1e-11 || (step < 1e-5 && gain < 1e-9) => break,
                Some(_) => {}
            }
        }
        here
    }

    /// Normal matrix and gradient in units of `scales`, tiles weighed by Cauchy's rule.
    fn normal(
        &self,
        here: &Numbers,
        residuals: &[[f64; MOMENTS]],
        squares: &[f64],
        bound: f64,
    ) -> (Matrix6<f64>, Vector6<f64>) {
        let slopes: [Vec<[f64; MOMENTS]>; 6] = std::array::from_fn(|k| {
            let mut probe = Numbers::zeros();
            probe[k] = PROBE * self.scales[k];
            let low = self.residuals(&(here - probe));
            let mut slope = self.residuals(&(here + probe));
            for (high, low) in slope.iter_mut().zip(&low) {
                for (h, l) in high.iter_mut().zip(low) {
                    *h = (*h - l) / (2.0 * PROBE);
                }
            }
            slope
        });
        let mut normal = Matrix6::zeros();
        let mut gradient = Vector6::zeros();
        for tile in 0..residuals.len() {
            let weight = 1.0 / (1.0 + squares[tile] / (bound * bound));
            for m in 0..MOMENTS {
                let row = Vector6::from_fn(|k, _| slopes[k][tile][m]);
                normal += row * row.transpose() * weight;
                gradient += row * (residuals[tile][m] * weight);
            }
        }
        (normal, gradient)
    }
}

fn cost(squares: &[f64], bound: f64) -> f64 {
    squares.iter().map(|s| (s / (bound * bound)).ln_1p()).sum()
}

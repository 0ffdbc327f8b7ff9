//! Initial estimates of the five reduced numbers of one channel, from moments of orders 2, 3 and 4.
//!
//! Second and third moments do not separate defocus from spherical aberration where coma and astigmatism are
//! small. Fourth moments do (docs/background/model.md section 8), but at a single distance not always
//! uniquely, so the misfit has several local minima. The search is a multi-start Levenberg-Marquardt. It
//! starts from the closed-form inverse of S1..S10 of every distance with all choices of sign, and from a grid
//! over the variance shares of defocus and spherical aberration.

mod moment_problem;

use rayon::prelude::*;

use super::plane::{Weighting, fit_plane};
use crate::measure::MeasuredTile;
use moment_problem::{MomentProblem, Orders, Parameters, TileEquation};
use seidel_optics::field::Frame;
use seidel_optics::lens::{MomentCoefficients, ReducedNumbers};
use seidel_optics::numeric::median;

/// An initial estimate for a pixel fit. Lengths in px of the PSF, field in half frame widths.
///
/// (alpha, beta, gamma, delta) and their negatives give the same PSF. The sign is chosen so that alpha rises
/// with vergence; at a single distance so that delta is not negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialEstimate {
    /// Defocus at vergence v (1/m): `alpha[0] + alpha[1] * v`, in px and px m. The slope is zero for a single
    /// distance.
    pub alpha: [f64; 2],
    /// Spherical aberration, px.
    pub beta: f64,
    /// Astigmatism, px per field unit².
    pub gamma: f64,
    /// Field curvature, px per field unit².
    pub delta: f64,
    /// Coma, px per field unit.
    pub phi: f64,
    /// Robust relative misfit of the moments: for small misfits the root mean square over tiles of the
    /// residual over size^order.
    pub misfit: f64,
}

impl InitialEstimate {
    /// Returns the reduced numbers at `vergence_per_m` (1/m).
    pub fn reduced(&self, vergence_per_m: f64) -> ReducedNumbers {
        ReducedNumbers {
            alpha: self.alpha[0] + self.alpha[1] * vergence_per_m,
            beta: self.beta,
            gamma: self.gamma,
            delta: self.delta,
            phi: self.phi,
        }
    }
}

/// Maximum number of tiles. More do not improve the estimate.
const MAX_TILES: usize = 300;
/// Number of tiles on which candidates are screened.
const SCREENING_TILES: usize = 100;
const SCREENING_ITERATIONS: usize = 15;
/// Candidates refined on all tiles.
const MAX_REFINED: usize = 24;
const REFINE_ITERATIONS: usize = 60;
/// Scale of the Cauchy loss, relative misfit, while candidates are coarse.
const COARSE_CAUCHY_SCALE: f64 = 0.1;
/// Scale of the Cauchy loss in the last iterations, in units of the median misfit. It is at least 0.01, so
/// that tiles with moments right to a per cent keep full weight.
const CAUCHY_SCALE_OVER_MEDIAN: f64 = 2.0;
const MIN_CAUCHY_SCALE: f64 = 0.01;
/// Relative difference below which two estimates count as one.
const DUPLICATE_TOLERANCE: f64 = 0.03;
/// Ratio of misfits in orders 2 and 3 up to which the solution of opposite beta is returned as well.
const MAX_MIRROR_MISFIT_RATIO: f64 = 1.1;

/// Returns up to `most` distinct local minima of the moment misfit, best first.
///
/// `tiles` are of one channel. Unknown distances count as vergence 0. Empty where no tile has finite moments.
///
/// Without coma the sign of beta shows in fourth moments alone, which are the noisiest. The best estimate
/// with opposite beta is then included, replacing the last one if necessary.
pub fn initial_estimates(
    frame: &Frame,
    tiles: &[&MeasuredTile],
    most: usize,
) -> Vec<InitialEstimate> {
    let vergence = |tile: &MeasuredTile| tile.distance.vergence_per_m().unwrap_or(0.0);
    let mut vergences: Vec<f64> = tiles.iter().map(|tile| vergence(tile)).collect();
    vergences.sort_by(f64::total_cmp);
    vergences.dedup();
    let groups: Vec<Vec<&MeasuredTile>> = vergences
        .iter()
        .map(|&v| {
            let group: Vec<&MeasuredTile> = tiles
                .iter()
                .copied()
                .filter(|tile| vergence(tile) == v)
                .collect();
            sample_by_radius(frame, &group, MAX_TILES.div_ceil(vergences.len()))
        })
        .collect();
    let Some(lens) = ChannelProblem::new(frame, &vergences, &groups) else {
        return Vec::new();
    };
    let (mut found, cauchy_scale) = lens.minima();
    found.truncate(most.max(1));
    lens.add_opposite_beta(&mut found, cauchy_scale, most);
    found.truncate(most);
    found
        .iter()
        .map(|(numbers, misfit)| lens.start(numbers, *misfit))
        .collect()
}

/// Returns up to `most` of `tiles`, evenly spaced in rank of field radius.
fn sample_by_radius<'a>(
    frame: &Frame,
    tiles: &[&'a MeasuredTile],
    most: usize,
) -> Vec<&'a MeasuredTile> {
    let mut sorted = tiles.to_vec();
    let radius = |tile: &MeasuredTile| tile.field_point(frame).radius();
    sorted.sort_by(|a, b| radius(a).total_cmp(&radius(b)));
    let taken = most.min(sorted.len());
    (0..taken)
        .map(|k| sorted[(2 * k + 1) * sorted.len() / (2 * taken)])
        .collect()
}

/// The estimation problem of one channel, with the statistics of each distance.
struct ChannelProblem {
    problem: MomentProblem,
    screening: MomentProblem,
    /// Mid vergence and half the range, 1/m.
    vergence: (f64, f64),
    /// Largest field radius of a tile.
    reach: f64,
    /// On-axis variance at each distance, px².
    variances: Vec<f64>,
    /// S1..S10 at each distance, where determined.
    planes: Vec<Option<MomentCoefficients>>,
}

impl ChannelProblem {
    fn new(frame: &Frame, vergences: &[f64], groups: &[Vec<&MeasuredTile>]) -> Option<Self> {
        let equations = |most: usize| -> Vec<TileEquation> {
            groups
                .iter()
                .enumerate()
                .flat_map(|(plane, group)| {
                    sample_by_radius(frame, group, most)
                        .into_iter()
                        .filter_map(move |tile| TileEquation::new(frame, tile, plane))
                })
                .collect()
        };
        let all = equations(usize::MAX);
        if all.is_empty() {
            return None;
        }
        let (first, last) = (*vergences.first()?, *vergences.last()?);
        let (mid, half) = ((first + last) / 2.0, (last - first) / 2.0);
        let reach = groups
            .iter()
            .flatten()
            .map(|tile| tile.field_point(frame).radius())
            .fold(1e-3, f64::max);
        let planes: Vec<Option<MomentCoefficients>> = groups
            .par_iter()
            .map(|group| {
                fit_plane(frame, group, Weighting::Weighted)
                    .ok()
                    .map(|fit| fit.s)
            })
            .collect();
        let variances: Vec<f64> = groups
            .iter()
            .zip(&planes)
            .map(|(group, plane)| on_axis_variance(group, plane.as_ref()))
            .collect();
        let size = finite_median(variances.iter().map(|v| 2.0 * v.sqrt()).collect());
        let per_field2 = size / (reach * reach);
        let scales = Parameters::new(size, size, size, per_field2, per_field2, size / reach);
        let problem = |equations| MomentProblem {
            equations,
            scaled_vergences: vergences
                .iter()
                .map(|v| if half > 0.0 { (v - mid) / half } else { 0.0 })
                .collect(),
            scales,
        };
        Some(Self {
            problem: problem(all),
            screening: problem(equations(SCREENING_TILES.div_ceil(groups.len()))),
            vergence: (mid, half),
            reach,
            variances,
            planes,
        })
    }

    /// Returns the distinct local minima with their misfits, best first, and the Cauchy scale of the last
    /// iterations.
    fn minima(&self) -> (Vec<(Parameters, f64)>, f64) {
        let screened: Vec<(Parameters, f64)> = self
            .candidates()
            .into_par_iter()
            .map(|start| {
                let end = self.normalise_sign(self.screening.minimise(
                    start,
                    COARSE_CAUCHY_SCALE,
                    SCREENING_ITERATIONS,
                ));
                (
                    end,
                    self.screening
                        .misfit(&end, COARSE_CAUCHY_SCALE, Orders::All),
                )
            })
            .collect();
        let mut screened = self.distinct(screened);
        screened.truncate(MAX_REFINED);
        let refined: Vec<Parameters> = screened
            .par_iter()
            .map(|(start, _)| {
                self.problem
                    .minimise(*start, COARSE_CAUCHY_SCALE, REFINE_ITERATIONS)
            })
            .collect();
        let median_misfit = refined
            .iter()
            .map(|numbers| self.problem.median_misfit(numbers))
            .fold(f64::INFINITY, f64::min);
        let cauchy_scale =
            (CAUCHY_SCALE_OVER_MEDIAN * median_misfit).clamp(MIN_CAUCHY_SCALE, COARSE_CAUCHY_SCALE);
        let finished = refined
            .into_par_iter()
            .map(|start| {
                let end = self.normalise_sign(self.problem.minimise(
                    start,
                    cauchy_scale,
                    REFINE_ITERATIONS,
                ));
                (end, self.problem.misfit(&end, cauchy_scale, Orders::All))
            })
            .collect();
        (self.distinct(finished), cauchy_scale)
    }

    /// Sorts `found` by misfit and removes duplicates.
    fn distinct(&self, mut found: Vec<(Parameters, f64)>) -> Vec<(Parameters, f64)> {
        found.retain(|(numbers, misfit)| {
            misfit.is_finite() && numbers.iter().all(|x| x.is_finite())
        });
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut kept: Vec<(Parameters, f64)> = Vec::new();
        for (numbers, misfit) in found {
            if !kept.iter().any(|(other, _)| self.same(&numbers, other)) {
                kept.push((numbers, misfit));
            }
        }
        kept
    }

    /// Returns the numbers as PSF lengths at the edge of the field.
    fn lengths(&self, numbers: &Parameters) -> Parameters {
        let h = self.reach;
        numbers.component_mul(&Parameters::new(1.0, 1.0, 1.0, h * h, h * h, h))
    }

    fn same(&self, a: &Parameters, b: &Parameters) -> bool {
        // Near delta = 0 either sign may have been chosen.
        let negated = negate_pupil(b);
        [b, &negated].into_iter().any(|b| {
            let (a, b) = (self.lengths(a), self.lengths(b));
            let far = (a - b).abs();
            let size = a.abs().sup(&b.abs());
            let defocus = size[0].max(size[1]);
            let rest = size.fixed_rows::<4>(2).max().max(0.01 * defocus);
            far[0].max(far[1]) < DUPLICATE_TOLERANCE * defocus.max(rest)
                && far.fixed_rows::<4>(2).max() < DUPLICATE_TOLERANCE * rest
        })
    }

    /// Returns the representative of two equivalent solutions.
    fn normalise_sign(&self, numbers: Parameters) -> Parameters {
        let positive = if self.vergence.1 > 0.0 {
            numbers[1] >= 0.0
        } else {
            numbers[4] >= 0.0
        };
        if positive {
            numbers
        } else {
            negate_pupil(&numbers)
        }
    }

    fn start(&self, numbers: &Parameters, misfit: f64) -> InitialEstimate {
        let (mid, half) = self.vergence;
        let slope = if half > 0.0 { numbers[1] / half } else { 0.0 };
        InitialEstimate {
            alpha: [numbers[0] - slope * mid, slope],
            beta: numbers[2],
            gamma: numbers[3],
            delta: numbers[4],
            phi: numbers[5],
            misfit,
        }
    }

    /// Adds the best solution with opposite beta where orders 2 and 3 do not exclude it and `found` lacks it.
    fn add_opposite_beta(
        &self,
        found: &mut Vec<(Parameters, f64)>,
        cauchy_scale: f64,
        most: usize,
    ) {
        let Some(&(best, _)) = found.first() else {
            return;
        };
        // S1, S2 and S3 are invariant if alpha/2 + beta/3 and beta² are.
        let mut mirrored = best;
        mirrored[0] += 4.0 / 3.0 * best[2];
        mirrored[2] = -best[2];
        let mirrored = self.normalise_sign(mirrored);
        if found.iter().any(|(known, _)| self.same(known, &mirrored)) {
            return;
        }
        let below = |numbers: &Parameters| {
            self.problem
                .misfit(numbers, cauchy_scale, Orders::BelowFourth)
        };
        if below(&mirrored) > MAX_MIRROR_MISFIT_RATIO * below(&best) + 1e-6 {
            return;
        }
        found.truncate(most.saturating_sub(1).max(1));
        found.push((
            mirrored,
            self.problem.misfit(&mirrored, cauchy_scale, Orders::All),
        ));
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
    }

    /// Returns the starting points of the search.
    fn candidates(&self) -> Vec<Parameters> {
        let mut all = Vec::new();
        for (plane, s) in self.planes.iter().enumerate() {
            for numbers in s.iter().filter_map(ReducedNumbers::branches).flatten() {
                self.add_branch(plane, &numbers, &mut all);
            }
        }
        self.add_grid(&mut all);
        all.retain(|numbers| numbers.iter().all(|x| x.is_finite()));
        all
    }

    /// Returns |alpha + 2/3 beta| that gives the on-axis variance of a distance.
    fn half_axis(&self, plane: usize, beta: f64) -> f64 {
        2.0 * (self.variances[plane] - beta * beta / 72.0).max(0.0).sqrt()
    }

    /// Adds a closed-form solution of one distance, with alpha extrapolated so that the farthest distance has
    /// its on-axis variance.
    fn add_branch(&self, plane: usize, found: &ReducedNumbers, all: &mut Vec<Parameters>) {
        let largest = 4.0 * self.problem.scales;
        let limit = |value: f64, k: usize| value.clamp(-largest[k], largest[k]);
        let of = |alpha: f64, slope: f64| {
            Parameters::new(
                alpha,
                slope,
                limit(found.beta, 2),
                limit(found.gamma, 3),
                limit(found.delta, 4),
                limit(found.phi, 5),
            )
        };
        let scaled_vergences = &self.problem.scaled_vergences;
        if scaled_vergences.len() == 1 {
            all.push(of(found.alpha, 0.0));
            return;
        }
        let far = if scaled_vergences[plane] > 0.0 {
            0
        } else {
            scaled_vergences.len() - 1
        };
        for sign in [1.0, -1.0] {
            let there = -2.0 / 3.0 * found.beta + sign * self.half_axis(far, found.beta);
            let slope = (there - found.alpha) / (scaled_vergences[far] - scaled_vergences[plane]);
            all.push(of(found.alpha - slope * scaled_vergences[plane], slope));
        }
    }

    /// Adds a grid over variance shares of defocus and spherical aberration and over astigmatism and field
    /// curvature. Coma follows from third moments.
    fn add_grid(&self, all: &mut Vec<Parameters>) {
        let least = self.variances.iter().copied().fold(f64::INFINITY, f64::min);
        let curvature_pairs = self.curvature_pairs();
        for degrees in [-75.0_f64, -45.0, -20.0, -5.0, 5.0, 20.0, 45.0, 75.0] {
            let beta = (72.0 * least).sqrt() * degrees.to_radians().sin();
            for (alpha, slope) in self.defocus_lines(beta) {
                let phi = self.coma_estimate(alpha, slope, beta);
                for &(gamma, delta) in &curvature_pairs {
                    all.push(Parameters::new(alpha, slope, beta, gamma, delta, phi));
                }
            }
        }
    }

    /// Returns the three best-fitting lines alpha(vergence) as value at mid vergence and slope. Alpha has one
    /// of two values at every distance; it crosses focus between two distances or outside them.
    fn defocus_lines(&self, beta: f64) -> Vec<(f64, f64)> {
        let scaled_vergences = &self.problem.scaled_vergences;
        let count = scaled_vergences.len();
        let mut found: Vec<(f64, (f64, f64))> = (0..=count)
            .map(|crossing| {
                let alphas: Vec<f64> = (0..count)
                    .map(|plane| {
                        let sign = if plane < crossing { -1.0 } else { 1.0 };
                        -2.0 / 3.0 * beta + sign * self.half_axis(plane, beta)
                    })
                    .collect();
                line(scaled_vergences, &alphas, &self.variances)
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().take(3).map(|(_, line)| line).collect()
    }

    /// Returns pairs of gamma and delta to try.
    fn curvature_pairs(&self) -> Vec<(f64, f64)> {
        let scale = self.problem.scales[3];
        let size = |of: fn(&[f64; 10]) -> f64| {
            let known: Vec<f64> = self
                .planes
                .iter()
                .flatten()
                .map(|s| 2.0 * of(&s.0).max(0.0).sqrt())
                .collect();
            let found = if known.is_empty() {
                0.0
            } else {
                finite_median(known)
            };
            found.clamp(0.05 * scale, scale)
        };
        let sagittal = size(|s| s[4]);
        let meridional = size(|s| s[3] + s[4]);
        let mut pairs = vec![(0.0, 0.0)];
        // At a single distance the negative delta is the same lens.
        let signs: &[f64] = if self.vergence.1 > 0.0 {
            &[1.0, -1.0]
        } else {
            &[1.0]
        };
        for delta in signs.iter().map(|sign| sign * sagittal) {
            for both in [meridional, -meridional] {
                pairs.push((both - delta, delta));
            }
        }
        pairs
    }

    /// Returns phi from the third moments near the axis at the distance of the widest PSFs.
    fn coma_estimate(&self, alpha: f64, slope: f64, beta: f64) -> f64 {
        let widest = (0..self.variances.len())
            .filter(|&plane| self.planes[plane].is_some())
            .max_by(|&a, &b| self.variances[a].total_cmp(&self.variances[b]));
        let Some((plane, s)) = widest.and_then(|p| self.planes[p].as_ref().map(|s| (p, s))) else {
            return 0.0;
        };
        let a = alpha + slope * self.problem.scaled_vergences[plane];
        let per_phi = a * a / 6.0 + 7.0 * a * beta / 24.0 + beta * beta / 8.0;
        let most = 0.5 * self.problem.scales[5];
        if per_phi > 0.0 {
            (-s.0[9] / per_phi).clamp(-most, most)
        } else {
            0.0
        }
    }
}

/// Returns the equivalent numbers of the inverted pupil.
fn negate_pupil(numbers: &Parameters) -> Parameters {
    numbers.component_mul(&Parameters::new(-1.0, -1.0, -1.0, -1.0, -1.0, 1.0))
}

/// Returns S1, bounded below by a tenth of the median variance: near focus a fitted S1 may be zero or
/// negative.
fn on_axis_variance(group: &[&MeasuredTile], plane: Option<&MomentCoefficients>) -> f64 {
    let median_misfit = finite_median(group.iter().map(|t| t.optical.trace() / 2.0).collect());
    let least = (0.1 * median_misfit).max(0.01);
    plane.map_or(median_misfit, |s| s.0[0]).max(least)
}

/// Returns the median of the finite `values`, 1 if there are none.
fn finite_median(mut values: Vec<f64>) -> f64 {
    values.retain(|v| v.is_finite());
    if values.is_empty() {
        1.0
    } else {
        median(&mut values)
    }
}

/// Fits a line through `values` with weights 1 / `variances`. Returns its mean square error, and its value at
/// 0 and slope.
fn line(scaled_vergences: &[f64], values: &[f64], variances: &[f64]) -> (f64, (f64, f64)) {
    let weights: Vec<f64> = variances.iter().map(|v| 1.0 / v).collect();
    let mean = |of: &dyn Fn(usize) -> f64| {
        let sum: f64 = (0..weights.len()).map(|k| weights[k] * of(k)).sum();
        sum / weights.iter().sum::<f64>()
    };
    let (x, y) = (mean(&|k| scaled_vergences[k]), mean(&|k| values[k]));
    let sample_by_radius = mean(&|k| (scaled_vergences[k] - x).powi(2));
    let slope = if sample_by_radius > 0.0 {
        mean(&|k| (scaled_vergences[k] - x) * (values[k] - y)) / sample_by_radius
    } else {
        0.0
    };
    let error = mean(&|k| (values[k] - y - slope * (scaled_vergences[k] - x)).powi(2));
    (error, (y - slope * x, slope))
}

#[cfg(test)]
mod tests;

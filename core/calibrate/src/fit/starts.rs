//! Where a fit to pixels may start: the five reduced numbers of one channel over all its distances,
//! from moments of orders 2, 3 and 4.
//!
//! Second and third moments alone do not tell defocus from spherical aberration where coma and
//! astigmatism are small; fourth moments do (docs/background/model.md section 8), but at one distance not always
//! uniquely: a disc and a folded one several times as strong in both can agree up to fourth order.
//! So there are several local minima, and the problem is solved from many places: from the closed-form
//! inverse of every distance's S1..S10 with all its choices of sign, and from a grid of shares of the
//! variance that each number may have.

mod descent;

use rayon::prelude::*;

use super::plane::{Weighting, fit_plane};
use crate::measure::MeasuredTile;
use descent::{Equation, Numbers, Orders, Problem};
use seidel_optics::field::Frame;
use seidel_optics::lens::{MomentCoefficients, ReducedNumbers};

/// Where a pixel fit may start. Lengths in px of the PSF, field in half frame widths.
///
/// (alpha, beta, gamma, delta) and minus all four give the same PSF: where alpha changes with
/// vergence it rises, elsewhere delta is not negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Defocus at vergence v (1/m) is the first of these (px) plus the second (px m) times v. The slope is zero where all
    /// tiles lie at one distance.
    pub alpha: [f64; 2],
    /// Spherical aberration, px.
    pub beta: f64,
    /// Astigmatism, px per field unit².
    pub gamma: f64,
    /// Field curvature, px per field unit².
    pub delta: f64,
    /// Coma, px per field unit.
    pub phi: f64,
    /// Relative misfit of the moments: about the root mean square over tiles of residual over
    /// size^order, bad tiles counting little.
    pub misfit: f64,
}

impl Start {
    /// The reduced numbers at vergence `vergence_per_m` (1/m).
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

/// Tiles that take part at most: more sharpen no start.
const MOST_TILES: usize = 300;
/// Tiles on which candidates are told apart.
const SIEVE_TILES: usize = 100;
const SIEVE_STEPS: usize = 15;
/// Candidates refined on all tiles.
const MOST_REFINED: usize = 24;
const REFINE_STEPS: usize = 60;
/// Relative misfit beyond which a tile counts as bad while candidates are coarse.
const COARSE_BOUND: f64 = 0.1;
/// The same for the last steps is this many times the typical misfit, within limits: a tile whose
/// moments are right to a per cent is never bad.
const BOUND_OVER_TYPICAL: f64 = 2.0;
const FINEST_BOUND: f64 = 0.01;
/// Starts whose numbers agree to this share of their size are one.
const SAME: f64 = 0.03;
/// How much worse the other sign of beta may meet moments below the fourth order and still be offered.
const TWIN_EXCESS: f64 = 1.1;

/// Up to `most` distinct local minima of the misfit of `tiles`, which are of one channel, best first.
/// Tiles at unknown distance count as at vergence 0. Empty where no tile has finite moments.
///
/// Without coma the sign of beta shows in fourth moments alone, which measured tiles know least; the
/// best start with its other sign is then among those returned, last where its misfit ranks below.
pub fn starts(frame: &Frame, tiles: &[&MeasuredTile], most: usize) -> Vec<Start> {
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
            spread(frame, &group, MOST_TILES.div_ceil(vergences.len()))
        })
        .collect();
    let Some(lens) = Lens::new(frame, &vergences, &groups) else {
        return Vec::new();
    };
    let (mut found, bound) = lens.minima();
    found.truncate(most.max(1));
    lens.add_twin(&mut found, bound, most);
    found.truncate(most);
    found
        .iter()
        .map(|(numbers, misfit)| lens.start(numbers, *misfit))
        .collect()
}

/// Up to `most` of `tiles`, evenly taken by field radius.
fn spread<'a>(frame: &Frame, tiles: &[&'a MeasuredTile], most: usize) -> Vec<&'a MeasuredTile> {
    let mut sorted = tiles.to_vec();
    let radius = |tile: &MeasuredTile| tile.field_point(frame).radius();
    sorted.sort_by(|a, b| radius(a).total_cmp(&radius(b)));
    let taken = most.min(sorted.len());
    (0..taken)
        .map(|k| sorted[(2 * k + 1) * sorted.len() / (2 * taken)])
        .collect()
}

/// One channel: its equations, and what each distance says by itself.
struct Lens {
    problem: Problem,
    sieve: Problem,
    /// Mid vergence and half the range, 1/m.
    vergence: (f64, f64),
    /// Largest field radius of a tile.
    reach: f64,
    /// On-axis variance of each distance, px².
    variances: Vec<f64>,
    /// S1..S10 of each distance, where its tiles determine them.
    planes: Vec<Option<MomentCoefficients>>,
}

impl Lens {
    fn new(frame: &Frame, vergences: &[f64], groups: &[Vec<&MeasuredTile>]) -> Option<Self> {
        let equations = |most: usize| -> Vec<Equation> {
            groups
                .iter()
                .enumerate()
                .flat_map(|(plane, group)| {
                    spread(frame, group, most)
                        .into_iter()
                        .filter_map(move |tile| Equation::new(frame, tile, plane))
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
        let size = median(variances.iter().map(|v| 2.0 * v.sqrt()).collect());
        let per_field2 = size / (reach * reach);
        let scales = Numbers::new(size, size, size, per_field2, per_field2, size / reach);
        let problem = |equations| Problem {
            equations,
            places: vergences
                .iter()
                .map(|v| if half > 0.0 { (v - mid) / half } else { 0.0 })
                .collect(),
            scales,
        };
        Some(Self {
            problem: problem(all),
            sieve: problem(equations(SIEVE_TILES.div_ceil(groups.len()))),
            vergence: (mid, half),
            reach,
            variances,
            planes,
        })
    }

    /// Distinct local minima with their misfits, best first, and the relative misfit beyond which a
    /// tile counted as bad.
    fn minima(&self) -> (Vec<(Numbers, f64)>, f64) {
        let sieved: Vec<(Numbers, f64)> = self
            .candidates()
            .into_par_iter()
            .map(|start| {
                let end = self.gauged(self.sieve.descend(start, COARSE_BOUND, SIEVE_STEPS));
                (end, self.sieve.misfit(&end, COARSE_BOUND, Orders::All))
            })
            .collect();
        let mut sieved = self.distinct(sieved);
        sieved.truncate(MOST_REFINED);
        let refined: Vec<Numbers> = sieved
            .par_iter()
            .map(|(start, _)| self.problem.descend(*start, COARSE_BOUND, REFINE_STEPS))
            .collect();
        let typical = refined
            .iter()
            .map(|numbers| self.problem.typical(numbers))
            .fold(f64::INFINITY, f64::min);
        let bound = (BOUND_OVER_TYPICAL * typical).clamp(FINEST_BOUND, COARSE_BOUND);
        let finished = refined
            .into_par_iter()
            .map(|start| {
                let end = self.gauged(self.problem.descend(start, bound, REFINE_STEPS));
                (end, self.problem.misfit(&end, bound, Orders::All))
            })
            .collect();
        (self.distinct(finished), bound)
    }

    /// `found` sorted by misfit without those that are as good as an earlier one.
    fn distinct(&self, mut found: Vec<(Numbers, f64)>) -> Vec<(Numbers, f64)> {
        found.retain(|(numbers, misfit)| {
            misfit.is_finite() && numbers.iter().all(|x| x.is_finite())
        });
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut kept: Vec<(Numbers, f64)> = Vec::new();
        for (numbers, misfit) in found {
            if !kept.iter().any(|(other, _)| self.same(&numbers, other)) {
                kept.push((numbers, misfit));
            }
        }
        kept
    }

    /// The numbers as PSF lengths at the edge of the field.
    fn lengths(&self, numbers: &Numbers) -> Numbers {
        let h = self.reach;
        numbers.component_mul(&Numbers::new(1.0, 1.0, 1.0, h * h, h * h, h))
    }

    fn same(&self, a: &Numbers, b: &Numbers) -> bool {
        // Where delta is next to nothing, either sign may have been chosen.
        let flipped = flip(b);
        [b, &flipped].into_iter().any(|b| {
            let (a, b) = (self.lengths(a), self.lengths(b));
            let far = (a - b).abs();
            let size = a.abs().sup(&b.abs());
            let defocus = size[0].max(size[1]);
            let rest = size.fixed_rows::<4>(2).max().max(0.01 * defocus);
            far[0].max(far[1]) < SAME * defocus.max(rest)
                && far.fixed_rows::<4>(2).max() < SAME * rest
        })
    }

    /// The one of two equivalent sets of numbers that is reported.
    fn gauged(&self, numbers: Numbers) -> Numbers {
        let positive = if self.vergence.1 > 0.0 {
            numbers[1] >= 0.0
        } else {
            numbers[4] >= 0.0
        };
        if positive { numbers } else { flip(&numbers) }
    }

    fn start(&self, numbers: &Numbers, misfit: f64) -> Start {
        let (mid, half) = self.vergence;
        let slope = if half > 0.0 { numbers[1] / half } else { 0.0 };
        Start {
            alpha: [numbers[0] - slope * mid, slope],
            beta: numbers[2],
            gamma: numbers[3],
            delta: numbers[4],
            phi: numbers[5],
            misfit,
        }
    }

    /// Adds the best start with beta of the other sign where moments below the fourth order cannot
    /// tell the two apart and `found` has it not.
    fn add_twin(&self, found: &mut Vec<(Numbers, f64)>, bound: f64, most: usize) {
        let Some(&(best, _)) = found.first() else {
            return;
        };
        // S1, S2 and S3 keep with k = alpha/2 + beta/3 and beta².
        let mut twin = best;
        twin[0] += 4.0 / 3.0 * best[2];
        twin[2] = -best[2];
        let twin = self.gauged(twin);
        if found.iter().any(|(known, _)| self.same(known, &twin)) {
            return;
        }
        let below = |numbers: &Numbers| self.problem.misfit(numbers, bound, Orders::BelowFourth);
        if below(&twin) > TWIN_EXCESS * below(&best) + 1e-6 {
            return;
        }
        found.truncate(most.saturating_sub(1).max(1));
        found.push((twin, self.problem.misfit(&twin, bound, Orders::All)));
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
    }

    /// Places to descend from.
    fn candidates(&self) -> Vec<Numbers> {
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

    /// Size of alpha + 2/3 beta at a distance that gives its on-axis variance.
    fn half_axis(&self, plane: usize, beta: f64) -> f64 {
        2.0 * (self.variances[plane] - beta * beta / 72.0).max(0.0).sqrt()
    }

    /// The numbers of one distance, alpha carried to the others so that the one furthest off has its
    /// on-axis variance.
    fn add_branch(&self, plane: usize, found: &ReducedNumbers, all: &mut Vec<Numbers>) {
        let largest = 4.0 * self.problem.scales;
        let limit = |value: f64, k: usize| value.clamp(-largest[k], largest[k]);
        let of = |alpha: f64, slope: f64| {
            Numbers::new(
                alpha,
                slope,
                limit(found.beta, 2),
                limit(found.gamma, 3),
                limit(found.delta, 4),
                limit(found.phi, 5),
            )
        };
        let places = &self.problem.places;
        if places.len() == 1 {
            all.push(of(found.alpha, 0.0));
            return;
        }
        let far = if places[plane] > 0.0 {
            0
        } else {
            places.len() - 1
        };
        for sign in [1.0, -1.0] {
            let there = -2.0 / 3.0 * found.beta + sign * self.half_axis(far, found.beta);
            let slope = (there - found.alpha) / (places[far] - places[plane]);
            all.push(of(found.alpha - slope * places[plane], slope));
        }
    }

    /// Shares of the on-axis variance for defocus and spherical aberration, signs and sizes of
    /// astigmatism and field curvature, and the coma that the third moments then ask for.
    fn add_grid(&self, all: &mut Vec<Numbers>) {
        let least = self.variances.iter().copied().fold(f64::INFINITY, f64::min);
        let bends = self.bends();
        for degrees in [-75.0_f64, -45.0, -20.0, -5.0, 5.0, 20.0, 45.0, 75.0] {
            let beta = (72.0 * least).sqrt() * degrees.to_radians().sin();
            for (alpha, slope) in self.lines(beta) {
                let phi = self.coma(alpha, slope, beta);
                for &(gamma, delta) in &bends {
                    all.push(Numbers::new(alpha, slope, beta, gamma, delta, phi));
                }
            }
        }
    }

    /// The likeliest alphas, as value at mid vergence and change: at every distance alpha is one of
    /// two, and the smaller one is taken up to some distance and the larger one from there on.
    fn lines(&self, beta: f64) -> Vec<(f64, f64)> {
        let places = &self.problem.places;
        let count = places.len();
        let mut found: Vec<(f64, (f64, f64))> = (0..=count)
            .map(|crossing| {
                let alphas: Vec<f64> = (0..count)
                    .map(|plane| {
                        let sign = if plane < crossing { -1.0 } else { 1.0 };
                        -2.0 / 3.0 * beta + sign * self.half_axis(plane, beta)
                    })
                    .collect();
                line(places, &alphas, &self.variances)
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().take(3).map(|(_, line)| line).collect()
    }

    /// Pairs of gamma and delta worth trying.
    fn bends(&self) -> Vec<(f64, f64)> {
        let scale = self.problem.scales[3];
        let size = |of: fn(&[f64; 10]) -> f64| {
            let known: Vec<f64> = self
                .planes
                .iter()
                .flatten()
                .map(|s| 2.0 * of(&s.0).max(0.0).sqrt())
                .collect();
            let found = if known.is_empty() { 0.0 } else { median(known) };
            found.clamp(0.05 * scale, scale)
        };
        let sagittal = size(|s| s[4]);
        let meridional = size(|s| s[3] + s[4]);
        let mut pairs = vec![(0.0, 0.0)];
        // At one distance the other sign of delta is the same lens.
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

    /// phi from the third moments near the axis of the widest PSFs.
    fn coma(&self, alpha: f64, slope: f64, beta: f64) -> f64 {
        let widest = (0..self.variances.len())
            .filter(|&plane| self.planes[plane].is_some())
            .max_by(|&a, &b| self.variances[a].total_cmp(&self.variances[b]));
        let Some((plane, s)) = widest.and_then(|p| self.planes[p].as_ref().map(|s| (p, s))) else {
            return 0.0;
        };
        let a = alpha + slope * self.problem.places[plane];
        let per_phi = a * a / 6.0 + 7.0 * a * beta / 24.0 + beta * beta / 8.0;
        let most = 0.5 * self.problem.scales[5];
        if per_phi > 0.0 {
            (-s.0[9] / per_phi).clamp(-most, most)
        } else {
            0.0
        }
    }
}

/// The same PSF by other numbers: the pupil inverted.
fn flip(numbers: &Numbers) -> Numbers {
    numbers.component_mul(&Numbers::new(-1.0, -1.0, -1.0, -1.0, -1.0, 1.0))
}

/// S1, kept to what the PSFs themselves allow: near focus a fitted one may be nothing or negative.
fn on_axis_variance(group: &[&MeasuredTile], plane: Option<&MomentCoefficients>) -> f64 {
    let typical = median(group.iter().map(|t| t.optical.trace() / 2.0).collect());
    let least = (0.1 * typical).max(0.01);
    plane.map_or(typical, |s| s.0[0]).max(least)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(1.0)
}

/// The straight line through `values` at `places`, their errors in proportion to the root of
/// `variances`: its mean square error, and its value at 0 with its slope.
fn line(places: &[f64], values: &[f64], variances: &[f64]) -> (f64, (f64, f64)) {
    let weights: Vec<f64> = variances.iter().map(|v| 1.0 / v).collect();
    let mean = |of: &dyn Fn(usize) -> f64| {
        let sum: f64 = (0..weights.len()).map(|k| weights[k] * of(k)).sum();
        sum / weights.iter().sum::<f64>()
    };
    let (x, y) = (mean(&|k| places[k]), mean(&|k| values[k]));
    let spread = mean(&|k| (places[k] - x).powi(2));
    let slope = if spread > 0.0 {
        mean(&|k| (places[k] - x) * (values[k] - y)) / spread
    } else {
        0.0
    };
    let error = mean(&|k| (values[k] - y - slope * (places[k] - x)).powi(2));
    (error, (y - slope * x, slope))
}

#[cfg(test)]
mod tests;

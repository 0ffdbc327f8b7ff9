//! Search over hypotheses: starting points, minimisation and cross-validation scores.

use nalgebra::DMatrix;

use super::centroid_start;
use super::gap_problem::{FoldSums, GapProblem, LocalMinimum, damped_update, weight};
use super::hypothesis::{Hypothesis, LensChannels};
use super::posterior::contained_in;
use super::subsample::{MIN_EXCESS, Subsample, noise_sum};
use super::tiles::TileData;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::{Effect, SearchStart};
use seidel_optics::psf::pupil::Detail;

/// A hypothesis at its estimated parameters.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) hypothesis: Hypothesis,
    pub(super) theta: Vec<f64>,
    /// Cross-validated weighted mean gap, without noise.
    pub(super) after: f64,
    /// Normal sums at the estimate.
    pub(super) linear: FoldSums,
    /// Tiles of the score and of `linear`.
    pub(super) scored_on: Part,
    /// Effect that does the same in these observations, where this one does not act on the lens.
    pub(super) acts_as: Option<&'static str>,
}

/// A part of the tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// The tiles for comparing starting points.
    Screening,
    /// Those for first searches.
    Few,
    /// Those for comparing hypotheses.
    Many,
}

impl Candidate {
    /// Returns the number of free parameters.
    pub(super) fn freedom(&self) -> usize {
        self.hypothesis.slots.len()
    }

    /// Returns whether a parameter changes the pictures.
    pub(super) fn acts(&self) -> bool {
        let matrix = self.linear.total(None).matrix;
        matrix.diagonal().iter().any(|influence| *influence > 0.0)
    }

    /// Returns the standard errors by the sandwich covariance over tiles.
    pub(super) fn sigma(&self) -> Vec<f64> {
        standard_errors(&self.linear)
    }
}

/// Returns the sandwich standard errors at the linearisation `linear`.
pub(super) fn standard_errors(linear: &FoldSums) -> Vec<f64> {
    let total = linear.total(None);
    let n = total.right.len();
    let mean = total.matrix.diagonal().sum() / n.max(1) as f64;
    let matrix = &total.matrix + DMatrix::identity(n, n) * (1e-10 * mean);
    let Some(inverse) = matrix.try_inverse() else {
        return vec![0.0; n];
    };
    let covariance = &inverse * &total.scores * &inverse;
    (0..n).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect()
}

/// The accuracy of a score.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scoring {
    /// On a draft mesh, for hypotheses that are far from the best.
    Draft,
    /// Without the error of the mesh.
    Full,
}

/// A hypothesis after a few iterations on few tiles.
pub(super) struct Draft {
    hypothesis: Hypothesis,
    theta: Vec<f64>,
    /// Weighted sum of gaps.
    pub(super) cost: f64,
}

/// Starting points of an effect on the fewest tiles, best first; the best after a few iterations.
pub(super) struct Outline {
    starts: Vec<(Hypothesis, LocalMinimum)>,
}

impl Outline {
    fn cost(&self) -> f64 {
        self.starts[0].1.cost
    }
}

/// Search over hypotheses on subsamples of the tiles.
pub(super) struct HypothesisSearch<'a> {
    /// Tiles for comparing starting points.
    pub(super) screening: Subsample<'a>,
    /// Tiles for first searches.
    few: Subsample<'a>,
    /// Tiles for refined searches and comparisons.
    many: Subsample<'a>,
    pub(super) channels: LensChannels,
    /// Vergences of the observed distances, 1/m, rising.
    vergences: Vec<f64>,
    /// Whether PSFs lie far from their predicted positions.
    pub(super) displaced: bool,
}

/// Numbers of tiles for comparing starting points, for first searches, and for comparing hypotheses.
const SCREENING_TILES: usize = 18;
const FIRST_SEARCH_TILES: usize = 36;
const COMPARISON_TILES: usize = 110;
/// Mean noise contribution up to which these numbers suffice.
const MAX_QUIET_NOISE: f64 = 3e-3;
/// Ratio of the gap that a draft leaves to that of the best draft, from which on it is not refined. It has odds of 1 to 4000.
const HOPELESS_RATIO: f64 = 4.0;
/// The same ratio for an effect after a few iterations on the fewest tiles, from which on it is not drafted.
const HOPELESS_OUTLINE_RATIO: f64 = 10.0;
const OUTLINE_ITERATIONS: usize = 2;
/// Number of drafts that are refined at most.
const MAX_COMPLETED: usize = 7;
/// Largest factor of these numbers against noise.
const MOST_TIMES: f64 = 2.0;
/// Lower bound of gaps that are compared, in standard errors by noise.
const RESOLVED_SIGMAS: f64 = 2.0;
/// Starting points that are refined: this many, at most so many with the same free parameters, if their cost is at most this
/// ratio of the best.
pub(super) const REFINED_STARTS: usize = 3;
const STARTS_OF_A_KIND: usize = 2;
const START_RATIO: f64 = 1.5;
/// Relative decreases of the cost at which first and later searches stop.
const COARSE_TOLERANCE: f64 = 0.01;
pub(super) const TOLERANCE: f64 = 1e-3;
/// Damping of the step that the other folds ask for.
pub(super) const LEFT_OUT_DAMPING: f64 = 1e-6;
/// Damping of the step by which starting points are compared.
const SCREENING_DAMPING: f64 = 1e-3;
/// Positions tried along the line from the neutral values (0) to the starting point (1).
const STEP_LENGTHS: [f64; 5] = [1.0, 0.3, 0.1, -0.1, -0.3];
/// The same for an effect that joins others, of which its separate estimate gives the scale.
const JOINT_STEP_LENGTHS: [f64; 3] = [1.0, 0.3, -0.3];

/// Positions tried when starting points are compared.
pub(super) struct Strides {
    lengths: &'static [f64],
    /// Effects that keep their values meanwhile.
    settled: Vec<&'static str>,
}

impl Strides {
    fn of_first() -> Self {
        Self {
            lengths: &STEP_LENGTHS,
            settled: Vec::new(),
        }
    }

    pub(super) fn of_second(one: &Candidate) -> Self {
        Self {
            lengths: &JOINT_STEP_LENGTHS,
            settled: one.hypothesis.ids(),
        }
    }
}

impl<'a> HypothesisSearch<'a> {
    pub(super) fn new(tiles: &'a [TileData], channels: &LensChannels) -> Self {
        // More tiles compensate for noise.
        let noise = tiles.iter().map(|t| t.noise).sum::<f64>() / tiles.len().max(1) as f64;
        let times = (noise / MAX_QUIET_NOISE).clamp(1.0, MOST_TIMES);
        let count = |quiet: usize| (quiet as f64 * times) as usize;
        let nothing = Hypothesis::new(Vec::new(), channels);
        let part = |quiet: usize| Subsample::new(tiles, count(quiet), &nothing);
        let screening = part(SCREENING_TILES);
        Self {
            displaced: centroid_start::are_displaced(&nothing, &screening.tiles),
            screening,
            few: part(FIRST_SEARCH_TILES),
            many: part(COMPARISON_TILES),
            channels: channels.clone(),
            vergences: distinct_vergences(tiles),
        }
    }

    /// Returns the tiles on which hypotheses are compared.
    pub(super) fn many(&self) -> &[&'a TileData] {
        &self.many.tiles
    }

    /// Returns the gap of the given lens in each of them.
    pub(super) fn gaps_before(&self) -> &[f64] {
        &self.many.gaps
    }

    /// Returns the tiles of `part`.
    pub(super) fn part(&self, part: Part) -> &Subsample<'a> {
        match part {
            Part::Screening => &self.screening,
            Part::Few => &self.few,
            Part::Many => &self.many,
        }
    }

    /// Returns the gap that `candidate` leaves in each of the comparison tiles.
    pub(super) fn gaps_left(&self, candidate: &Candidate) -> Vec<f64> {
        if candidate.scored_on == Part::Many {
            return candidate.linear.gaps.clone();
        }
        let problem = self.problem(&candidate.hypothesis, Detail::COARSE);
        problem.gaps(&candidate.theta)
    }

    /// Returns the problem of `hypothesis` on the comparison tiles.
    pub(super) fn problem<'b>(
        &'b self,
        hypothesis: &'b Hypothesis,
        detail: Detail,
    ) -> GapProblem<'b> {
        GapProblem::new(hypothesis, &self.many.tiles, detail)
    }

    /// Returns the sum of weights of the comparison tiles.
    pub(super) fn weight(&self) -> f64 {
        self.many.weight
    }

    /// Returns the null hypothesis: no effect is missing.
    pub(super) fn nothing(&self) -> Hypothesis {
        Hypothesis::new(Vec::new(), &self.channels)
    }

    /// Returns whether `effect` has a free parameter in a lens of this number of channels.
    pub(super) fn can_try(&self, effect: &'static dyn Effect) -> bool {
        self.starts(effect).into_iter().all(|start| {
            let parts = vec![(effect, start)];
            !Hypothesis::new(parts, &self.channels).slots.is_empty()
        })
    }

    /// Returns the starts of `effect` at the observed distances.
    pub(super) fn starts(&self, effect: &'static dyn Effect) -> Vec<SearchStart> {
        effect.starts_at(&self.vergences)
    }

    /// Selects the starting points of `effect` alone.
    pub(super) fn outline(&self, effect: &'static dyn Effect) -> Outline {
        let starts = self.starts(effect).into_iter().map(|start| {
            let hypothesis = Hypothesis::new(vec![(effect, start)], &self.channels);
            let theta = hypothesis.start();
            (hypothesis, theta)
        });
        let mut starts = self.screened(starts.collect(), &Strides::of_first());
        let (hypothesis, best) = &mut starts[0];
        let problem = GapProblem::new(hypothesis, &self.screening.tiles, Detail::DRAFT);
        *best = problem.descend(&best.theta, OUTLINE_ITERATIONS, COARSE_TOLERANCE);
        Outline { starts }
    }

    /// Returns the gap that `effect` leaves after a few iterations on the fewest tiles, less noise.
    pub(super) fn outlined_gap(&self, effect: &'static dyn Effect) -> f64 {
        let from = &self.screening;
        (self.outline(effect).cost() - from.noise) / from.weight
    }

    /// Estimates the parameters of the effects of `outlines` one by one, in a few iterations: the most promising first. Effects
    /// that leave much more of the gap than the best are left as they are.
    pub(super) fn drafts(&self, mut outlines: Vec<Outline>) -> Vec<Draft> {
        outlines.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        let mut least = f64::INFINITY;
        let draft = |outline: Outline| {
            // The cost on more tiles.
            let (from, to) = (&self.screening, &self.few);
            let share = (outline.cost() - from.noise) / from.weight / from.excess;
            let excess = share * to.excess * to.weight;
            let draft = if excess > HOPELESS_OUTLINE_RATIO * least {
                let (hypothesis, best) = outline.starts.into_iter().next().expect("one start");
                Draft {
                    hypothesis,
                    theta: best.theta,
                    cost: excess + to.noise,
                }
            } else {
                self.best(outline.starts)
            };
            least = least.min(self.resolved_excess(draft.cost));
            draft
        };
        outlines.into_iter().map(draft).collect()
    }

    /// Returns `cost` on few tiles without noise, and not below what noise hides.
    fn resolved_excess(&self, cost: f64) -> f64 {
        let variances = self.few.tiles.iter().map(|t| {
            let squared = 2.0 * t.noise * t.noise / t.noise_freedom();
            weight(t).powi(2) * squared
        });
        let floor = RESOLVED_SIGMAS * variances.sum::<f64>().sqrt();
        let floor = floor.max(MIN_EXCESS * self.few.tiles.len() as f64);
        (cost - self.few.noise).max(floor)
    }

    /// Refines and scores the best of `drafts`, and the simpler effects that the first of them contains. Others that leave much more of
    /// the gap than the best are only scored.
    pub(super) fn singles(&self, mut drafts: Vec<Draft>) -> Vec<Candidate> {
        drafts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let most = drafts
            .first()
            .map_or(0.0, |best| HOPELESS_RATIO * self.resolved_excess(best.cost));
        let leader = (drafts.first()).map(|best| (best.hypothesis.clone(), best.theta.clone()));
        let ranked = drafts.into_iter().enumerate();
        let scored = ranked.map(|(rank, draft)| {
            let container = leader.as_ref().filter(|(leader, _)| {
                contained_in(leader.ids()[0]).any(|id| draft.hypothesis.ids() == [id])
            });
            if let Some((leader, theta)) = container {
                self.completed(self.within(draft, leader, theta))
            } else if rank >= MAX_COMPLETED || self.resolved_excess(draft.cost) > most {
                self.scored(
                    draft.hypothesis,
                    draft.theta,
                    Part::Screening,
                    Scoring::Draft,
                )
            } else {
                self.completed(draft)
            }
        });
        let mut singles: Vec<Candidate> = scored.collect();
        singles.sort_by(|a, b| a.after.total_cmp(&b.after));
        singles
    }

    /// Returns `draft` of an effect that the effect of `container` contains, where its part in that effect at `theta` leads if that
    /// is better.
    fn within(&self, draft: Draft, container: &Hypothesis, theta: &[f64]) -> Draft {
        let values = container.values(theta, self.channels.reference());
        let (simpler, (outer, _)) = (draft.hypothesis.parts[0].0, &container.parts[0]);
        let Some(values) = outer.contained_values(simpler, &values[0]) else {
            return draft;
        };
        let slots = draft.hypothesis.slots.iter();
        let theta: Vec<f64> = slots
            .map(|s| values[s.parameter].clamp(s.least, s.most))
            .collect();
        let problem = GapProblem::new(&draft.hypothesis, &self.few.tiles, Detail::DRAFT);
        let cost = problem.gap_sum(&theta);
        if cost < draft.cost {
            Draft {
                theta,
                cost,
                ..draft
            }
        } else {
            draft
        }
    }

    /// Refines and scores `draft`.
    pub(super) fn completed(&self, draft: Draft) -> Candidate {
        let problem = GapProblem::new(&draft.hypothesis, &self.few.tiles, Detail::DRAFT);
        let fitted = problem.descend(&draft.theta, 4, COARSE_TOLERANCE);
        self.scored(draft.hypothesis, fitted.theta, Part::Few, Scoring::Full)
    }

    /// Returns the best of `starts` on the fewest tiles, best first.
    pub(super) fn screened(
        &self,
        starts: Vec<(Hypothesis, Vec<f64>)>,
        strides: &Strides,
    ) -> Vec<(Hypothesis, LocalMinimum)> {
        // The same for all starts.
        let mut neutral_cost = None;
        let mut screened: Vec<(Hypothesis, LocalMinimum)> = starts
            .into_iter()
            .map(|(hypothesis, theta)| {
                let fitted = self.screen(&hypothesis, &theta, strides, &mut neutral_cost);
                (hypothesis, fitted)
            })
            .collect();
        screened.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        // Starts with other free parameters come before further ones with the same.
        let mut masks: Vec<Vec<Vec<bool>>> = Vec::new();
        screened.retain(|(hypothesis, _)| {
            let mask = hypothesis.parts.iter().map(|(_, start)| start.free.clone());
            masks.push(mask.collect());
            let (own, before) = masks.split_last().expect("just pushed");
            before.iter().filter(|m| *m == own).count() < STARTS_OF_A_KIND
        });
        screened.truncate(REFINED_STARTS);
        let worst = (screened.first()).map_or(0.0, |best| START_RATIO * best.1.cost);
        screened.retain(|start| start.1.cost <= worst);
        screened
    }

    /// Refines `starts` and returns the best.
    pub(super) fn best(&self, starts: Vec<(Hypothesis, LocalMinimum)>) -> Draft {
        let mut tried: Vec<(Hypothesis, LocalMinimum)> = starts
            .into_iter()
            .map(|(hypothesis, start)| {
                let problem = GapProblem::new(&hypothesis, &self.few.tiles, Detail::DRAFT);
                let fitted = problem.descend(&start.theta, 2, COARSE_TOLERANCE);
                (hypothesis, fitted)
            })
            .collect();
        tried.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        let (hypothesis, fitted) = tried.swap_remove(0);
        Draft {
            hypothesis,
            theta: fitted.theta,
            cost: fitted.cost,
        }
    }

    /// Line search from the neutral values through `theta`, because the scale of an effect is unknown and a
    /// gradient search needs overlapping images.
    /// `neutral_cost` is the cost at the neutral values, once it is known.
    fn screen(
        &self,
        hypothesis: &Hypothesis,
        theta: &[f64],
        strides: &Strides,
        neutral_cost: &mut Option<f64>,
    ) -> LocalMinimum {
        let mut neutral = hypothesis.neutral();
        for ((slot, neutral), value) in hypothesis.slots.iter().zip(&mut neutral).zip(theta) {
            if strides
                .settled
                .contains(&hypothesis.parts[slot.part].0.id())
            {
                *neutral = *value;
            }
        }
        let problem = GapProblem::new(hypothesis, &self.screening.tiles, Detail::DRAFT);
        // A stop too large to clip has zero gradient, so unchanged cost disqualifies a point.
        let neutral_cost = *neutral_cost.get_or_insert_with(|| problem.gap_sum(&neutral));
        let is_likely = (hypothesis.parts.iter())
            .filter(|(effect, _)| !strides.settled.contains(&effect.id()))
            .all(|(_, start)| start.is_likely);
        let lengths = &strides.lengths[..if is_likely { 1 } else { strides.lengths.len() }];
        let tiles = &self.screening.tiles;
        let is_carried = centroid_start::is_carried(hypothesis, theta, &neutral, tiles);
        let tries = lengths.iter().flat_map(|stride| {
            let there: Vec<f64> = theta
                .iter()
                .zip(&neutral)
                .map(|(to, from)| from + stride * (to - from))
                .collect();
            let placed = (self.displaced || is_carried)
                .then(|| centroid_start::with_placed_centroids(hypothesis, &there, tiles));
            let as_it_is = (!self.displaced).then_some(there);
            as_it_is.into_iter().chain(placed)
        });
        let tries = tries.filter_map(|there| {
            let slots = hypothesis.slots.iter().zip(&there);
            let mut within = slots.map(|(s, v)| (s.least..=s.most).contains(v));
            within.all(|w| w).then(|| LocalMinimum {
                cost: problem.gap_sum(&there),
                theta: there,
            })
        });
        let best = tries
            .filter(|tried| (tried.cost - neutral_cost).abs() > 1e-9 * neutral_cost)
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .unwrap_or_else(|| LocalMinimum {
                theta: theta.to_vec(),
                cost: problem.gap_sum(theta),
            });
        if !is_likely {
            return best;
        }
        // Without a choice of lengths, how far the start is from the best size says more than what it is like: a step comes first.
        let stepped = damped_update(
            problem.linear(&best.theta).total(None),
            &best.theta,
            &hypothesis.slots,
            SCREENING_DAMPING,
        );
        let cost = problem.gap_sum(&stepped);
        if cost < best.cost {
            LocalMinimum {
                theta: stepped,
                cost,
            }
        } else {
            best
        }
    }

    /// Refines `candidate` on the comparison tiles.
    pub(super) fn refined(&self, candidate: Candidate) -> Candidate {
        self.refined_from(candidate.hypothesis, &candidate.theta)
    }

    /// Refines `effect` alone on the comparison tiles, with the free parameters of `start`, from the values `theta`.
    pub(super) fn refined_alone(
        &self,
        effect: &'static dyn Effect,
        start: SearchStart,
        theta: &[f64],
    ) -> Candidate {
        let parts = vec![(effect, start)];
        self.refined_from(Hypothesis::new(parts, &self.channels), theta)
    }

    fn refined_from(&self, hypothesis: Hypothesis, theta: &[f64]) -> Candidate {
        let problem = self.problem(&hypothesis, Detail::COARSE);
        let theta = problem.descend(theta, 5, TOLERANCE).theta;
        self.scored(hypothesis, theta, Part::Many, Scoring::Full)
    }

    /// Scores `candidate`, estimated at another noise level, again on the fewest tiles.
    pub(super) fn rescored(&self, candidate: Candidate) -> Candidate {
        self.scored(
            candidate.hypothesis,
            candidate.theta,
            Part::Screening,
            Scoring::Draft,
        )
    }

    fn scored(
        &self,
        hypothesis: Hypothesis,
        theta: Vec<f64>,
        scored_on: Part,
        scoring: Scoring,
    ) -> Candidate {
        let part = self.part(scored_on);
        let tiles = &part.tiles;
        let detail = match scoring {
            Scoring::Draft => Detail::DRAFT,
            Scoring::Full => Detail::COARSE,
        };
        let linear = GapProblem::new(&hypothesis, tiles, detail).linear(&theta);
        let mut after = left_out_gap(&linear, &theta, &hypothesis, tiles);
        if scoring == Scoring::Full {
            // The discretisation error of the coarse mesh is no gap.
            let fine = GapProblem::new(&hypothesis, tiles, Detail::FULL).gap_sum(&theta);
            after -= (linear.total(None).cost - fine) / part.weight;
        }
        Candidate {
            theta,
            // Scores on few tiles are scaled to the gap of the comparison tiles.
            after: after * self.many.excess / part.excess,
            linear,
            hypothesis,
            scored_on,
            acts_as: None,
        }
    }
}

/// Returns the vergences of `tiles`, rising.
fn distinct_vergences(tiles: &[TileData]) -> Vec<f64> {
    let known = tiles
        .iter()
        .filter(|tile| tile.distance != ObjectDistance::Unknown);
    let mut vergences: Vec<f64> = known.map(|tile| tile.point.vergence_per_m).collect();
    vergences.sort_by(f64::total_cmp);
    vergences.dedup();
    vergences
}

/// Returns the cross-validated weighted mean gap without noise. Each fold is evaluated in the quadratic
/// approximation, at the step that the other folds ask for.
pub(super) fn left_out_gap(
    linear: &FoldSums,
    theta: &[f64],
    hypothesis: &Hypothesis,
    tiles: &[&TileData],
) -> f64 {
    let total_weight: f64 = tiles.iter().map(|t| weight(t)).sum();
    let noise = noise_sum(tiles);
    let mut cost = 0.0;
    for (fold, own) in linear.folds.iter().enumerate() {
        let others = linear.total(Some(fold));
        let there = damped_update(others, theta, &hypothesis.slots, LEFT_OUT_DAMPING);
        let delta = nalgebra::DVector::from_fn(theta.len(), |k, _| there[k] - theta[k]);
        cost += own.cost_after(&delta);
    }
    (cost - noise) / total_weight
}

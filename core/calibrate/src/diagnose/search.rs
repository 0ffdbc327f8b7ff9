//! Hypotheses tried: where their searches start, where they end, and how they do on folds left out.

use nalgebra::DMatrix;

use super::descent::{Fitted, Linear, Problem, weight};
use super::hypothesis::Hypothesis;
use super::seen::Seen;
use seidel_optics::effects::{Effect, SearchStart};
use seidel_optics::psf::pupil::Detail;

/// A hypothesis at its best values.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) hypothesis: Hypothesis,
    pub(super) theta: Vec<f64>,
    /// Weighted mean gap on folds left out, noise taken off.
    pub(super) after: f64,
    /// Normal equations there.
    pub(super) linear: Linear,
}

impl Candidate {
    /// Number of free numbers.
    pub(super) fn freedom(&self) -> usize {
        self.hypothesis.slots.len()
    }

    /// Standard errors, from how tiles differ in what they ask for.
    pub(super) fn sigma(&self) -> Vec<f64> {
        standard_errors(&self.linear)
    }
}

/// Standard errors of the numbers at which `linear` was taken.
pub(super) fn standard_errors(linear: &Linear) -> Vec<f64> {
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

/// The tiles of a search, thinned out for its stages.
pub(super) struct Ground<'a> {
    /// For choosing where to start.
    scouts: Vec<&'a Seen>,
    /// For first searches.
    few: Vec<&'a Seen>,
    /// For searches of what is promising.
    many: Vec<&'a Seen>,
    channels: usize,
    reference: usize,
}

/// Tiles looked at when starts are chosen, in first searches, and when hypotheses are compared.
const SCOUTS: usize = 18;
const FEW: usize = 36;
const MANY: usize = 110;
/// Mean gap by noise up to which so few do.
const QUIET: f64 = 3e-3;
/// Least gap that others are measured by.
const LEAST_EXCESS: f64 = 1e-6;
/// Partners of an effect that are searched in full.
const PROMISING: usize = 2;
/// Starts of its own that the second effect of a pair is given.
const FRESH: usize = 10;
/// Starts from which searches descend.
const DESCENDED: usize = 2;
/// Shares of what is left that a step must gain for a search to go on: a first one, and a later one.
const FIRST_ENOUGH: f64 = 0.01;
const ENOUGH: f64 = 1e-3;
/// How far along a start's direction to look, in its own length.
const STRIDES: [f64; 7] = [1.0, 0.3, 0.1, 0.03, -0.03, -0.1, -0.3];

impl<'a> Ground<'a> {
    pub(super) fn new(tiles: &'a [Seen], channels: usize, reference: usize) -> Self {
        // Where noise hides what effects do, more tiles make up for it.
        let noise = tiles.iter().map(|t| t.noise).sum::<f64>() / tiles.len().max(1) as f64;
        let times = (noise / QUIET).clamp(1.0, 4.0);
        let count = |quiet: usize| (quiet as f64 * times) as usize;
        Self {
            scouts: thinned(tiles, count(SCOUTS)),
            few: thinned(tiles, count(FEW)),
            many: thinned(tiles, count(MANY)),
            channels,
            reference,
        }
    }

    /// Tiles by which hypotheses are compared.
    pub(super) fn many(&self) -> &[&'a Seen] {
        &self.many
    }

    /// `hypothesis` against the tiles by which hypotheses are compared.
    pub(super) fn problem<'b>(&'b self, hypothesis: &'b Hypothesis, detail: Detail) -> Problem<'b> {
        Problem::new(hypothesis, &self.many, detail)
    }

    /// Weighted mean gap of the lens as given on `tiles`, noise taken off.
    pub(super) fn excess(&self, tiles: &[&Seen]) -> f64 {
        let nothing = self.nothing();
        let cost = Problem::new(&nothing, tiles, Detail::FULL).cost(&[]);
        let noise: f64 = tiles.iter().map(|t| weight(t) * t.noise).sum();
        let weights: f64 = tiles.iter().map(|t| weight(t)).sum();
        ((cost - noise) / weights).max(LEAST_EXCESS)
    }

    /// Sum of those tiles' weights.
    pub(super) fn weight(&self) -> f64 {
        self.many.iter().map(|t| weight(t)).sum()
    }

    /// The hypothesis that nothing is missing.
    pub(super) fn nothing(&self) -> Hypothesis {
        Hypothesis::new(Vec::new(), self.channels, self.reference)
    }

    /// Whether `effect` has any number to vary in a lens of as many channels.
    pub(super) fn can_try(&self, effect: &'static dyn Effect) -> bool {
        effect.starts().into_iter().all(|start| {
            let parts = vec![(effect, start)];
            !Hypothesis::new(parts, self.channels, self.reference)
                .slots
                .is_empty()
        })
    }

    /// Searches for the values of `effect` alone.
    pub(super) fn single(&self, effect: &'static dyn Effect) -> Candidate {
        let starts = effect.starts().into_iter().map(|start| {
            let hypothesis = Hypothesis::new(vec![(effect, start)], self.channels, self.reference);
            let theta = hypothesis.start();
            (hypothesis, theta)
        });
        self.best(starts.collect(), None)
    }

    /// Searches for the values of both effects together, from where each is best alone.
    pub(super) fn pair(&self, one: &Candidate, other: &Candidate) -> Candidate {
        self.best(self.joined(one, other), Some(one.hypothesis.ids()[0]))
    }

    /// Both effects in one hypothesis: at their values alone, then the other where it would start afresh.
    fn joined(&self, one: &Candidate, other: &Candidate) -> Vec<(Hypothesis, Vec<f64>)> {
        let part = |c: &Candidate| c.hypothesis.parts[0].clone();
        let alone = |c: &Candidate, start: &SearchStart| {
            let fresh = Hypothesis::new(
                vec![(part(c).0, start.clone())],
                self.channels,
                self.reference,
            );
            let theta = fresh.start();
            (fresh, theta)
        };
        let both = |a: (&Hypothesis, &[f64]), b: (&Hypothesis, &[f64])| {
            let parts = vec![a.0.parts[0].clone(), b.0.parts[0].clone()];
            let joint = Hypothesis::new(parts, self.channels, self.reference);
            let theta = joint
                .slots
                .iter()
                .map(|slot| {
                    let id = joint.parts[slot.part].0.id();
                    let (from, values) = if a.0.parts[0].0.id() == id { a } else { b };
                    let same = from
                        .slots
                        .iter()
                        .position(|s| s.parameter == slot.parameter && s.channel == slot.channel);
                    same.map_or(joint.parts[slot.part].1.values[slot.parameter], |k| {
                        values[k]
                    })
                })
                .collect::<Vec<f64>>();
            (joint, theta)
        };
        let (a, b) = (
            (&one.hypothesis, &one.theta[..]),
            (&other.hypothesis, &other.theta[..]),
        );
        let mut starts = vec![both(a, b)];
        for start in part(other).0.starts().into_iter().take(FRESH) {
            let (fresh, theta) = alone(other, &start);
            starts.push(both(a, (&fresh, &theta)));
        }
        starts
    }

    /// Those of `others` that, joined to `one`, promise most: one step of each on few tiles.
    pub(super) fn promising<'c>(
        &self,
        one: &Candidate,
        others: &[&'c Candidate],
    ) -> Vec<&'c Candidate> {
        let mut promised: Vec<(f64, &Candidate)> = others
            .iter()
            .map(|other| {
                let settled = Some(one.hypothesis.ids()[0]);
                let starts = self.joined(one, other).into_iter();
                let scouted = starts.map(|(hypothesis, theta)| {
                    let fitted = self.scout(&hypothesis, &theta, settled);
                    (hypothesis, fitted)
                });
                let best = scouted.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
                let (hypothesis, start) = best.expect("effects have starts");
                let problem = Problem::new(&hypothesis, &self.scouts, Detail::COARSE);
                (problem.descend(&start.theta, 1, ENOUGH).cost, *other)
            })
            .collect();
        promised.sort_by(|a, b| a.0.total_cmp(&b.0));
        let chosen = promised.into_iter().take(PROMISING);
        chosen.map(|(_, other)| other).collect()
    }

    /// Chooses among `starts` on few tiles, and descends on those. The values of the effect `settled` are
    /// good already.
    fn best(&self, starts: Vec<(Hypothesis, Vec<f64>)>, settled: Option<&str>) -> Candidate {
        let mut scouted: Vec<(Hypothesis, Fitted)> = starts
            .into_iter()
            .map(|(hypothesis, theta)| {
                let fitted = self.scout(&hypothesis, &theta, settled);
                (hypothesis, fitted)
            })
            .collect();
        scouted.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        scouted.truncate(DESCENDED);
        let mut tried: Vec<(Hypothesis, Fitted)> = scouted
            .into_iter()
            .map(|(hypothesis, start)| {
                let problem = Problem::new(&hypothesis, &self.few, Detail::COARSE);
                let fitted = problem.descend(&start.theta, 2, FIRST_ENOUGH);
                (hypothesis, fitted)
            })
            .collect();
        tried.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        let (hypothesis, fitted) = tried.swap_remove(0);
        let problem = Problem::new(&hypothesis, &self.few, Detail::COARSE);
        let fitted = problem.descend(&fitted.theta, 4, FIRST_ENOUGH);
        self.scored(hypothesis, fitted.theta, &self.few)
    }

    /// The best of some points on the line from neutral through `theta`: how far to go is not known, and a
    /// search must start where pictures still overlap.
    fn scout(&self, hypothesis: &Hypothesis, theta: &[f64], settled: Option<&str>) -> Fitted {
        let mut neutral = hypothesis.neutral();
        for ((slot, neutral), value) in hypothesis.slots.iter().zip(&mut neutral).zip(theta) {
            if settled == Some(hypothesis.parts[slot.part].0.id()) {
                *neutral = *value;
            }
        }
        let problem = Problem::new(hypothesis, &self.scouts, Detail::COARSE);
        // Where nothing happens yet, such as behind a stop too large to clip, no search finds its way.
        let still = problem.cost(&neutral);
        let tries = STRIDES.iter().filter_map(|stride| {
            let there: Vec<f64> = theta
                .iter()
                .zip(&neutral)
                .map(|(to, from)| from + stride * (to - from))
                .collect();
            let slots = hypothesis.slots.iter().zip(&there);
            let mut within = slots.map(|(s, v)| (s.least..=s.most).contains(v));
            within.all(|w| w).then(|| Fitted {
                cost: problem.cost(&there),
                theta: there,
            })
        });
        tries
            .filter(|tried| (tried.cost - still).abs() > 1e-9 * still)
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .unwrap_or_else(|| Fitted {
                theta: theta.to_vec(),
                cost: problem.cost(theta),
            })
    }

    /// Searches on with all tiles by which hypotheses are compared.
    pub(super) fn refined(&self, candidate: Candidate) -> Candidate {
        let problem = self.problem(&candidate.hypothesis, Detail::COARSE);
        let theta = problem.descend(&candidate.theta, 5, ENOUGH).theta;
        self.scored(candidate.hypothesis, theta, &self.many)
    }

    /// `candidate`, which a ground of other noise scored on few tiles.
    pub(super) fn rescored(&self, candidate: Candidate) -> Candidate {
        self.scored(candidate.hypothesis, candidate.theta, &self.few)
    }

    fn scored(&self, hypothesis: Hypothesis, theta: Vec<f64>, tiles: &[&Seen]) -> Candidate {
        let linear = Problem::new(&hypothesis, tiles, Detail::COARSE).linear(&theta);
        let left = left_out_gap(&linear, &theta, &hypothesis, tiles);
        // What the coarse mesh misses is no gap.
        let fine = Problem::new(&hypothesis, tiles, Detail::FULL).cost(&theta);
        let weights: f64 = tiles.iter().map(|t| weight(t)).sum();
        let after = left - (linear.total(None).cost - fine) / weights;
        // Tiles differ: what is left on some is told as it would be on those by which all are compared.
        let after = if tiles.len() == self.many.len() {
            after
        } else {
            after * self.excess(&self.many) / self.excess(tiles)
        };
        Candidate {
            theta,
            after,
            linear,
            hypothesis,
        }
    }
}

/// Weighted mean gap over folds, each at the values that the others ask for, noise taken off.
pub(super) fn left_out_gap(
    linear: &Linear,
    theta: &[f64],
    hypothesis: &Hypothesis,
    tiles: &[&Seen],
) -> f64 {
    let total_weight: f64 = tiles.iter().map(|t| weight(t)).sum();
    let noise: f64 = tiles.iter().map(|t| weight(t) * t.noise).sum();
    let mut cost = 0.0;
    for (fold, own) in linear.folds.iter().enumerate() {
        let others = linear.total(Some(fold));
        let there = super::descent::bounded_step(&others, theta, &hypothesis.slots, 1e-6);
        let delta = nalgebra::DVector::from_fn(theta.len(), |k, _| there[k] - theta[k]);
        let quadratic = (&own.matrix * &delta).dot(&delta);
        cost += own.cost - 2.0 * own.right.dot(&delta) + quadratic;
    }
    (cost - noise) / total_weight
}

/// About `count` of `tiles`: all of some observations, spread evenly over the list.
fn thinned(tiles: &[Seen], count: usize) -> Vec<&Seen> {
    if tiles.len() <= count {
        return tiles.iter().collect();
    }
    let mut observations: Vec<usize> = tiles.iter().map(|t| t.observation).collect();
    observations.dedup();
    let wanted = (count * observations.len() / tiles.len()).max(1);
    // A golden-ratio walk meets every distance, whatever the order of the list.
    let chosen: std::collections::BTreeSet<usize> = (0..wanted)
        .map(|k| {
            let turn = (k as f64 + 0.5) * 0.618_033_988_749_895;
            observations[(turn.fract() * observations.len() as f64) as usize]
        })
        .collect();
    tiles
        .iter()
        .filter(|t| chosen.contains(&t.observation))
        .collect()
}

//! Verdict of a diagnosis from the posterior probabilities.

use super::diagnosis::Verdict;
use super::gap_problem::weight;
use super::model_share::MAX_OWN_GAP;
use super::posterior::{
    CandidateScore, GapScale, MIN_GAP, MODEL_ERROR, REAL_GAP_RATIO, nothing_missing, probabilities,
};
use super::search::{Candidate, HypothesisSearch};
use super::tiles::TileData;

/// Share of the gap below which a single effect suffices.
const SUFFICIENT_REMAINDER: f64 = 0.04;
/// Largest share of the gap that effects may leave if they explain even the own gap of a lens.
const MAX_REMAINDER: f64 = 0.1;
/// Shares of the gap left by the best pair between which a third effect is searched.
const WANTS_THIRD: [f64; 2] = [0.05, 0.5];
/// Probability below which a verdict is ambiguous, and the probability that the named rivals reach together with it.
const MIN_PROBABILITY: f64 = 0.8;
const NAMED_PROBABILITY: f64 = 0.9;
/// Ratio of a gap to the own gap of a model that is too simple, from which on effects are added to it.
const CHANGED_RATIO: f64 = 1.5;
/// Largest number of rivals named.
const MAX_RIVALS: usize = 3;
/// Standard errors of the gap in the detection limit.
const LIMIT_SIGMAS: f64 = 5.0;
/// Gap left that is far above the detection limit, in such limits, and as a share of the gap: effects that leave so much do not explain it.
const FAR_LIMITS: f64 = 4.0;
const FAR_SHARE: f64 = 0.06;
/// Largest share of the gap that effects leave which close it, whatever the detection limit.
const CLOSED_SHARE: f64 = 0.2;
/// Least share of the gap that an effect must close to be added to an unexplained lens.
const MIN_PARTIAL_SHARE: f64 = 0.3;

/// The mean gap of tiles, less noise.
#[derive(Debug, Clone, Copy)]
struct MeasuredGap {
    gap: f64,
    /// Standard error from noise.
    sigma: f64,
}

impl MeasuredGap {
    /// Returns the mean over tiles, each with its gap, by `weight`.
    fn new<'a>(
        tiles: impl Iterator<Item = (f64, &'a &'a TileData)>,
        weight: impl Fn(&TileData) -> f64,
    ) -> Self {
        let (mut total, mut excess, mut variance) = (0.0, 0.0, 0.0);
        for (gap, tile) in tiles {
            let of_pixels = tile.noise - tile.noise_of_sum;
            // Noise squared, that of the sum apart, and the product of noise and residual.
            let squared = of_pixels * of_pixels / tile.noise_freedom()
                + tile.noise_of_sum * tile.noise_of_sum;
            let share = weight(tile);
            total += share;
            excess += share * (gap - tile.noise);
            variance += share * share * (2.0 * squared + product_with_noise(gap, tile));
        }
        Self {
            gap: excess / total,
            sigma: variance.sqrt() / total,
        }
    }
}

/// Returns the variance of a gap of `tile` by the product of noise and residual.
fn product_with_noise(gap: f64, tile: &TileData) -> f64 {
    4.0 * gap.max(0.0) * (tile.noise - tile.noise_of_sum) / tile.noise_freedom()
}

/// Returns the detection limit without noise for a lens of that own gap.
pub(super) fn own_limit(own_gap: f64) -> f64 {
    (REAL_GAP_RATIO * (own_gap + MODEL_ERROR)).min(MAX_OWN_GAP)
}

/// Statistics of the gap of the given lens.
#[derive(Debug, Clone, Copy)]
pub(super) struct GapStatistics {
    pub(super) before: f64,
    /// Standard error of `before` from noise.
    sigma: f64,
    /// Standard error of the part of `before` that effects close: the noise that both gaps have cancels.
    sigma_of_change: f64,
    /// The gap without weights.
    plain: MeasuredGap,
    /// Misfit of the lens on its own data.
    pub(super) misfit: f64,
    /// Gap left by the best single effect.
    best: f64,
}

/// The verdict with its probabilities.
pub(super) struct Decision {
    pub(super) verdict: Verdict,
    pub(super) nothing_missing: f64,
    /// The hypothesis added to the lens.
    pub(super) added: Option<Candidate>,
    /// Probability of every single effect, including its part of that of its combinations.
    pub(super) singles: Vec<f64>,
    /// Probability of every combination.
    pub(super) joint: Vec<f64>,
    pub(super) unknown: f64,
    /// Classes of effects that the data do not distinguish.
    pub(super) equivalents: Vec<Vec<&'static str>>,
}

impl GapStatistics {
    pub(super) fn new(own_gap: f64, search: &HypothesisSearch, singles: &[Candidate]) -> Self {
        let pairs = || search.gaps_before().iter().copied().zip(search.many());
        let of_change = pairs()
            .map(|(gap, tile)| weight(tile).powi(2) * product_with_noise(gap - tile.noise, tile));
        let weighted = MeasuredGap::new(pairs(), weight);
        Self {
            before: weighted.gap,
            sigma: weighted.sigma,
            sigma_of_change: of_change.sum::<f64>().sqrt() / search.weight(),
            plain: MeasuredGap::new(pairs(), |_| 1.0),
            misfit: own_gap,
            best: singles.first().map_or(f64::INFINITY, |s| s.after),
        }
    }

    /// Returns the gap up to which an effect may be missing without being seen: the own gap of the lens, up to the largest
    /// that a model may leave, and noise.
    pub(super) fn detection_limit(&self) -> f64 {
        self.own_limit() + LIMIT_SIGMAS * self.sigma
    }

    /// Returns the detection limit without noise.
    fn own_limit(&self) -> f64 {
        own_limit(self.misfit)
    }

    /// Returns the part of the gap that the best single effect closes on zones left out of its fit. Where noise leaves less than nothing,
    /// it closes the gap and no more.
    fn closed(&self) -> f64 {
        (self.before - self.best.max(0.0)).max(0.0)
    }

    /// Returns whether a gap is seen: it exceeds the detection limit, or what an effect closes of it does, or the gap without weights.
    /// What an effect closes has less noise, so one that is missing in a few places is seen where the whole gap is not. Weights
    /// are small where tiles are noisy, often in the corners, where much may be missing.
    fn is_seen(&self) -> bool {
        let exceeds = |gap: f64, sigma: f64| gap > self.own_limit() + LIMIT_SIGMAS * sigma;
        let may_be_own = self.plain.gap <= CHANGED_RATIO * self.misfit;
        exceeds(self.before, self.sigma)
            || exceeds(self.closed(), self.sigma_of_change)
            || (exceeds(self.plain.gap, self.plain.sigma) && !may_be_own)
    }

    /// Returns whether the own gap of the lens shows that its model is too simple.
    fn is_too_simple(&self) -> bool {
        self.misfit > self.detection_limit().max(MAX_OWN_GAP)
    }

    /// Returns the scale of gaps, for candidates of which the best leaves the gap `least`.
    ///
    /// A candidate normally has to leave the own gap of the lens. If the model is too simple and the best candidate closes a
    /// part of that own gap, only `least` counts as unavoidable.
    fn scale(&self, least: f64) -> GapScale {
        let misfit = if self.is_too_simple() {
            self.misfit.min(least.max(MIN_GAP))
        } else {
            self.misfit
        };
        GapScale {
            before: self.before,
            misfit,
            sigma: self.sigma,
        }
    }

    fn none(&self) -> f64 {
        let limit = self.own_limit();
        let of_gap = nothing_missing(self.before, self.sigma, limit, self.best);
        let of_closed = nothing_missing(self.closed(), self.sigma_of_change, limit, 0.0);
        let MeasuredGap { gap, sigma } = self.plain;
        let of_plain = nothing_missing(gap, sigma, limit, gap);
        of_gap.min(of_closed).min(of_plain)
    }

    /// Returns whether pairs of effects need to be searched.
    pub(super) fn wants_pairs(&self) -> bool {
        !self.is_too_simple() && self.none() < 0.5 && self.leaves_a_part(self.best)
    }

    /// Returns whether effects that leave the gap `after` leave more than the lens's own gap and a small part.
    pub(super) fn leaves_a_part(&self, after: f64) -> bool {
        after > SUFFICIENT_REMAINDER * self.before + self.misfit
    }

    /// Returns whether a third effect is searched beside a pair that leaves the gap `after`: it leaves a part, and not so much
    /// that a third effect would hardly explain it.
    pub(super) fn wants_third(&self, after: f64) -> bool {
        let share = (after - self.misfit).max(0.0) / self.before;
        (WANTS_THIRD[0]..WANTS_THIRD[1]).contains(&share)
    }

    /// Returns whether effects that leave the gap `after` close it: what is left is not seen.
    fn closes(&self, after: f64) -> bool {
        after <= self.detection_limit().min(CLOSED_SHARE * self.before)
    }

    /// Returns whether effects that leave the gap `after` leave far more than is not seen.
    fn leaves_much(&self, after: f64) -> bool {
        after > FAR_LIMITS * self.detection_limit() && after > FAR_SHARE * self.before + self.misfit
    }

    /// Returns the indices of the candidates that these data do not distinguish from `all[best]`, and that of the unknown cause, the last of
    /// `odds`. Where the best closes the gap, these are the ones that close it too, without its effects.
    fn rivals(&self, all: &[&Candidate], odds: &[f64], best: usize) -> Vec<usize> {
        let others = (0..odds.len()).filter(|k| *k != best);
        if !self.closes(all[best].after) {
            return others.collect();
        }
        let own = all[best].hypothesis.ids();
        let is_rival = |k: &usize| {
            all.get(*k).is_some_and(|candidate| {
                let ids = candidate.hypothesis.ids();
                self.closes(candidate.after) && !own.iter().all(|id| ids.contains(id))
            })
        };
        others.filter(is_rival).collect()
    }

    /// Decides between the `singles` and the `joint` candidates of two or three effects.
    pub(super) fn decide(&self, singles: &[Candidate], joint: &[Candidate]) -> Decision {
        let contenders: Vec<CandidateScore> = singles
            .iter()
            .chain(joint)
            .map(|c| CandidateScore {
                after: c.after,
                freedom: c.freedom(),
                effects: c.hypothesis.ids(),
            })
            .collect();
        let least = (contenders.iter().map(|c| c.after)).fold(f64::INFINITY, f64::min);
        let odds = probabilities(&contenders, self.scale(least));
        let (own, rest) = odds.split_at(singles.len());
        let (of_joint, unknown) = rest.split_at(joint.len());
        let unknown = unknown[0];
        let mut with_joint = own.to_vec();
        for (candidate, odds) in joint.iter().zip(of_joint) {
            let ids = candidate.hypothesis.ids();
            for id in &ids {
                let single = singles.iter().position(|s| s.hypothesis.ids() == [*id]);
                if let Some(k) = single {
                    with_joint[k] += odds / ids.len() as f64;
                }
            }
        }
        let none = self.none();
        let all: Vec<&Candidate> = singles.iter().chain(joint).collect();
        // The effect that acts on the lens, for one that does not.
        let acting = |k: usize| {
            let twin = all[k].acts_as.and_then(|id| {
                let mut singles = singles.iter();
                singles.find(|single| single.hypothesis.ids() == [id])
            });
            twin.unwrap_or(all[k]).clone()
        };
        let best = (0..all.len()).max_by(|a, b| odds[*a].total_cmp(&odds[*b]));
        let mut equivalents = Vec::new();
        let (verdict, added) = match best {
            _ if !self.is_seen() => (Verdict::NoGap, None),
            Some(k) if odds[k] > unknown && !self.leaves_much(all[k].after) => {
                let rivals = self.rivals(&all, &odds, k);
                let of_rivals: f64 = rivals.iter().map(|rival| odds[*rival]).sum();
                let settled = match self.closes(all[k].after) {
                    true => 1.0 - of_rivals,
                    false => odds[k],
                };
                if settled < MIN_PROBABILITY {
                    equivalents.push(named(&all, &odds, k, &rivals));
                    (Verdict::Ambiguous, Some(acting(k)))
                } else {
                    (Verdict::Explained, Some(acting(k)))
                }
            }
            _ => {
                let part = best.filter(|k| all[*k].after < (1.0 - MIN_PARTIAL_SHARE) * self.before);
                (Verdict::Unexplained, part.map(acting))
            }
        };
        let enough = self.detection_limit().min(MAX_REMAINDER * self.before);
        let closed = (added.as_ref()).is_some_and(|a| a.after <= enough);
        let verdict = if self.is_too_simple() && !closed {
            Verdict::ModelTooSimple
        } else {
            verdict
        };
        // Where the model is to blame, the lens is not changed by effects that imitate what it lacks.
        let changed = self.before > CHANGED_RATIO * self.misfit + self.detection_limit();
        let added = added.filter(|_| verdict != Verdict::ModelTooSimple || changed);
        Decision {
            verdict,
            nothing_missing: none,
            added,
            singles: with_joint,
            joint: of_joint.to_vec(),
            unknown,
            equivalents,
        }
    }
}

/// Returns the effects of `all[best]` and of its `rivals`, the likeliest first, and `unknown` where that is one of them.
fn named(all: &[&Candidate], odds: &[f64], best: usize, rivals: &[usize]) -> Vec<&'static str> {
    let mut order = rivals.to_vec();
    order.sort_by(|a, b| odds[*b].total_cmp(&odds[*a]));
    let mut class = all[best].hypothesis.ids();
    let mut reached = odds[best];
    for k in order.into_iter().take(MAX_RIVALS) {
        if reached >= NAMED_PROBABILITY {
            break;
        }
        reached += odds[k];
        let ids = all
            .get(k)
            .map_or_else(|| vec!["unknown"], |c| c.hypothesis.ids());
        for id in ids {
            if !class.contains(&id) {
                class.push(id);
            }
        }
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lens whose own gap is small, of which noise hides a gap of 0.0025.
    const NOISY: GapStatistics = GapStatistics {
        before: 0.0045,
        sigma: 0.0005,
        sigma_of_change: 0.00005,
        plain: MeasuredGap {
            gap: 0.0045,
            sigma: 0.0005,
        },
        misfit: 0.0003,
        best: 0.0045,
    };

    #[test]
    fn a_remainder_is_closed_below_the_limit_and_no_explanation_far_above_it() {
        let statistics = GapStatistics {
            before: 0.2,
            ..NOISY
        };
        let limit = statistics.detection_limit();
        assert!(statistics.closes(0.9 * limit) && !statistics.closes(1.1 * limit));
        assert!(!statistics.leaves_much(3.0 * limit) && statistics.leaves_much(8.0 * limit));
        let small = GapStatistics {
            before: limit,
            ..NOISY
        };
        assert!(!small.closes(0.9 * limit), "a gap that nothing closes");
    }

    #[test]
    fn a_gap_within_noise_is_seen_only_where_an_effect_closes_more_than_the_model_leaves() {
        assert!(!NOISY.is_seen());
        assert!(NOISY.none() > 0.5);
        let closed = |best: f64| GapStatistics { best, ..NOISY };
        assert!(closed(0.0002).is_seen());
        assert!(closed(0.0002).none() < 0.2);
        assert!(!closed(0.003).is_seen());
        let within_noise = GapStatistics {
            before: 0.0005,
            best: -0.2,
            ..NOISY
        };
        assert!(!within_noise.is_seen());
        assert!(within_noise.none() > 0.5);
        let larger = GapStatistics {
            before: 0.006,
            best: 0.006,
            ..NOISY
        };
        assert!(larger.is_seen());
    }
}

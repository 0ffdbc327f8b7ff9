//! Verdict of a diagnosis from the posterior probabilities.

use super::diagnosis::Verdict;
use super::gap_problem::weight;
use super::posterior::{CandidateScore, GapScale, nothing_missing, probabilities};
use super::search::{Candidate, HypothesisSearch};
use seidel_optics::profile::LensProfile;
use seidel_optics::psf::pupil::Detail;

/// Misfit of a lens without a held-out score.
const DEFAULT_MISFIT: f64 = 5e-4;
/// Share of the gap below which a single effect suffices.
const SUFFICIENT_REMAINDER: f64 = 0.02;
/// Probability below which a verdict may be ambiguous, and the least probability of a rival.
const MIN_SINGLE_PROBABILITY: f64 = 0.75;
const MIN_RIVAL_PROBABILITY: f64 = 0.2;
/// Least share of the gap that an effect must close to be added to an unexplained lens.
const MIN_PARTIAL_SHARE: f64 = 0.3;

/// Statistics of the gap of the given lens.
#[derive(Debug, Clone, Copy)]
pub(super) struct GapStatistics {
    pub(super) before: f64,
    /// Standard error of `before` from noise.
    sigma: f64,
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
    /// Probability of every single effect, including half of that of its pairs.
    pub(super) singles: Vec<f64>,
    /// Probability of every pair.
    pub(super) pairs: Vec<f64>,
    pub(super) unknown: f64,
    /// Classes of effects that the data do not distinguish.
    pub(super) equivalents: Vec<Vec<&'static str>>,
}

impl GapStatistics {
    pub(super) fn new(
        lens: &LensProfile,
        search: &HypothesisSearch,
        singles: &[Candidate],
    ) -> Self {
        let nothing = search.nothing();
        let gaps = search.problem(&nothing, Detail::FULL).gaps(&[]);
        let total = search.weight();
        let tiles = search.many().iter();
        let excess = gaps
            .iter()
            .zip(tiles)
            .map(|(g, t)| weight(t) * (g - t.noise));
        // Variance of a gap: noise squared, and the product of noise and residual.
        let variance = gaps.iter().zip(search.many()).map(|(g, t)| {
            let pixels = t.light.len() as f64;
            let meeting = 4.0 * g.max(0.0) * t.noise / pixels;
            weight(t).powi(2) * (2.0 * t.noise * t.noise / pixels + meeting)
        });
        Self {
            before: excess.sum::<f64>() / total,
            sigma: variance.sum::<f64>().sqrt() / total,
            misfit: lens
                .held_out
                .as_ref()
                .map_or(DEFAULT_MISFIT, |held| held.pixel_gap),
            best: singles.first().map_or(f64::INFINITY, |s| s.after),
        }
    }

    fn scale(&self) -> GapScale {
        GapScale {
            before: self.before,
            misfit: self.misfit,
            sigma: self.sigma,
        }
    }

    fn none(&self) -> f64 {
        nothing_missing(self.before, self.sigma, self.misfit, self.best)
    }

    /// Returns whether pairs of effects need to be searched.
    pub(super) fn wants_pairs(&self) -> bool {
        self.none() < 0.5 && self.best > SUFFICIENT_REMAINDER * self.before + self.misfit
    }

    pub(super) fn decide(&self, singles: &[Candidate], pairs: &[Candidate]) -> Decision {
        let contenders: Vec<CandidateScore> = singles
            .iter()
            .chain(pairs)
            .map(|c| CandidateScore {
                after: c.after,
                freedom: c.freedom(),
                effects: c.hypothesis.parts.len(),
            })
            .collect();
        let odds = probabilities(&contenders, self.scale());
        let (own, rest) = odds.split_at(singles.len());
        let (of_pairs, unknown) = rest.split_at(pairs.len());
        let unknown = unknown[0];
        let mut with_pairs = own.to_vec();
        for (pair, odds) in pairs.iter().zip(of_pairs) {
            for id in pair.hypothesis.ids() {
                let single = singles.iter().position(|s| s.hypothesis.ids() == [id]);
                if let Some(k) = single {
                    with_pairs[k] += odds / 2.0;
                }
            }
        }
        let none = self.none();
        let all: Vec<&Candidate> = singles.iter().chain(pairs).collect();
        let best = (0..all.len()).max_by(|a, b| odds[*a].total_cmp(&odds[*b]));
        let mut equivalents = Vec::new();
        let (verdict, added) = match best {
            _ if none > 0.5 => (Verdict::NoGap, None),
            Some(k) if odds[k] > unknown => {
                let rivals: Vec<usize> = (0..singles.len())
                    .filter(|j| *j != k && k < singles.len() && own[*j] > MIN_RIVAL_PROBABILITY)
                    .collect();
                if odds[k] < MIN_SINGLE_PROBABILITY && !rivals.is_empty() {
                    let mut class = all[k].hypothesis.ids();
                    class.extend(rivals.iter().flat_map(|j| singles[*j].hypothesis.ids()));
                    equivalents.push(class);
                    (Verdict::Ambiguous, Some(all[k].clone()))
                } else {
                    (Verdict::Explained, Some(all[k].clone()))
                }
            }
            _ => {
                let part = best.filter(|k| all[*k].after < (1.0 - MIN_PARTIAL_SHARE) * self.before);
                (Verdict::Unexplained, part.map(|k| all[k].clone()))
            }
        };
        Decision {
            verdict,
            nothing_missing: none,
            added,
            singles: with_pairs,
            pairs: of_pairs.to_vec(),
            unknown,
            equivalents,
        }
    }
}

//! Which answer the gaps of all hypotheses give.

use super::descent::weight;
use super::diagnosis::Verdict;
use super::odds::{Contender, Scale, nothing_missing, probabilities};
use super::search::{Candidate, Ground};
use seidel_optics::profile::LensProfile;
use seidel_optics::psf::pupil::Detail;

/// What the lens is taken to leave where it does not say.
const USUAL_MISFIT: f64 = 5e-4;
/// A single effect that closes all but this share needs no second.
const ENOUGH: f64 = 0.02;
/// Probability below which the answer names the runner-up as well, and the runner-up's own.
const SURE: f64 = 0.75;
const RIVAL: f64 = 0.2;
/// Least share of the gap that an effect closes to be added where the cause stays unknown.
const PART: f64 = 0.3;

/// The gap as it stands before anything is added.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stage {
    pub(super) before: f64,
    /// Standard error of `before` by noise alone.
    sigma: f64,
    /// What the lens leaves on its own data.
    pub(super) misfit: f64,
    /// Gap that the best single effect leaves.
    best: f64,
}

/// The answer.
pub(super) struct Decided {
    pub(super) verdict: Verdict,
    pub(super) nothing_missing: f64,
    /// What is added to the lens.
    pub(super) added: Option<Candidate>,
    /// Probability of every single, in the order of singles, its share of pairs included.
    pub(super) singles: Vec<f64>,
    /// Probability of every pair.
    pub(super) pairs: Vec<f64>,
    pub(super) unknown: f64,
    /// Effects that cannot be told apart.
    pub(super) equivalents: Vec<Vec<&'static str>>,
}

impl Stage {
    pub(super) fn new(lens: &LensProfile, ground: &Ground, singles: &[Candidate]) -> Self {
        let nothing = ground.nothing();
        let gaps = ground.problem(&nothing, Detail::FULL).gaps(&[]);
        let total = ground.weight();
        let tiles = ground.many().iter();
        let excess = gaps
            .iter()
            .zip(tiles)
            .map(|(g, t)| weight(t) * (g - t.noise));
        // Noise of a gap: that of its n pixels, and what it gets by meeting a residual.
        let variance = gaps.iter().zip(ground.many()).map(|(g, t)| {
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
                .map_or(USUAL_MISFIT, |held| held.pixel_gap),
            best: singles.first().map_or(f64::INFINITY, |s| s.after),
        }
    }

    fn scale(&self) -> Scale {
        Scale {
            before: self.before,
            misfit: self.misfit,
            sigma: self.sigma,
        }
    }

    fn none(&self) -> f64 {
        nothing_missing(self.before, self.sigma, self.misfit, self.best)
    }

    /// Whether a second effect could be needed.
    pub(super) fn wants_pairs(&self) -> bool {
        self.none() < 0.5 && self.best > ENOUGH * self.before + self.misfit
    }

    pub(super) fn decide(&self, singles: &[Candidate], pairs: &[Candidate]) -> Decided {
        let contenders: Vec<Contender> = singles
            .iter()
            .chain(pairs)
            .map(|c| Contender {
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
                    .filter(|j| *j != k && k < singles.len() && own[*j] > RIVAL)
                    .collect();
                if odds[k] < SURE && !rivals.is_empty() {
                    let mut class = all[k].hypothesis.ids();
                    class.extend(rivals.iter().flat_map(|j| singles[*j].hypothesis.ids()));
                    equivalents.push(class);
                    (Verdict::Ambiguous, Some(all[k].clone()))
                } else {
                    (Verdict::Explained, Some(all[k].clone()))
                }
            }
            _ => {
                let part = best.filter(|k| all[*k].after < (1.0 - PART) * self.before);
                (Verdict::Unexplained, part.map(|k| all[k].clone()))
            }
        };
        Decided {
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

//! Posterior probabilities of the hypotheses from their cross-validated gaps.
//!
//! With hundreds of tiles and little noise, model error dominates, and pixel likelihoods would be
//! overconfident. Model error of unknown variance with [`EFFECTIVE_SAMPLES`] independent samples is assumed
//! instead: a hypothesis that leaves the share r of the gap has a marginal likelihood of
//! r^(-EFFECTIVE_SAMPLES / 2). Its free parameters cost [`parameter_price`] (an Occam factor), and the
//! unknown cause is a hypothesis that leaves [`UNKNOWN_LEAVES`]. All constants were calibrated on simulated
//! cases with other seeds than those reported (docs/background/figures.md).

use seidel_optics::effects;

/// Effective number of independent samples of model error.
const EFFECTIVE_SAMPLES: f64 = 12.0;
/// Share of the gap that an unknown cause leaves, and its log prior penalty (nats).
const UNKNOWN_LEAVES: f64 = 0.14;
const UNKNOWN_PRICE: f64 = 1.5;
/// Further log prior penalty of an unknown cause if the best candidate leaves no significant remainder (nats), and the standard
/// errors up to which a remainder is not significant.
const UNNEEDED_UNKNOWN_PRICE: f64 = 2.0;
const SIGNIFICANT_SIGMAS: f64 = 3.0;
/// Log prior penalty of an effect that only imitates a simpler one (nats).
const IMITATION_PRICE: f64 = 3.0;
/// Ratio of the shares that two candidates leave, up to which the simpler one counts as equally good.
const EQUALLY_GOOD_RATIO: f64 = 1.25;
/// Log prior penalty of a second effect (nats).
const PAIR_PRICE: f64 = 1.5;
/// Relative uncertainty of the lens's own misfit.
const MISFIT_UNCERTAINTY: f64 = 0.3;
/// Share of its gap up to which the law of an effect describes a real fault.
const EFFECT_ERROR: f64 = 0.01;
/// Odds, against those of an unknown cause, that the effects are known but the search for them stopped short: this, times the
/// square of the share that the best candidate closes. Of unexplained gaps half closed, several were combinations of known effects.
const STOPPED_SHORT: f64 = 0.8;
/// Smallest gap that model and discretisation errors allow at the places of the fit, and at others: where nothing is missing, fits of
/// traced lenses leave up to 0.0014 in corners that their sets do not reach.
pub(super) const MIN_GAP: f64 = 2e-4;
pub(super) const MODEL_ERROR: f64 = 6e-4;

/// Returns the simpler effects that the effect `id` can imitate.
pub(super) fn contained_in(id: &str) -> impl Iterator<Item = &'static str> {
    let effect = effects::by_id(id).into_iter();
    effect.flat_map(|effect| {
        effect
            .description()
            .contains
            .iter()
            .map(|simpler| simpler.id())
    })
}

/// Score of a hypothesis.
#[derive(Debug, Clone)]
pub(super) struct CandidateScore {
    /// Remaining gap.
    pub(super) after: f64,
    /// Number of free parameters.
    pub(super) freedom: usize,
    /// Identifiers of the effects.
    pub(super) effects: Vec<&'static str>,
}

impl CandidateScore {
    /// Returns whether `simpler` has the same effects, but for one that an effect of this candidate contains.
    fn contains(&self, simpler: &Self) -> bool {
        let differ = |a: &Self, b: &Self| -> Vec<&'static str> {
            let own = a.effects.iter().filter(|id| !b.effects.contains(id));
            own.copied().collect()
        };
        match (&differ(self, simpler)[..], &differ(simpler, self)[..]) {
            (&[container], &[contained]) => contained_in(container).any(|id| id == contained),
            _ => false,
        }
    }
}

/// Gap of the given lens, with its expected part.
#[derive(Debug, Clone, Copy)]
pub(super) struct GapScale {
    /// The gap as measured.
    pub(super) before: f64,
    /// Misfit of the lens on its own data.
    pub(super) misfit: f64,
    /// Standard error of the gap from noise.
    pub(super) sigma: f64,
}

impl GapScale {
    /// Returns the share of the gap left by a hypothesis with remaining gap `after`.
    fn share(&self, after: f64) -> f64 {
        let of_effects = EFFECT_ERROR * (self.before - self.misfit).max(0.0);
        let floor = MIN_GAP + MISFIT_UNCERTAINTY * self.misfit + 2.0 * self.sigma + of_effects;
        let excess = |gap: f64| (gap - self.misfit).max(0.0) + floor;
        excess(after) / excess(self.before)
    }

    /// Returns whether the gap `after` exceeds the expected one by more than noise.
    fn is_significant(&self, after: f64) -> bool {
        after > self.misfit + MIN_GAP + SIGNIFICANT_SIGMAS * self.sigma
    }
}

/// Returns the penalty of `freedom` free parameters (nats).
fn parameter_price(freedom: usize) -> f64 {
    let k = freedom as f64;
    0.8 * k.ln_1p() + 0.05 * k
}

/// Returns the posterior probabilities of `contenders` and, last, of the unknown cause, given that an effect
/// is missing.
pub(super) fn probabilities(contenders: &[CandidateScore], scale: GapScale) -> Vec<f64> {
    let unknown = UNKNOWN_LEAVES * scale.before + (1.0 - UNKNOWN_LEAVES) * scale.misfit;
    let least = (contenders.iter().map(|c| c.after)).fold(f64::INFINITY, f64::min);
    let unknown_price = if scale.is_significant(least) {
        UNKNOWN_PRICE
    } else {
        UNKNOWN_PRICE + UNNEEDED_UNKNOWN_PRICE
    };
    let logs: Vec<f64> = contenders
        .iter()
        .map(|c| {
            let second = PAIR_PRICE * c.effects.len().saturating_sub(1) as f64;
            let share = scale.share(c.after);
            let imitates = (contenders.iter())
                .any(|s| c.contains(s) && scale.share(s.after) <= EQUALLY_GOOD_RATIO * share);
            let imitation = if imitates { IMITATION_PRICE } else { 0.0 };
            -EFFECTIVE_SAMPLES / 2.0 * share.ln() - parameter_price(c.freedom) - second - imitation
        })
        .chain([-EFFECTIVE_SAMPLES / 2.0 * scale.share(unknown).ln() - unknown_price])
        .collect();
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = logs.iter().map(|l| (l - most).exp()).collect();
    let unknown = weights[contenders.len()];
    let best = (0..contenders.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b]));
    if let Some(best) = best {
        let closed = (1.0 - scale.share(contenders[best].after)).max(0.0);
        weights[best] += STOPPED_SHORT * closed * closed * unknown;
    }
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Returns the probability that no effect is missing: that the gap `before` (standard error `sigma`) is within `own_limit`, the detection
/// limit without noise, where the best hypothesis leaves `best`.
pub(super) fn nothing_missing(before: f64, sigma: f64, own_limit: f64, best: f64) -> f64 {
    let limit = own_limit + REAL_GAP_RATIO * 2.0 * sigma;
    let before = before.max(1e-12);
    // An effect that closes a gap above the limit is evidence that it is missing, however small the gap.
    let closed = 1.0 - (best.max(0.0) / before).min(1.0);
    let seen = (1.0 - limit / before).max(0.0);
    let evidence = CLOSED_WEIGHT * seen * (closed - CLOSED_BY_CHANCE);
    let logit = ((before / limit).ln() + evidence) / LOGIT_WIDTH;
    1.0 / (1.0 + logit.exp())
}

/// Ratio of gap to expected gap at which a real gap has probability one half.
pub(super) const REAL_GAP_RATIO: f64 = 2.5;
/// Width of the logistic transition, in log ratio.
const LOGIT_WIDTH: f64 = 0.2;
/// Weight of the share closed by the best effect, and the share that it closes by chance.
const CLOSED_WEIGHT: f64 = 2.0;
const CLOSED_BY_CHANCE: f64 = 0.15;

#[cfg(test)]
mod tests {
    use super::*;

    const SCALE: GapScale = GapScale {
        before: 0.1,
        misfit: 0.001,
        sigma: 1e-5,
    };

    fn contender(after: f64, freedom: usize) -> CandidateScore {
        CandidateScore {
            after,
            freedom,
            effects: vec!["motion"],
        }
    }

    fn of(effects: &[&'static str], after: f64, freedom: usize) -> CandidateScore {
        CandidateScore {
            after,
            freedom,
            effects: effects.to_vec(),
        }
    }

    #[test]
    fn an_effect_that_imitates_a_simpler_one_is_less_likely() {
        let odds = |other: &'static str, after: f64| {
            let contenders = [of(&["pupil_scale"], 0.002, 1), of(&[other], after, 2)];
            probabilities(&contenders, SCALE)[0]
        };
        assert!(odds("vignetting", 0.002) > 0.9);
        assert!(odds("motion", 0.002) < 0.8);
        assert!(odds("vignetting", 0.0005) < 0.5, "unless it is better");
        let pair = [
            of(&["motion", "sensor_tilt"], 0.002, 7),
            of(&["decentre", "motion"], 0.002, 16),
        ];
        let got = probabilities(&pair, SCALE);
        assert!(got[0] > 20.0 * got[1], "{got:?}");
    }

    #[test]
    fn an_unknown_cause_is_less_likely_where_nothing_significant_is_left() {
        let noisy = GapScale {
            sigma: 0.002,
            ..SCALE
        };
        let unknown = |after: f64| probabilities(&[contender(after, 12)], noisy)[1];
        assert!(
            unknown(0.006) < 0.25 * unknown(0.008),
            "{} {}",
            unknown(0.006),
            unknown(0.008)
        );
    }

    #[test]
    fn what_closes_the_gap_wins_and_the_simpler_of_equals() {
        let odds = probabilities(
            &[
                contender(0.002, 2),
                contender(0.06, 1),
                contender(0.002, 10),
            ],
            SCALE,
        );
        assert!((odds.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(odds[0] > 0.8 && odds[2] < 0.2 && odds[1] < 0.01, "{odds:?}");
    }

    #[test]
    fn what_nothing_closes_is_unknown() {
        let odds = probabilities(&[contender(0.06, 2), contender(0.08, 1)], SCALE);
        assert!(odds[2] > 0.8, "{odds:?}");
    }

    #[test]
    fn a_gap_as_large_as_the_lens_leaves_is_none() {
        assert!(nothing_missing(4e-4, 1e-5, 2.5e-3, 3.9e-4) > 0.97);
        assert!(nothing_missing(0.05, 1e-5, 2.5e-3, 1e-3) < 1e-3);
    }
}

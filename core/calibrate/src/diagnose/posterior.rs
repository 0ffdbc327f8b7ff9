//! Posterior probabilities of the hypotheses from their cross-validated gaps.
//!
//! With hundreds of tiles and little noise, model error dominates, and pixel likelihoods would be
//! overconfident. Model error of unknown variance with [`EFFECTIVE_SAMPLES`] independent samples is assumed
//! instead: a hypothesis that leaves the share r of the gap has a marginal likelihood of
//! r^(-EFFECTIVE_SAMPLES / 2). Its free parameters cost [`parameter_price`] (an Occam factor), and the
//! unknown cause is a hypothesis that leaves [`UNKNOWN_LEAVES`]. All constants were calibrated on simulated
//! cases with other seeds than those reported (docs/background/diagnosis.md).

/// Effective number of independent samples of model error.
const EFFECTIVE_SAMPLES: f64 = 12.0;
/// Share of the gap that an unknown cause leaves, and its log prior penalty (nats).
const UNKNOWN_LEAVES: f64 = 0.14;
const UNKNOWN_PRICE: f64 = 1.5;
/// Log prior penalty of a second effect (nats).
const PAIR_PRICE: f64 = 2.0;
/// Relative uncertainty of the lens's own misfit.
const MISFIT_UNCERTAINTY: f64 = 0.3;
/// Smallest gap that model and discretisation errors allow.
pub(super) const MIN_GAP: f64 = 2e-4;

/// Score of a hypothesis.
#[derive(Debug, Clone, Copy)]
pub(super) struct CandidateScore {
    /// Remaining gap.
    pub(super) after: f64,
    /// Number of free parameters.
    pub(super) freedom: usize,
    /// Number of effects.
    pub(super) effects: usize,
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
        let floor = MIN_GAP + MISFIT_UNCERTAINTY * self.misfit + 2.0 * self.sigma;
        let excess = |gap: f64| (gap - self.misfit).max(0.0) + floor;
        excess(after) / excess(self.before)
    }
}

/// Returns the penalty of `freedom` free parameters (nats).
fn parameter_price(freedom: usize) -> f64 {
    let k = freedom as f64;
    0.8 * k.ln_1p() + 0.12 * k
}

/// Returns the posterior probabilities of `contenders` and, last, of the unknown cause, given that an effect
/// is missing.
pub(super) fn probabilities(contenders: &[CandidateScore], scale: GapScale) -> Vec<f64> {
    let unknown = UNKNOWN_LEAVES * scale.before + (1.0 - UNKNOWN_LEAVES) * scale.misfit;
    let logs: Vec<f64> = contenders
        .iter()
        .map(|c| {
            let second = PAIR_PRICE * c.effects.saturating_sub(1) as f64;
            -EFFECTIVE_SAMPLES / 2.0 * scale.share(c.after).ln()
                - parameter_price(c.freedom)
                - second
        })
        .chain([-EFFECTIVE_SAMPLES / 2.0 * scale.share(unknown).ln() - UNKNOWN_PRICE])
        .collect();
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = logs.iter().map(|l| (l - most).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Returns the probability that no effect is missing: that the gap `before` (standard error `sigma`) equals
/// the lens's own `misfit`, where the best hypothesis leaves `best`.
pub(super) fn nothing_missing(before: f64, sigma: f64, misfit: f64, best: f64) -> f64 {
    let expected = misfit + 2.0 * sigma + MIN_GAP;
    let excess = (before.max(1e-12) / expected).ln() - REAL_GAP_RATIO.ln();
    // An effect that closes a visible gap is evidence that it is missing, however small the gap.
    let closed = (1.0 - best.max(0.0) / before.max(1e-12)).clamp(0.0, 1.0);
    let seen = before.max(0.0) / (before.max(0.0) + 2.5 * MIN_GAP + 4.0 * sigma);
    let logit = (excess + CLOSED_WEIGHT * seen * (closed - CLOSED_BY_CHANCE)) / LOGIT_WIDTH;
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
            effects: 1,
        }
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
        assert!(
            odds[0] > 0.85 && odds[2] < 0.15 && odds[1] < 0.01,
            "{odds:?}"
        );
    }

    #[test]
    fn what_nothing_closes_is_unknown() {
        let odds = probabilities(&[contender(0.06, 2), contender(0.08, 1)], SCALE);
        assert!(odds[2] > 0.8, "{odds:?}");
    }

    #[test]
    fn a_gap_as_large_as_the_lens_leaves_is_none() {
        assert!(nothing_missing(4e-4, 1e-5, 4e-4, 3.9e-4) > 0.97);
        assert!(nothing_missing(0.05, 1e-5, 4e-4, 1e-3) < 1e-3);
    }
}

//! From gaps to probabilities.
//!
//! With hundreds of tiles and little noise every model is wrong by more than its noise, and likelihoods
//! of pixels would be certain of everything. What is not modelled is taken as error of unknown size in
//! [`WITNESSES`] independent parts, however many pixels there are: then a hypothesis that leaves the share
//! r of the gap has a likelihood of r^(-WITNESSES / 2), its free numbers cost [`price`], and the unknown
//! cause is a hypothesis that leaves [`UNKNOWN_LEAVES`]. All are set on simulated cases with other seeds
//! than those that are reported on (docs/background/diagnosis.md).

/// Independent parts of the error of models.
const WITNESSES: f64 = 12.0;
/// Share of the gap that an unknown cause is taken to leave, and the nats that it costs to call it that.
const UNKNOWN_LEAVES: f64 = 0.14;
const UNKNOWN_PRICE: f64 = 1.5;
/// Nats that the second effect of a pair costs besides its numbers.
const SECOND: f64 = 2.0;
/// Share of what the lens leaves on its own data by which that can differ here.
const MISFIT_DIFFERS: f64 = 0.3;
/// What models and drawing leave at best.
const LEAST_GAP: f64 = 2e-4;

/// A hypothesis as far as its odds go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contender {
    /// Gap left.
    pub(super) after: f64,
    /// Free numbers.
    pub(super) freedom: usize,
    /// Effects.
    pub(super) effects: usize,
}

/// The gap of the lens as given, and what is no part of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// The gap as measured.
    pub(super) before: f64,
    /// What the lens leaves on the data that it was fitted to.
    pub(super) misfit: f64,
    /// Standard error of the gap by noise.
    pub(super) sigma: f64,
}

impl Scale {
    /// Share of the gap that a hypothesis leaves which ends at `after`.
    fn share(&self, after: f64) -> f64 {
        let floor = LEAST_GAP + MISFIT_DIFFERS * self.misfit + 2.0 * self.sigma;
        let excess = |gap: f64| (gap - self.misfit).max(0.0) + floor;
        excess(after) / excess(self.before)
    }
}

/// Nats that `freedom` free numbers cost: the first ones most.
fn price(freedom: usize) -> f64 {
    let k = freedom as f64;
    0.8 * k.ln_1p() + 0.12 * k
}

/// Probabilities of `contenders` and, last, of the unknown, given that something is missing.
pub(super) fn probabilities(contenders: &[Contender], scale: Scale) -> Vec<f64> {
    let unknown = UNKNOWN_LEAVES * scale.before + (1.0 - UNKNOWN_LEAVES) * scale.misfit;
    let logs: Vec<f64> = contenders
        .iter()
        .map(|c| {
            let second = SECOND * c.effects.saturating_sub(1) as f64;
            -WITNESSES / 2.0 * scale.share(c.after).ln() - price(c.freedom) - second
        })
        .chain([-WITNESSES / 2.0 * scale.share(unknown).ln() - UNKNOWN_PRICE])
        .collect();
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = logs.iter().map(|l| (l - most).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Probability that nothing is missing: that a gap of `before`, known to `sigma`, is what the lens leaves
/// anyway, `misfit`, when the best hypothesis leaves `best`.
pub(super) fn nothing_missing(before: f64, sigma: f64, misfit: f64, best: f64) -> f64 {
    let expected = misfit + 2.0 * sigma + LEAST_GAP;
    let excess = (before.max(1e-12) / expected).ln() - TIMES_EXPECTED.ln();
    // What an effect closes of a gap that can be seen at all speaks against nothing, however small the gap.
    let closed = (1.0 - best.max(0.0) / before.max(1e-12)).clamp(0.0, 1.0);
    let seen = before.max(0.0) / (before.max(0.0) + 2.5 * LEAST_GAP + 4.0 * sigma);
    let logit = (excess + CLOSING * seen * (closed - BY_CHANCE)) / WIDTH;
    1.0 / (1.0 + logit.exp())
}

/// How much larger than expected a gap must be to be as likely real as not.
const TIMES_EXPECTED: f64 = 2.5;
/// How wide the doubt is, in logarithms.
const WIDTH: f64 = 0.2;
/// Weight of the share that the best effect closes, and the share that one of them closes of what a lens
/// leaves anyway.
const CLOSING: f64 = 2.0;
const BY_CHANCE: f64 = 0.15;

#[cfg(test)]
mod tests {
    use super::*;

    const SCALE: Scale = Scale {
        before: 0.1,
        misfit: 0.001,
        sigma: 1e-5,
    };

    fn contender(after: f64, freedom: usize) -> Contender {
        Contender {
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

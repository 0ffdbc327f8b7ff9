//! Search for effects that join others: partners ranked by a linear prediction, and joint starting points.

use super::gap_problem::{GapProblem, LocalMinimum};
use super::hypothesis::{Hypothesis, Slot};
use super::search::{Candidate, Draft, HypothesisSearch, REFINED_STARTS, Strides, TOLERANCE};
use seidel_optics::effects::SearchStart;
use seidel_optics::psf::pupil::Detail;

/// Partners per effect that are searched in full.
pub(super) const PARTNERS: usize = 2;
/// Starting points of its own for an effect that joins others: while partners are compared, and for the partner chosen.
const PARTNER_STARTS: usize = 3;
const JOINT_STARTS: usize = 6;
/// Influence of a parameter on the pictures by its own step, relative to the cost, below which it does not act. Damping of the
/// step to the linear prediction.
const LEAST_INFLUENCE: f64 = 1e-6;
const PARTNER_DAMPING: f64 = 1e-3;

/// An effect that may join others.
pub(super) struct Partner<'c> {
    pub(super) alone: &'c Candidate,
    /// The joint hypothesis where a linear step leads, if the effect acts linearly at its neutral values.
    predicted: Option<(Hypothesis, LocalMinimum)>,
    /// Cost with the effect, on the fewest tiles.
    cost: f64,
}

impl HypothesisSearch<'_> {
    /// Estimates the parameters of the effects of `one` and of the single effect of `partner` jointly, starting from their
    /// separate estimates, in a few iterations.
    pub(super) fn joint_draft(&self, one: &Candidate, partner: Partner) -> Draft {
        let Partner {
            alone: other,
            predicted,
            ..
        } = partner;
        let count = if predicted.is_some() {
            PARTNER_STARTS
        } else {
            JOINT_STARTS
        };
        let starts = self.joined(one, other, count);
        let mut screened = self.screened(starts, &Strides::of_second(one));
        if let Some((joint, there)) = predicted {
            let problem = GapProblem::new(&joint, &self.screening.tiles, Detail::DRAFT);
            let cost = problem.gap_sum(&there.theta);
            let at = screened.partition_point(|s| s.1.cost < cost);
            if at < screened.len() {
                let theta = there.theta;
                screened.insert(at, (joint, LocalMinimum { theta, cost }));
                screened.truncate(REFINED_STARTS);
            }
        }
        self.best(screened)
    }

    /// Returns the joint hypothesis of `a` and `b` with their values.
    fn both(&self, a: (&Hypothesis, &[f64]), b: (&Hypothesis, &[f64])) -> (Hypothesis, Vec<f64>) {
        let parts = [a.0.parts.clone(), b.0.parts.clone()].concat();
        let joint = Hypothesis::new(parts, &self.channels);
        let of_slot = |slot: &Slot| {
            let id = joint.parts[slot.part].0.id();
            let (from, values) = if b.0.parts[0].0.id() == id { b } else { a };
            let same = from.slots.iter().position(|s| {
                from.parts[s.part].0.id() == id
                    && s.parameter == slot.parameter
                    && s.channel == slot.channel
            });
            same.map_or(joint.parts[slot.part].1.values[slot.parameter], |k| {
                values[k]
            })
        };
        let theta = joint.slots.iter().map(of_slot).collect();
        (joint, theta)
    }

    /// Returns joint starting points: all effects at their separate estimates, and the last at `count` of its own
    /// starting points.
    fn joined(
        &self,
        one: &Candidate,
        other: &Candidate,
        count: usize,
    ) -> Vec<(Hypothesis, Vec<f64>)> {
        let (last, _) = &other.hypothesis.parts[0];
        let alone = |start: SearchStart| {
            let fresh = Hypothesis::new(vec![(*last, start)], &self.channels);
            let theta = fresh.start();
            (fresh, theta)
        };
        let (a, b) = (
            (&one.hypothesis, &one.theta[..]),
            (&other.hypothesis, &other.theta[..]),
        );
        let mut starts = vec![self.both(a, b)];
        for start in self.starts(*last).into_iter().take(count) {
            let (fresh, theta) = alone(start);
            starts.push(self.both(a, (&fresh, &theta)));
        }
        starts
    }

    /// Returns `others` as partners of `one`, those first that lower the cost most on the fewest tiles: by the linear prediction
    /// where the effect acts linearly at its neutral values, and by a step from the best of a few starting points otherwise.
    pub(super) fn ranked_partners<'c>(
        &self,
        one: &Candidate,
        others: &[&'c Candidate],
    ) -> Vec<Partner<'c>> {
        let partner = |alone: &&'c Candidate| {
            let predicted = self.predicted_joint(one, alone);
            let cost = predicted.as_ref().map(|(_, there)| there.cost);
            let cost = cost.unwrap_or_else(|| {
                let starts = self.joined(one, alone, PARTNER_STARTS);
                let screened = self.screened(starts, &Strides::of_second(one));
                let (hypothesis, start) = &screened[0];
                let problem = GapProblem::new(hypothesis, &self.screening.tiles, Detail::DRAFT);
                problem.descend(&start.theta, 1, TOLERANCE).cost
            });
            Partner {
                alone,
                predicted,
                cost,
            }
        };
        let mut ranked: Vec<Partner> = others.iter().map(partner).collect();
        ranked.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        ranked
    }

    /// Returns where a linear step leads from `one` with the effect of `other` at its neutral values, and the cost there by the
    /// linear prediction; `None` if that effect has no derivative there, or if positions are too far off for one.
    fn predicted_joint(
        &self,
        one: &Candidate,
        other: &Candidate,
    ) -> Option<(Hypothesis, LocalMinimum)> {
        if self.displaced {
            return None;
        }
        let neutral = other.hypothesis.neutral();
        let (joint, theta) =
            self.both((&one.hypothesis, &one.theta), (&other.hypothesis, &neutral));
        let id = other.hypothesis.parts[0].0.id();
        let own = joint.slots.iter().enumerate();
        let own = own.filter(|(_, slot)| joint.parts[slot.part].0.id() == id);
        let own: Vec<usize> = own.map(|(k, _)| k).collect();
        let problem = GapProblem::new(&joint, &self.screening.tiles, Detail::DRAFT);
        let sums = problem.linear(&theta).total(None);
        let acts = |k: &usize| {
            let step = joint.slots[*k].step;
            sums.matrix[(*k, *k)] * step * step > LEAST_INFLUENCE * sums.cost
        };
        if !own.iter().any(acts) {
            return None;
        }
        let predicted = sums.step(&theta, &joint.slots, PARTNER_DAMPING);
        Some((joint, predicted))
    }
}

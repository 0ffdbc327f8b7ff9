//! The three observation sets of a planned case, and its answer.

use std::collections::BTreeMap;

use super::case::{Answer, Case};
use super::change::Cause;
use super::expose::{Capture, SetRequest, Spot};
use super::plan::{Plan, label, plan};
use super::recipe::{Kind, Recipe};
use super::rng::Rng;
use super::simulated::SimulatedLens;

/// Share of cases whose real and held-out sets have a constant background, and its value.
const BACKGROUND_SHARE: f64 = 0.25;
const BACKGROUND: f64 = 0.015;
/// Signal-to-noise ratio of held-out sets.
const HOLDOUT_SNR: f64 = 2500.0;

/// Draws the case of `recipe` with lenses of one simulator.
pub(super) fn draw<L: SimulatedLens>(recipe: &Recipe) -> Case {
    let plan: Plan<L> = plan(recipe);
    let mut rng = Rng::stream(recipe.seed, L::FIRST_LABEL + label::REAL, 0);
    let conditions = &recipe.conditions;
    let background = if rng.chance(BACKGROUND_SHARE) {
        BACKGROUND
    } else {
        0.0
    };
    let nominal: Vec<&Cause<L::Action>> = plan.nominal.iter().collect();
    let causes: Vec<&Cause<L::Action>> = plan.nominal.iter().chain(&plan.causes).collect();
    let take = |causes: &[&Cause<L::Action>], spots: &[Spot], capture: Capture| {
        let request = SetRequest {
            spots,
            tile: conditions.size.tile,
            seed: recipe.seed,
            capture,
        };
        plan.lens.set(causes, &request)
    };
    let real = Capture {
        label: L::FIRST_LABEL + label::REAL + 1,
        raw: conditions.raw,
        snr: Some(conditions.snr),
        sigma_stated: conditions.noise_stated,
        background,
        ideal_positions: conditions.ideal_positions,
    };
    let holdout = Capture {
        label: L::FIRST_LABEL + label::HOLDOUT,
        snr: Some(HOLDOUT_SNR),
        ..real
    };
    let design = Capture {
        label: 0,
        raw: false,
        snr: None,
        sigma_stated: false,
        background: 0.0,
        ideal_positions: true,
    };
    Case {
        design: take(&nominal, &plan.spots[0], design),
        real: take(&causes, &plan.spots[1], real),
        holdout: take(&causes, &plan.spots[2], holdout),
        answer: answer(recipe, &plan),
    }
}

/// Returns the answer of a case. Parameters of the design's own effects are keyed `design.effect.parameter`, those of the
/// bare lens `lens.parameter`.
fn answer<L: SimulatedLens>(recipe: &Recipe, plan: &Plan<L>) -> Answer {
    let mut parameters = BTreeMap::new();
    let nominal = plan.nominal.iter().map(|cause| ("design.", cause));
    let causes = plan.causes.iter().map(|cause| ("", cause));
    for ((set, cause), alone) in nominal.chain(causes).zip(&plan.alone) {
        let id = format!("{set}{}", cause.change.id);
        parameters.insert(format!("{id}.strength"), cause.strength);
        parameters.insert(format!("{id}.gap_alone"), *alone);
        for (name, value) in &cause.change.fixed {
            parameters.insert(format!("{id}.{name}"), *value);
        }
        for (name, value) in &cause.change.scaled {
            parameters.insert(format!("{id}.{name}"), value * cause.strength);
        }
    }
    for (name, value) in plan.lens.parameters() {
        parameters.insert(format!("lens.{name}"), value);
    }
    parameters.insert("real.snr".to_owned(), recipe.conditions.snr);
    parameters.insert("real.detection_limit".to_owned(), plan.limit);
    let (effects, unknown) = match recipe.kind {
        Kind::Unknown(id) => (Vec::new(), Some(id.to_owned())),
        _ => (recipe.kind.causes(), None),
    };
    Answer {
        kind: recipe.kind.class().id().to_owned(),
        effects: effects.into_iter().map(str::to_owned).collect(),
        unknown,
        parameters,
        gap: plan.gap,
    }
}

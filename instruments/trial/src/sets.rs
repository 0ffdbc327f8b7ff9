//! The three observation sets of a planned case, and its answer.

use std::collections::BTreeMap;

use seidel_optics::observations::ObservationSet;

use super::case::{Answer, Case, FurtherSets};
use super::change::Cause;
use super::expose::{Capture, SetRequest, Spot, spots};
use super::further_capture::FurtherCapture;
use super::plan::{Plan, label, plan};
use super::recipe::{Kind, Recipe};
use super::rng::Rng;
use super::simulated::SimulatedLens;

/// Share of cases whose real and held-out sets have a constant background, and its value.
const BACKGROUND_SHARE: f64 = 0.25;
const BACKGROUND: f64 = 0.015;
/// Signal-to-noise ratio of held-out sets.
const HOLDOUT_SNR: f64 = 2500.0;
/// Further places, in numbers of those of the real set, and side of tiles with a wide surround, pixels.
const MORE_PLACES: usize = 2;
const WIDE_TILE: usize = 65;

/// Draws the case of `recipe` with lenses of one simulator.
pub(super) fn draw<L: SimulatedLens>(recipe: &Recipe) -> Case {
    let plan: Plan<L> = plan(recipe);
    let captures = Captures::of::<L>(recipe);
    let tile = recipe.conditions.size.tile;
    Case {
        design: take(
            &plan,
            recipe,
            &plan.nominal,
            &plan.spots[0],
            tile,
            captures.design,
        ),
        real: take_real(&plan, recipe, &plan.spots[1], tile, captures.real),
        holdout: take_real(&plan, recipe, &plan.spots[2], tile, captures.holdout),
        answer: answer(recipe, &plan),
    }
}

/// Draws the design and the real set of `recipe` after the further `capture`; `None` if it shows nothing new.
pub(super) fn draw_further<L: SimulatedLens>(
    recipe: &Recipe,
    capture: FurtherCapture,
) -> Option<FurtherSets> {
    let plan: Plan<L> = plan(recipe);
    let mut captures = Captures::of::<L>(recipe);
    let mut tile = recipe.conditions.size.tile;
    let size = &recipe.conditions.size;
    let mut rng = Rng::stream(recipe.seed, L::FIRST_LABEL + label::FURTHER, 0);
    let [mut design, mut real, _] = plan.spots.clone();
    match capture {
        FurtherCapture::MorePlaces => {
            real.extend(spots(
                plan.lens.camera(),
                MORE_PLACES * size.real,
                0.5,
                &mut rng,
            ));
        }
        FurtherCapture::OtherSideOfFocus => {
            let camera = plan.lens.camera().beyond_focus()?;
            design.extend(spots(&camera, size.design, 0.0, &mut rng));
            real.extend(spots(&camera, size.real, 0.5, &mut rng));
        }
        FurtherCapture::DarkSurround => {
            if tile >= WIDE_TILE {
                return None;
            }
            tile = WIDE_TILE;
            captures.real.snr = Some(HOLDOUT_SNR);
        }
    }
    Some(FurtherSets {
        design: take(
            &plan,
            recipe,
            &plan.nominal,
            &design,
            size.tile,
            captures.design,
        ),
        real: take_real(&plan, recipe, &real, tile, captures.real),
    })
}

/// The captures of the three sets of a case.
struct Captures {
    design: Capture,
    real: Capture,
    holdout: Capture,
}

impl Captures {
    fn of<L: SimulatedLens>(recipe: &Recipe) -> Self {
        let mut rng = Rng::stream(recipe.seed, L::FIRST_LABEL + label::REAL, 0);
        let conditions = &recipe.conditions;
        let background = if rng.chance(BACKGROUND_SHARE) {
            BACKGROUND
        } else {
            0.0
        };
        let real = Capture {
            label: L::FIRST_LABEL + label::REAL + 1,
            raw: conditions.raw,
            snr: Some(conditions.snr),
            sigma_stated: conditions.noise_stated,
            background,
            ideal_positions: conditions.ideal_positions,
        };
        Self {
            design: Capture {
                label: 0,
                raw: false,
                snr: None,
                sigma_stated: false,
                background: 0.0,
                ideal_positions: true,
            },
            real,
            holdout: Capture {
                label: L::FIRST_LABEL + label::HOLDOUT,
                snr: Some(HOLDOUT_SNR),
                // Without them shifts between channels would not be seen.
                ideal_positions: true,
                ..real
            },
        }
    }
}

/// Captures the real lens of `plan` at `spots`.
fn take_real<L: SimulatedLens>(
    plan: &Plan<L>,
    recipe: &Recipe,
    spots: &[Spot],
    tile: usize,
    capture: Capture,
) -> ObservationSet {
    let causes = plan.nominal.iter().chain(&plan.causes);
    take(plan, recipe, causes, spots, tile, capture)
}

/// Captures the lens of `plan` with `causes` at `spots`.
fn take<'a, L: SimulatedLens>(
    plan: &Plan<L>,
    recipe: &Recipe,
    causes: impl IntoIterator<Item = &'a Cause<L::Action>>,
    spots: &[Spot],
    tile: usize,
    capture: Capture,
) -> ObservationSet
where
    L::Action: 'a,
{
    let causes: Vec<&Cause<L::Action>> = causes.into_iter().collect();
    let request = SetRequest {
        spots,
        tile,
        seed: recipe.seed,
        capture,
    };
    plan.lens.set(&causes, &request)
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

//! Random cases of traced lenses: a lens, causes of suitable strength, and the three observation sets.

use std::collections::BTreeMap;

use super::change::{GlassCause, GlassChange};
use super::errors::error;
use super::lens::GlassLens;
use super::prescription::ALL;
use super::tiles::{gap, set};
use super::unknown::unknown;
use crate::case::{Answer, Case};
use crate::expose::{Capture, Spot, spots};
use crate::lens::LensConstraints;
use crate::recipe::{Kind, Recipe};
use crate::rng::Rng;

/// Smallest and largest gap of a case.
pub(super) const GAPS: [f64; 2] = [0.005, 0.4];
/// Range of the wanted gap of a single cause.
const WANTED: [f64; 2] = [0.006, 0.3];
/// Range of the wanted gap of the first of two causes.
const WANTED_FIRST: [f64; 2] = [0.012, 0.15];
/// Smallest ratio of the smaller to the larger gap of two causes.
const LEAST_RATIO: f64 = 1.0 / 3.0;
/// Number of lenses tried before the best is used.
const ATTEMPTS: u64 = 100;
/// Number of positions, each at two distances, that determine strengths.
const PROBES: usize = 5;
/// Strengths tried after the largest.
const TRIALS: usize = 6;
/// Largest logarithm of the ratio of the gap found to the one wanted.
const CLOSE: f64 = 0.12;

/// Labels of independent random sequences, apart from those of the first simulator.
mod label {
    pub(super) const PLAN: u64 = 1100;
    pub(super) const PLACES: u64 = 1200;
    pub(super) const REAL: u64 = 1300;
    pub(super) const HOLDOUT: u64 = 1400;
}

/// A case before its tiles are computed.
pub(super) struct Plan {
    pub(super) lens: GlassLens,
    pub(super) causes: Vec<GlassCause>,
    /// Gap of each cause alone at the probe positions.
    alone: Vec<f64>,
    /// Spots of the design, the real and the held-out set.
    pub(super) spots: [Vec<Spot>; 3],
    gap: f64,
}

/// Draws the case of `recipe` with a traced lens. The result does not depend on the number of threads.
///
/// # Panics
/// If an identifier of the recipe is neither in [`super::EFFECTS`] nor in [`super::UNKNOWN`], a pair has twice the same
/// effect, a set has no positions, or tiles are even or smaller than 25 pixels.
pub fn draw(recipe: &Recipe) -> Case {
    let size = &recipe.size;
    assert!(
        size.tile >= 25 && size.tile % 2 == 1,
        "tiles are odd and at least 25 pixels wide"
    );
    assert!(
        size.design.min(size.real).min(size.holdout) > 0,
        "every set has positions"
    );
    if let Kind::Pair(a, b) = recipe.kind {
        assert_ne!(a, b, "a pair has two different effects");
    }
    expose(recipe, &plan(recipe))
}

/// Returns the first plan whose gaps are in the allowed ranges, or the nearest to them.
pub(super) fn plan(recipe: &Recipe) -> Plan {
    let mut best: Option<(f64, Plan)> = None;
    for attempt in 0..ATTEMPTS {
        let (miss, plan) = attempt_at(recipe, attempt);
        if best.as_ref().is_none_or(|(least, _)| miss < *least) {
            best = Some((miss, plan));
        }
        if miss == 0.0 {
            break;
        }
    }
    best.expect("at least one lens was tried").1
}

/// Draws a lens and the changes of `recipe`.
pub(super) fn lens_and_changes(recipe: &Recipe, rng: &mut Rng) -> (GlassLens, Vec<GlassChange>) {
    let depths_matter = match recipe.kind {
        Kind::Single(id) => is_focus(id),
        Kind::Pair(a, b) => is_focus(a) || is_focus(b),
        Kind::None | Kind::Unknown(_) => false,
    };
    let constraints = LensConstraints {
        slow: false,
        depth_ratio: if depths_matter { 1.3 } else { 1.1 },
    };
    let lens = GlassLens::draw(rng, constraints, recipe.size.tile);
    let changes = match recipe.kind {
        Kind::None => Vec::new(),
        Kind::Single(id) => vec![error(id, &lens, rng)],
        Kind::Unknown(id) => vec![unknown(id, &lens, rng)],
        Kind::Pair(a, b) => vec![error(a, &lens, rng), error(b, &lens, rng)],
    };
    (lens, changes)
}

/// Returns whether an effect is identified by its change with distance.
fn is_focus(id: &str) -> bool {
    id == "defocus_offset" || id == "depth_scale"
}

/// Returns a plan and how far its gaps lie outside the allowed ranges, in logarithms.
pub(super) fn attempt_at(recipe: &Recipe, attempt: u64) -> (f64, Plan) {
    let size = &recipe.size;
    let mut rng = Rng::stream(recipe.seed, label::PLAN, attempt);
    let (lens, changes) = lens_and_changes(recipe, &mut rng);
    let mut places = Rng::stream(recipe.seed, label::PLACES, attempt);
    let spots_of = [(size.design, 0.0), (size.real, 0.5), (size.holdout, 0.5)]
        .map(|(count, wander)| spots(&lens.camera, count, wander, &mut places));
    let probes = spots(&lens.camera, PROBES, 0.5, &mut places);
    let mut plan = Plan {
        lens,
        causes: Vec::new(),
        alone: Vec::new(),
        spots: spots_of,
        gap: 0.0,
    };
    let two = changes.len() == 2;
    let mut miss = 0.0;
    for change in changes {
        let wanted = match plan.alone.first() {
            Some(first) => first * rng.between(0.6, 1.6),
            None if two => rng.between_log(WANTED_FIRST[0], WANTED_FIRST[1]),
            None => rng.between_log(WANTED[0], WANTED[1]),
        };
        let (cause, alone) = strengthen(&plan.lens, change, &probes, size.tile, wanted);
        miss += outside(alone, GAPS[0], GAPS[1]);
        plan.causes.push(cause);
        plan.alone.push(alone);
        if miss > 0.0 && attempt + 1 < ATTEMPTS && attempt > 0 {
            // Tries another lens; only the first plan is always completed, as a fallback.
            return (miss + 10.0, plan);
        }
    }
    if let [a, b] = plan.alone[..] {
        miss += outside(a.min(b) / a.max(b), LEAST_RATIO, 1.0);
    }
    if !plan.causes.is_empty() {
        let causes: Vec<&GlassCause> = plan.causes.iter().collect();
        plan.gap = gap(&plan.lens, &causes, &plan.spots[1], size.tile);
        miss += outside(plan.gap, GAPS[0], GAPS[1]);
    }
    (miss, plan)
}

/// Returns how far `value` lies outside `low` to `high`, in logarithms.
fn outside(value: f64, low: f64, high: f64) -> f64 {
    let floor = value.max(1e-9);
    libm::log(low / floor).max(libm::log(floor / high)).max(0.0)
}

/// A strength and its gap.
#[derive(Debug, Clone, Copy)]
struct Trial {
    strength: f64,
    gap: f64,
}

/// Returns the change at the strength within its range whose gap is close to `wanted`, and that gap.
///
/// Logarithms of the gap are interpolated over those of the strength; small gaps grow with its square.
fn strengthen(
    lens: &GlassLens,
    change: GlassChange,
    probes: &[Spot],
    tile: usize,
    wanted: f64,
) -> (GlassCause, f64) {
    let [least, most] = change.range;
    let mut cause = GlassCause {
        change,
        strength: most,
    };
    let mut try_at = |strength: f64| {
        cause.strength = strength;
        let gap = gap(lens, &[&cause], probes, tile);
        Trial { strength, gap }
    };
    let mut above = try_at(most);
    let mut below = None;
    let mut last = above;
    for _ in 0..TRIALS {
        let near = libm::log(last.gap / wanted).abs() < CLOSE;
        let spent = (above.gap <= wanted && below.is_none()) || last.strength <= least;
        if near || spent {
            break;
        }
        let guess = match below {
            _ if !above.gap.is_finite() => (least * above.strength).sqrt(),
            None => above.strength * (wanted / above.gap).sqrt(),
            Some(Trial { strength, gap }) => {
                let part = libm::log(wanted / gap) / libm::log(above.gap / gap);
                strength * libm::pow(above.strength / strength, part)
            }
        };
        last = try_at(guess.max(least));
        if last.gap > wanted {
            above = last;
        } else {
            below = Some(last);
        }
    }
    (cause, last.gap)
}

fn expose(recipe: &Recipe, plan: &Plan) -> Case {
    let mut rng = Rng::stream(recipe.seed, label::REAL, 0);
    let holds = |id: &str| plan.causes.iter().any(|c| c.change.id == id);
    let raw = rng.chance(0.5) || holds("tone_curve");
    // Negative values are valid only with a stated noise.
    let sigma_stated = rng.chance(0.75) || holds("sharpening");
    let snr = if sigma_stated {
        rng.between_log(100.0, 300.0)
    } else {
        rng.between_log(600.0, 900.0)
    };
    let background = if rng.chance(0.25) { 0.015 } else { 0.0 };
    let causes: Vec<&GlassCause> = plan.causes.iter().collect();
    let take = |causes: &[&GlassCause], spots: &[Spot], capture: &Capture| {
        let tile = recipe.size.tile;
        set(&plan.lens, causes, spots, tile, recipe.seed, capture)
    };
    let real = Capture {
        label: label::REAL + 1,
        raw,
        snr: Some(snr),
        sigma_stated,
        background,
    };
    let holdout = Capture {
        label: label::HOLDOUT,
        snr: Some(2500.0),
        ..real
    };
    let design = Capture {
        label: 0,
        raw: false,
        snr: None,
        sigma_stated: false,
        background: 0.0,
    };
    Case {
        design: take(&[], &plan.spots[0], &design),
        real: take(&causes, &plan.spots[1], &real),
        holdout: take(&causes, &plan.spots[2], &holdout),
        answer: answer(recipe, plan, &real),
    }
}

fn answer(recipe: &Recipe, plan: &Plan, real: &Capture) -> Answer {
    let mut parameters = BTreeMap::new();
    for (cause, alone) in plan.causes.iter().zip(&plan.alone) {
        let id = cause.change.id;
        parameters.insert(format!("{id}.strength"), cause.strength);
        parameters.insert(format!("{id}.gap_alone"), *alone);
        for (name, value) in &cause.change.fixed {
            parameters.insert(format!("{id}.{name}"), *value);
        }
        for (name, value) in &cause.change.scaled {
            parameters.insert(format!("{id}.{name}"), value * cause.strength);
        }
    }
    parameters.insert("real.snr".to_owned(), real.snr.unwrap_or(f64::INFINITY));
    let prescription = ALL
        .iter()
        .position(|p| std::ptr::eq(*p, plan.lens.prescription))
        .expect("the prescription is on the list");
    parameters.insert("lens.prescription".to_owned(), prescription as f64);
    let (kind, effects, unknown) = match recipe.kind {
        Kind::None => ("none", vec![], None),
        Kind::Single(id) => ("single", vec![id], None),
        Kind::Pair(a, b) => ("pair", vec![a, b], None),
        Kind::Unknown(id) => ("unknown", vec![], Some(id)),
    };
    Answer {
        kind: kind.to_owned(),
        effects: effects.into_iter().map(str::to_owned).collect(),
        unknown: unknown.map(str::to_owned),
        parameters,
        gap: plan.gap,
    }
}

//! Random cases: a lens, causes of suitable strength, and the three observation sets.

use std::collections::BTreeMap;

use super::case::{Answer, Case};
use super::expose::{Capture, Cause, Spot, gap, set, spots};
use super::lens::{Lens, LensConstraints};
use super::perturb::{Change, effect};
use super::recipe::{Kind, Recipe};
use super::rng::Rng;
use super::unknown::unknown;

/// Smallest and largest gap of a case.
pub(super) const GAPS: [f64; 2] = [0.02, 0.4];
/// Range of the target gap of a single cause.
const WANTED: [f64; 2] = [0.03, 0.25];
/// Range of the target gap of the first of two causes.
const WANTED_FIRST: [f64; 2] = [0.045, 0.13];
/// Smallest gap of each of two causes alone.
const LEAST_ALONE: f64 = 0.03;
/// Smallest ratio of the smaller to the larger gap of two causes.
const LEAST_RATIO: f64 = 1.0 / 3.0;
/// Number of lenses tried before the best is used.
const ATTEMPTS: u64 = 200;
/// Number of positions, each at two depths, that determine strengths.
const PROBES: usize = 6;
/// Bisections of the logarithm of the strength.
const HALVINGS: usize = 6;

/// Labels of independent random sequences.
mod label {
    pub(super) const PLAN: u64 = 100;
    pub(super) const PLACES: u64 = 200;
    pub(super) const REAL: u64 = 300;
    pub(super) const HOLDOUT: u64 = 400;
}

/// A case before its tiles are computed.
pub(super) struct Plan {
    pub(super) lens: Lens,
    causes: Vec<Cause>,
    /// Gap of each cause alone at the probe positions.
    alone: Vec<f64>,
    /// Spots of the design, the real and the held-out set.
    pub(super) spots: [Vec<Spot>; 3],
    gap: f64,
}

/// Draws the case of `recipe`. The result does not depend on the number of threads.
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
    let (_, plan) = best.expect("at least one lens was tried");
    expose(recipe, &plan)
}

/// Returns a plan and how far its gaps lie outside the allowed ranges, in logarithms.
pub(super) fn attempt_at(recipe: &Recipe, attempt: u64) -> (f64, Plan) {
    let size = &recipe.size;
    let mut rng = Rng::stream(recipe.seed, label::PLAN, attempt);
    let holds = |wanted: &str| match recipe.kind {
        Kind::Single(id) => id == wanted,
        Kind::Pair(a, b) => a == wanted || b == wanted,
        Kind::None | Kind::Unknown(_) => false,
    };
    let depths_matter = holds("defocus_offset") || holds("depth_scale");
    let constraints = LensConstraints {
        slow: holds("diffraction"),
        depth_ratio: if depths_matter { 1.3 } else { 1.1 },
    };
    let lens = Lens::draw(&mut rng, constraints, size.tile);
    let changes: Vec<Change> = match recipe.kind {
        Kind::None => Vec::new(),
        Kind::Single(id) => vec![effect(id, &lens, &mut rng)],
        Kind::Unknown(id) => vec![unknown(id, &mut rng)],
        Kind::Pair(a, b) => {
            // Diffraction has a fixed strength, so the other effect is scaled to it.
            let (a, b) = if b == "diffraction" { (b, a) } else { (a, b) };
            vec![effect(a, &lens, &mut rng), effect(b, &lens, &mut rng)]
        }
    };
    let mut places = Rng::stream(recipe.seed, label::PLACES, attempt);
    let spots_of = [(size.design, 0.0), (size.real, 0.5), (size.holdout, 0.5)]
        .map(|(count, wander)| spots(&lens, count, wander, &mut places));
    let probes = spots(&lens, PROBES, 0.5, &mut places);
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
        let least = if two { LEAST_ALONE } else { GAPS[0] };
        miss += outside(alone, least, GAPS[1]);
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
        let causes: Vec<&Cause> = plan.causes.iter().collect();
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

/// Returns the change at the strength within its range whose gap is closest to `wanted`, and that gap.
fn strengthen(
    lens: &Lens,
    change: Change,
    probes: &[Spot],
    tile: usize,
    wanted: f64,
) -> (Cause, f64) {
    let [mut low, mut high] = change.range;
    let mut cause = Cause {
        change,
        strength: high,
    };
    let at = |strength: f64, cause: &mut Cause| {
        cause.strength = strength;
        gap(lens, &[&*cause], probes, tile)
    };
    let greatest = at(high, &mut cause);
    if greatest <= wanted || low == high {
        return (cause, greatest);
    }
    let least = at(low, &mut cause);
    if least >= wanted {
        return (cause, least);
    }
    let mut found = least;
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        found = at(middle, &mut cause);
        if found < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    (cause, found)
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
    let causes: Vec<&Cause> = plan.causes.iter().collect();
    let take = |causes: &[&Cause], spots: &[Spot], capture: &Capture| {
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

//! Cases of the third-order simulator: a lens, causes of suitable strength, and the three observation sets.

use std::collections::BTreeMap;

use super::case::{Answer, Case};
use super::detection::{SetNoise, detection_limit};
use super::expose::{Alignment, Capture, Cause, GapOptions, Spot, gap, set, spots};
use super::lens::{Lens, LensConstraints};
use super::perturb::{Change, effect};
use super::recipe::{Kind, Recipe};
use super::rng::Rng;
use super::unknown::unknown;

/// Largest gap of a case, except of those whose PSFs move far.
pub(super) const LARGEST_GAP: f64 = 0.4;
/// Smallest gap of a cause, detection limits.
pub(super) const LEAST_LIMITS: f64 = 3.0;
/// Largest wanted gap.
const LARGEST_WANTED: f64 = 0.3;
/// Smallest wanted gap over the smallest gap: gaps of real sets vary about those of the probes.
const WANTED_MARGIN: f64 = 1.2;
/// Smallest ratio of the smaller to the larger gap of the causes of one case.
const LEAST_RATIO: f64 = 1.0 / 3.0;
/// Effects of designs that the third-order model cannot describe, and range of their joint gap in shape.
const DESIGN_EFFECTS: [&str; 4] = ["decentre", "anamorphic", "higher_order", "vignetting"];
const DESIGN_GAP: [f64; 2] = [0.1, 0.3];
/// Number of lenses tried before the best is used.
const ATTEMPTS: u64 = 200;
/// Number of positions, each at every distance, that determine strengths.
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
    /// Causes that the design has too.
    nominal: Vec<Cause>,
    /// Causes of the real lens alone.
    causes: Vec<Cause>,
    /// Gap of each cause alone at the probe positions.
    alone: Vec<f64>,
    /// Spots of the design, the real and the held-out set.
    pub(super) spots: [Vec<Spot>; 3],
    /// Approximate detection limit of the real set.
    limit: f64,
    gap: f64,
}

/// Draws the case of `recipe`.
pub(super) fn draw(recipe: &Recipe) -> Case {
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

/// Draws the effects of a design that the third-order model cannot describe: two or three at once, so that adding one
/// effect to the fitted lens does not mend it.
fn design_effects(lens: &Lens, rng: &mut Rng) -> Vec<Change> {
    let mut ids = DESIGN_EFFECTS;
    rng.shuffle(&mut ids);
    let count = 2 + rng.below(2);
    ids[..count]
        .iter()
        .map(|id| effect(id, lens, rng))
        .collect()
}

/// Returns a plan and how far its gaps lie outside the allowed ranges, in logarithms.
pub(super) fn attempt_at(recipe: &Recipe, attempt: u64) -> (f64, Plan) {
    let conditions = &recipe.conditions;
    let size = &conditions.size;
    let mut rng = Rng::stream(recipe.seed, label::PLAN, attempt);
    let holds = |id: &str| recipe.kind.holds(id);
    let depths_matter = holds("defocus_offset") || holds("depth_scale");
    let constraints = LensConstraints {
        slow: holds("diffraction"),
        depth_ratio: if depths_matter { 1.3 } else { 1.1 },
        distances: conditions.distances,
        // Blur grows with the pupil.
        room: if holds("pupil_scale") { 1.4 } else { 1.0 },
    };
    let lens = Lens::draw(&mut rng, constraints, size.tile);
    // Diffraction has a fixed strength, so the other effects are scaled to it.
    let mut ids = recipe.kind.causes();
    ids.sort_by_key(|id| *id != "diffraction");
    let changes: Vec<Change> = match recipe.kind {
        Kind::Unknown(id) => vec![unknown(id, &mut rng)],
        Kind::TooSimple => design_effects(&lens, &mut rng),
        _ => ids.iter().map(|id| effect(id, &lens, &mut rng)).collect(),
    };
    let mut places = Rng::stream(recipe.seed, label::PLACES, attempt);
    let spots_of = [(size.design, 0.0), (size.real, 0.5), (size.holdout, 0.5)]
        .map(|(count, wander)| spots(&lens, count, wander, &mut places));
    let probes = spots(&lens, PROBES, 0.5, &mut places);
    let noise = SetNoise {
        snr: conditions.snr,
        spots: spots_of[1].len(),
        tile: size.tile,
    };
    let mut plan = Plan {
        limit: detection_limit(&lens, &probes, noise),
        lens,
        nominal: Vec::new(),
        causes: Vec::new(),
        alone: Vec::new(),
        spots: spots_of,
        gap: 0.0,
    };
    let in_design = recipe.kind == Kind::TooSimple;
    let options = GapOptions {
        tile: size.tile,
        // Without ideal positions, common shifts of the channels do not show; the fit of a design absorbs some.
        alignment: if in_design || !conditions.ideal_positions {
            Alignment::Centroid
        } else {
            Alignment::Frame
        },
    };
    let count = changes.len() as f64;
    let [least, low, high] = if in_design {
        [0.5 * DESIGN_GAP[0] / count, DESIGN_GAP[0], DESIGN_GAP[1]]
    } else {
        let least = LEAST_LIMITS * plan.limit;
        [
            least,
            (WANTED_MARGIN * count * least).min(LARGEST_WANTED),
            LARGEST_WANTED,
        ]
    };
    let total = low * libm::pow(high / low, conditions.strength);
    let mut miss = 0.0;
    for change in changes {
        let wanted = match plan.alone.first() {
            Some(first) => first * rng.between(0.6, 1.6),
            None => total / count,
        };
        let (cause, alone) = strengthen(&plan.lens, change, &probes, options, wanted);
        miss += outside(alone, least, largest(&cause.change));
        let list = if in_design {
            &mut plan.nominal
        } else {
            &mut plan.causes
        };
        list.push(cause);
        plan.alone.push(alone);
        if miss > 0.0 && attempt + 1 < ATTEMPTS && attempt > 0 {
            // Tries another lens; only the first plan is always completed, as a fallback.
            return (miss + 10.0, plan);
        }
    }
    let smallest = plan.alone.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = plan.alone.iter().copied().fold(0.0, f64::max);
    if plan.alone.len() > 1 {
        miss += outside(smallest / greatest, LEAST_RATIO, 1.0);
    }
    if !plan.causes.is_empty() {
        let causes: Vec<&Cause> = plan.causes.iter().collect();
        plan.gap = gap(&plan.lens, &causes, &plan.spots[1], options);
        let most = causes
            .iter()
            .map(|c| largest(&c.change))
            .fold(0.0, f64::max);
        miss += outside(plan.gap, least, most);
    }
    (miss, plan)
}

/// Returns the largest gap that `change` may cause.
fn largest(change: &Change) -> f64 {
    if change.moves_far {
        // Tiles without common light have a gap of 1 or more.
        f64::INFINITY
    } else {
        LARGEST_GAP
    }
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
    options: GapOptions,
    wanted: f64,
) -> (Cause, f64) {
    let [mut low, mut high] = change.range;
    let mut cause = Cause {
        change,
        strength: high,
    };
    let at = |strength: f64, cause: &mut Cause| {
        cause.strength = strength;
        gap(lens, &[&*cause], probes, options)
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
    let conditions = &recipe.conditions;
    let background = if rng.chance(0.25) { 0.015 } else { 0.0 };
    let nominal: Vec<&Cause> = plan.nominal.iter().collect();
    let causes: Vec<&Cause> = plan.nominal.iter().chain(&plan.causes).collect();
    let take = |causes: &[&Cause], spots: &[Spot], capture: &Capture| {
        let tile = conditions.size.tile;
        set(&plan.lens, causes, spots, tile, recipe.seed, capture)
    };
    let real = Capture {
        label: label::REAL + 1,
        raw: conditions.raw,
        snr: Some(conditions.snr),
        sigma_stated: conditions.noise_stated,
        background,
        ideal_positions: conditions.ideal_positions,
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
        ideal_positions: true,
    };
    Case {
        design: take(&nominal, &plan.spots[0], &design),
        real: take(&causes, &plan.spots[1], &real),
        holdout: take(&causes, &plan.spots[2], &holdout),
        answer: answer(recipe, plan),
    }
}

/// Returns the answer of a case. Parameters of the design's own effects are keyed `design.effect.parameter`.
fn answer(recipe: &Recipe, plan: &Plan) -> Answer {
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

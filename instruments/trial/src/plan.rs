//! The plan of a case: a lens, and causes of suitable strength.

use super::change::{Cause, Change};
use super::detection::{SetNoise, detection_limit};
use super::expose::{Alignment, GapOptions, Spot, spots};
use super::recipe::{Kind, Recipe};
use super::rng::Rng;
use super::simulated::SimulatedLens;

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
/// Range of the joint gap in shape of the effects of a design that is too rich for the fitted model.
const DESIGN_GAP: [f64; 2] = [0.1, 0.3];
/// Number of positions, each at every distance, that determine strengths.
const PROBES: usize = 6;
/// Strengths tried after the largest.
const TRIALS: usize = 6;
/// Largest logarithm of the ratio of the gap found to the one wanted.
const CLOSE: f64 = 0.12;

/// Labels of independent random sequences, after the first of the simulator.
pub(super) mod label {
    pub(in super::super) const PLAN: u64 = 100;
    pub(in super::super) const PLACES: u64 = 200;
    pub(in super::super) const REAL: u64 = 300;
    pub(in super::super) const HOLDOUT: u64 = 400;
    pub(in super::super) const FURTHER: u64 = 500;
}

/// A case before its tiles are computed.
pub(super) struct Plan<L: SimulatedLens> {
    pub(super) lens: L,
    /// Causes that the design has too.
    pub(super) nominal: Vec<Cause<L::Action>>,
    /// Causes of the real lens alone.
    pub(super) causes: Vec<Cause<L::Action>>,
    /// Gap of each cause alone at the probe positions.
    pub(super) alone: Vec<f64>,
    /// Spots of the design, the real and the held-out set.
    pub(super) spots: [Vec<Spot>; 3],
    /// Approximate detection limit of the real set.
    pub(super) limit: f64,
    pub(super) gap: f64,
}

/// Returns the first plan whose gaps are in the allowed ranges, or the nearest to them.
pub(super) fn plan<L: SimulatedLens>(recipe: &Recipe) -> Plan<L> {
    let mut best: Option<(f64, Plan<L>)> = None;
    for attempt in 0..L::ATTEMPTS {
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

/// Returns a plan and how far its gaps lie outside the allowed ranges, in logarithms.
pub(super) fn attempt_at<L: SimulatedLens>(recipe: &Recipe, attempt: u64) -> (f64, Plan<L>) {
    let conditions = &recipe.conditions;
    let size = &conditions.size;
    let mut rng = Rng::stream(recipe.seed, L::FIRST_LABEL + label::PLAN, attempt);
    let lens = L::draw(recipe.kind, conditions, &mut rng);
    let changes = lens.changes(recipe.kind, &mut rng);
    let mut places = Rng::stream(recipe.seed, L::FIRST_LABEL + label::PLACES, attempt);
    let spots_of = [(size.design, 0.0), (size.real, 0.5), (size.holdout, 0.5)]
        .map(|(count, wander)| spots(lens.camera(), count, wander, &mut places));
    let probes = spots(lens.camera(), PROBES, 0.5, &mut places);
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
    let count = changes.len().max(1) as f64;
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
        if miss > 0.0 && attempt + 1 < L::ATTEMPTS && attempt > 0 {
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
        let causes: Vec<&Cause<L::Action>> = plan.causes.iter().collect();
        plan.gap = plan.lens.gap(&causes, &plan.spots[1], options);
        let most = causes
            .iter()
            .map(|c| largest(&c.change))
            .fold(0.0, f64::max);
        miss += outside(plan.gap, least, most);
    }
    (miss, plan)
}

/// Returns the largest gap that `change` may cause.
fn largest<A>(change: &Change<A>) -> f64 {
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

/// A strength and its gap.
#[derive(Debug, Clone, Copy)]
struct Trial {
    strength: f64,
    gap: f64,
}

/// Returns the change at the strength within its range whose gap is close to `wanted`, and that gap.
///
/// Logarithms of the gap are interpolated over those of the strength; small gaps grow with its square.
fn strengthen<L: SimulatedLens>(
    lens: &L,
    change: Change<L::Action>,
    probes: &[Spot],
    options: GapOptions,
    wanted: f64,
) -> (Cause<L::Action>, f64) {
    let [least, most] = change.range;
    let mut cause = Cause {
        change,
        strength: most,
    };
    let mut try_at = |strength: f64| {
        cause.strength = strength;
        let gap = lens.gap(&[&cause], probes, options);
        Trial { strength, gap }
    };
    let mut above = try_at(most);
    let mut below: Option<Trial> = None;
    let mut last = above;
    for _ in 0..TRIALS {
        let near = libm::log(last.gap / wanted).abs() < CLOSE;
        let spent = (above.gap <= wanted && below.is_none()) || last.strength <= least;
        if near || spent {
            break;
        }
        let guess = match below {
            None if above.gap.is_finite() => above.strength * (wanted / above.gap).sqrt(),
            None => (least * above.strength).sqrt(),
            Some(Trial { strength, .. }) if !above.gap.is_finite() => {
                (strength * above.strength).sqrt()
            }
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

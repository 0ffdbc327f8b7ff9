//! Cases of traced lenses under stated conditions.

use super::super::lens::GlassLens;
use super::super::{EFFECTS, UNKNOWN};
use crate::conditions::{Conditions, Size};
use crate::draw::draw;
use crate::plan::{LARGEST_GAP, LEAST_LIMITS};
use crate::recipe::{FitModel, Kind, Recipe, Simulator};
use crate::rng::Rng;
use crate::simulated::SimulatedLens;

const SMALL: Size = Size {
    design: 2,
    real: 3,
    holdout: 1,
    tile: 25,
};

fn recipe(kind: Kind, seed: u64) -> Recipe {
    Recipe::new(kind, Simulator::Glass, seed, Some(SMALL))
}

#[test]
fn the_same_recipe_is_the_same_case_on_any_number_of_threads() {
    let recipe = recipe(Kind::Single("decentre"), 11);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads can be started");
        pool.install(|| draw(&recipe))
    };
    let case = on(1);
    assert_eq!(case, on(3));
    assert_ne!(case, draw(&Recipe { seed: 12, ..recipe }));
}

/// Draws the case of `recipe` and checks that it follows the conditions.
fn check(recipe: &Recipe) {
    let case = draw(recipe);
    let kind = recipe.kind;
    let least = LEAST_LIMITS * case.answer.parameters["real.detection_limit"];
    let gap = case.answer.gap;
    assert!(
        (least..=LARGEST_GAP).contains(&gap),
        "{kind:?}: {gap}, at least {least}"
    );
    for set in [&case.design, &case.real, &case.holdout] {
        assert_eq!(set.faults(), [], "{kind:?}");
    }
    let conditions = &recipe.conditions;
    assert_eq!(
        case.real.observations.len(),
        conditions.distances * SMALL.real
    );
    assert_eq!(case.real.distances().len(), conditions.distances);
    let first = &case.real.observations[0];
    assert_eq!(first.ideal.is_some(), conditions.ideal_positions);
    assert_eq!(first.noise_sigma[0].is_some(), conditions.noise_stated);
    assert_eq!(case.answer.parameters["real.snr"], conditions.snr);
}

#[test]
fn every_effect_gives_valid_sets_with_a_gap_in_range() {
    for id in EFFECTS {
        check(&recipe(Kind::Single(id), 7));
    }
}

#[test]
fn every_unknown_cause_gives_valid_sets_with_a_gap_in_range() {
    for id in UNKNOWN {
        check(&recipe(Kind::Unknown(id), 7));
    }
}

#[test]
fn one_and_five_distances_and_large_tiles_are_possible() {
    for (distances, tile) in [(1, 49), (5, 33)] {
        let drawn = recipe(Kind::Single("sensor_tilt"), 4);
        check(&Recipe {
            conditions: Conditions {
                distances,
                size: Size { tile, ..SMALL },
                ..drawn.conditions
            },
            ..drawn
        });
    }
}

#[test]
fn two_and_three_causes_have_comparable_gaps() {
    for kind in [
        Kind::Pair("motion", "defocus_offset"),
        Kind::Triple(["vignetting", "lateral_colour", "veiling_glare"]),
    ] {
        let answer = draw(&recipe(kind, 3)).answer;
        let causes = kind.causes();
        let gap_alone = |id: &&str| answer.parameters[&format!("{id}.gap_alone")];
        let alone: Vec<f64> = causes.iter().map(gap_alone).collect();
        let smallest = alone.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = alone.iter().copied().fold(0.0, f64::max);
        assert!(3.0 * smallest >= greatest, "{answer:?}");
        let least = LEAST_LIMITS * answer.parameters["real.detection_limit"];
        assert!(smallest >= least, "{answer:?}");
        assert_eq!(answer.effects, causes);
        assert!(answer.gap <= LARGEST_GAP, "{answer:?}");
    }
}

#[test]
fn cases_without_a_cause_have_no_gap_and_an_extended_fit() {
    for seed in 0..2 {
        let recipe = recipe(Kind::None, seed);
        assert_eq!(recipe.model, FitModel::Extended);
        let case = draw(&recipe);
        assert_eq!(case.answer.gap, 0.0);
        assert_eq!(case.real.faults(), []);
    }
}

#[test]
fn lenses_that_are_too_rich_are_far_from_every_third_order_lens() {
    let recipe = recipe(Kind::TooSimple, 6);
    assert_eq!(recipe.model, FitModel::Reduced);
    let case = draw(&recipe);
    assert_eq!((case.answer.gap, case.answer.effects.len()), (0.0, 0));
    assert_eq!(case.real.faults(), []);
    for seed in 0..3 {
        let lens = GlassLens::draw(Kind::TooSimple, &recipe.conditions, &mut Rng::new(seed));
        let gap = lens.third_order_gap(33).expect("light passes");
        assert!((0.05..=0.5).contains(&gap), "{gap}");
    }
}

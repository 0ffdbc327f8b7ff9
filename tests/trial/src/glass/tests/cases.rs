//! Cases.

use super::super::draw::{GAPS, draw};
use super::super::{EFFECTS, UNKNOWN};
use crate::recipe::{Kind, Recipe, Size};

const SMALL: Size = Size {
    design: 2,
    real: 3,
    holdout: 2,
    tile: 33,
};

fn recipe(kind: Kind, seed: u64) -> Recipe {
    Recipe {
        kind,
        seed,
        size: SMALL,
    }
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

#[test]
fn every_cause_gives_valid_sets_with_a_gap_in_range() {
    let kinds = EFFECTS.iter().map(|id| Kind::Single(id));
    let families = UNKNOWN.iter().map(|id| Kind::Unknown(id));
    for kind in kinds.chain(families) {
        let case = draw(&recipe(kind, 7));
        let gap = case.answer.gap;
        assert!((GAPS[0]..=GAPS[1]).contains(&gap), "{kind:?}: {gap}");
        for set in [&case.design, &case.real, &case.holdout] {
            assert_eq!(set.faults(), [], "{kind:?}");
        }
        assert_eq!(case.real.observations.len(), 2 * SMALL.real);
        assert_eq!(case.real.distances().len(), 2);
    }
}

#[test]
fn two_causes_have_comparable_gaps() {
    for (a, b) in [
        ("motion", "defocus_offset"),
        ("vignetting", "lateral_colour"),
    ] {
        let answer = draw(&recipe(Kind::Pair(a, b), 3)).answer;
        let alone = |id: &str| answer.parameters[&format!("{id}.gap_alone")];
        assert!(3.0 * alone(a).min(alone(b)) >= alone(a).max(alone(b)));
        assert_eq!(answer.effects, [a, b]);
        assert!((GAPS[0]..=GAPS[1]).contains(&answer.gap));
    }
}

#[test]
fn cases_without_a_cause_have_no_gap() {
    for seed in 0..2 {
        let case = draw(&recipe(Kind::None, seed));
        assert_eq!(case.answer.gap, 0.0);
        assert_eq!(case.real.faults(), []);
    }
}

//! Effects that look alike where all objects have one distance, as wrong object distances look like a focus offset.

use super::search::{Candidate, HypothesisSearch};
use seidel_optics::effects;

/// Returns the identifiers of effects that look alike at one distance: the one that acts there on any lens, then its twin.
pub(super) fn alike() -> impl Iterator<Item = [&'static str; 2]> {
    effects::ALL.iter().filter_map(|effect| {
        let twin = effect.description().one_distance_twin.as_ref()?;
        Some([twin.effect.id(), effect.id()])
    })
}

/// Scores effects that do not act on this lens at one distance as their twins, which do.
pub(super) fn score_as_twins(search: &HypothesisSearch, singles: &mut [Candidate]) {
    let tiles = search.many();
    if tiles
        .windows(2)
        .any(|pair| pair[0].distance != pair[1].distance)
    {
        return;
    }
    for index in 0..singles.len() {
        let effect = singles[index].hypothesis.parts[0].0;
        let Some(twin) = &effect.description().one_distance_twin else {
            continue;
        };
        let of_twin = |s: &&Candidate| s.hypothesis.ids() == [twin.effect.id()];
        let Some(acting) = singles.iter().find(of_twin) else {
            continue;
        };
        if singles[index].acts() {
            continue;
        }
        let slots = acting.hypothesis.slots.iter().zip(&acting.theta);
        let kept = slots.filter(|(slot, _)| slot.parameter != twin.without);
        let theta: Vec<f64> = kept.map(|(_, value)| *value).collect();
        let mut start = acting.hypothesis.parts[0].1.clone();
        start.values[twin.without] = twin.effect.parameters()[twin.without].neutral;
        start.free[twin.without] = false;
        singles[index].after = search.refined_alone(twin.effect, start, &theta).after;
        singles[index].acts_as = Some(twin.effect.id());
    }
}

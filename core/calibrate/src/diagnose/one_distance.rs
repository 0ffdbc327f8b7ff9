//! Wrong object distances at one distance, where they look like a focus offset.

use super::search::{Candidate, HypothesisSearch};

/// Effects that look alike at one distance: the one that acts there on any lens, and the one that does not.
const FOCUS_OFFSET: &str = "defocus_offset";
const WRONG_DISTANCES: &str = "depth_scale";
/// Index of the parameter of the focus offset that changes the image size, which wrong distances do not.
const MAGNIFICATION: usize = 1;

/// Scores wrong distances as what they are at one distance: a focus offset that does not change the size of the image. A lens
/// that was fitted at that distance has no law by which they could act.
pub(super) fn score_wrong_distances(search: &HypothesisSearch, singles: &mut [Candidate]) {
    let tiles = search.many();
    if tiles
        .windows(2)
        .any(|pair| pair[0].distance != pair[1].distance)
    {
        return;
    }
    let place = |id: &str| singles.iter().position(|s| s.hypothesis.ids() == [id]);
    let (Some(focus), Some(distances)) = (place(FOCUS_OFFSET), place(WRONG_DISTANCES)) else {
        return;
    };
    if singles[distances].acts() {
        return;
    }
    let (effect, start) = &singles[focus].hypothesis.parts[0];
    let slots = singles[focus].hypothesis.slots.iter();
    let kept = slots.zip(&singles[focus].theta);
    let theta: Vec<f64> = kept
        .filter(|(slot, _)| slot.parameter != MAGNIFICATION)
        .map(|(_, value)| *value)
        .collect();
    let mut start = start.clone();
    start.values[MAGNIFICATION] = effect.parameters()[MAGNIFICATION].neutral;
    start.free[MAGNIFICATION] = false;
    singles[distances].after = search.refined_alone(*effect, start, &theta).after;
    singles[distances].acts_as = Some(FOCUS_OFFSET);
}

//! The corner of a crop in its picture, searched where positions leave room for one.

use seidel_optics::observations::ObservationSet;

use super::mistakes::{Mistake, of_crop};

/// Least room for a crop, as a share of the frame along both axes, and least gap to search for one.
const MIN_ROOM: f64 = 0.1;
const MIN_GAP: f64 = 0.03;
/// Corners tried along each axis at first, and the step at which the search stops, px.
const CORNERS: usize = 5;
const SMALLEST_STEP_PX: f64 = 1.0;

/// Returns the crop that explains the gap `before` of `set`, with the gap after it; `None` where there is none. `gap` measures a corrected
/// set.
pub(super) fn find(
    set: &ObservationSet,
    before: f64,
    gap: impl Fn(&ObservationSet) -> Option<f64>,
) -> Option<(f64, Mistake)> {
    let size = [set.frame.width_px(), set.frame.height_px()].map(f64::from);
    let room = room(set, size);
    if before < MIN_GAP || (0..2).any(|axis| room[axis] < MIN_ROOM * size[axis]) {
        return None;
    }
    let at = |corner: [f64; 2]| {
        let corner = [0, 1].map(|axis| corner[axis].clamp(0.0, room[axis]).round());
        let after = gap(&of_crop(corner).correct(set)?)?;
        Some((after, corner))
    };
    let least = |corners: &mut dyn Iterator<Item = [f64; 2]>| {
        corners.filter_map(at).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let share = |k: usize| k as f64 / (CORNERS - 1) as f64;
    let mut grid = (0..CORNERS * CORNERS)
        .map(|k| [room[0] * share(k % CORNERS), room[1] * share(k / CORNERS)]);
    let mut best = least(&mut grid)?;
    // Compass search, halving its step.
    let mut step = [0, 1].map(|axis| room[axis] * share(1) / 2.0);
    while step[0].max(step[1]) >= SMALLEST_STEP_PX {
        let (_, [x, y]) = best;
        let mut around = [-1.0, 1.0]
            .into_iter()
            .flat_map(|sign| [[x + sign * step[0], y], [x, y + sign * step[1]]]);
        match least(&mut around) {
            Some(better) if better.0 < best.0 => best = better,
            _ => step = step.map(|s| s / 2.0),
        }
    }
    let (after, corner) = best;
    let mistake = of_crop(corner);
    let is_crop = corner != [0.0; 2] && after <= mistake.largest_share * before;
    is_crop.then_some((after, mistake))
}

/// Returns how far right and down the positions of `set` can move in a frame of that size, px.
fn room(set: &ObservationSet, size: [f64; 2]) -> [f64; 2] {
    let places = || set.observations.iter().map(|o| o.ideal.unwrap_or(o.centre));
    let right = places().map(|at| at.x_px).fold(0.0, f64::max);
    let bottom = places().map(|at| at.y_px).fold(0.0, f64::max);
    [size[0] - right, size[1] - bottom].map(|room| room.max(0.0))
}

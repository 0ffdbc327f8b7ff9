//! Lights that moved between photographs of one scene from one place.
//!
//! Photographs at one distance show the same lights. Where most of them are found again, the frames are taken as repeats:
//! the median shift is that of the camera, and a light that departs from it has moved.

use super::MeasuredLight;
use crate::rejection::{LeftOut, Reason};
use seidel_optics::numeric::median;

/// Shift of the whole frame up to which lights are looked for again, px.
const SEARCH_PX: f64 = 3.0;
/// Share of the lights that repeats have in common.
const MIN_SHARE: f64 = 0.5;
/// Least departure from the common shift that is motion, px, and in standard deviations.
const MIN_MOTION_PX: f64 = 0.2;
const MIN_MOTION_SIGMAS: f64 = 6.0;

/// Removes the lights of `groups` (one list a photograph, all at one distance) that moved against the first photograph,
/// but for the numbers `keep`.
pub(crate) fn reject_moved(
    groups: &mut [&mut Vec<MeasuredLight>],
    keep: &[usize],
    left_out: &mut Vec<LeftOut>,
) {
    let Some((first, others)) = groups.split_first_mut() else {
        return;
    };
    let first: &[MeasuredLight] = first;
    for lights in others {
        let pairs: Vec<(usize, usize)> = (0..lights.len())
            .filter_map(|k| Some((nearest(first, &lights[k])?, k)))
            .collect();
        if (pairs.len() as f64) < MIN_SHARE * lights.len().max(1) as f64 {
            continue;
        }
        let shift = |axis: usize| {
            let mut all: Vec<f64> = (pairs.iter())
                .map(|(a, b)| lights[*b].place()[axis] - first[*a].place()[axis])
                .collect();
            median(&mut all)
        };
        let common = [shift(0), shift(1)];
        let motion = |a: usize, b: usize| {
            let along =
                |axis: usize| lights[b].place()[axis] - first[a].place()[axis] - common[axis];
            along(0).hypot(along(1))
        };
        let moved: Vec<(usize, f64, f64)> = (pairs.iter())
            .map(|&(a, b)| {
                let sigma = first[a].place_sigma().hypot(lights[b].place_sigma());
                (
                    b,
                    motion(a, b),
                    MIN_MOTION_PX.max(MIN_MOTION_SIGMAS * sigma),
                )
            })
            .filter(|(index, motion, limit)| {
                motion > limit && !keep.contains(&lights[*index].number)
            })
            .collect();
        for (index, value, limit) in moved.iter().rev() {
            let light = lights.remove(*index);
            let [x, y] = light.place();
            left_out.push(LeftOut {
                photograph: light.photograph,
                number: Some(light.number),
                x,
                y,
                why: Reason::Moved,
                value: *value,
                limit: *limit,
            });
        }
    }
}

/// Returns the index of the light of `all` that lies nearest to `light`, within [`SEARCH_PX`].
fn nearest(all: &[MeasuredLight], light: &MeasuredLight) -> Option<usize> {
    let [x, y] = light.place();
    let distance = |other: &MeasuredLight| {
        let [ox, oy] = other.place();
        (ox - x).hypot(oy - y)
    };
    let found = (0..all.len()).min_by(|a, b| distance(&all[*a]).total_cmp(&distance(&all[*b])))?;
    (distance(&all[found]) < SEARCH_PX).then_some(found)
}

//! Places and distances without a tile, where a fit extrapolates.

use crate::measure::MeasuredTile;
use seidel_optics::field::Frame;

/// Share of the frame's width or height from a border without a tile that is reported.
const MAX_BARE_SHARE: f64 = 0.3;

/// Returns a remark for each side of the frame that has no tile near it, and one where all tiles are at one known distance.
pub(super) fn remarks(frame: &Frame, tiles: &[MeasuredTile]) -> Vec<String> {
    let (width, height) = (f64::from(frame.width_px()), f64::from(frame.height_px()));
    let mut remarks = Vec::from_iter(one_distance(tiles));
    remarks.extend(bare_sides("x", ["left", "right"], width, || {
        tiles.iter().map(|t| t.centroid.x_px)
    }));
    remarks.extend(bare_sides("y", ["top", "bottom"], height, || {
        tiles.iter().map(|t| t.centroid.y_px)
    }));
    remarks
}

fn one_distance(tiles: &[MeasuredTile]) -> Option<String> {
    let distance = tiles.first()?.distance;
    distance.vergence_per_m()?;
    let is_only = tiles.iter().all(|tile| tile.distance == distance);
    is_only.then(|| {
        format!(
            "all PSFs are at {distance}: the blur is the same at every other distance, and focus cannot change it. Add a set at a second and a third distance"
        )
    })
}

/// Returns a remark for each of the two `sides` of a frame of `size` px along `axis` that is bare of `places`.
fn bare_sides<P: Iterator<Item = f64>>(
    axis: &str,
    [first, last]: [&str; 2],
    size: f64,
    places: impl Fn() -> P,
) -> Vec<String> {
    let least = places().fold(f64::INFINITY, f64::min);
    let most = places().fold(f64::NEG_INFINITY, f64::max);
    let remark = |side: &str, from: &str, at: f64| {
        format!(
            "no PSF lies near the {side} of the frame, {from} {axis} = {at:.0} px of {size:.0}: the blur there is extrapolated. Add PSFs there"
        )
    };
    let bare = MAX_BARE_SHARE * size;
    let of_first = (least.is_finite() && least > bare).then(|| remark(first, "before", least));
    let of_last = (most.is_finite() && most < size - bare).then(|| remark(last, "beyond", most));
    of_first.into_iter().chain(of_last).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{measure, tests::discs};
    use seidel_optics::moments::support::Support;

    fn remarks_of(places: &[[f64; 2]]) -> Vec<String> {
        let set = discs(3.0, places);
        let frame = set.frame;
        remarks(
            &frame,
            &measure(&[set], Support::AllPixels, &mut Vec::new()),
        )
    }

    #[test]
    fn a_bare_half_of_the_frame_is_named() {
        let corners = [[120.5, 90.5], [880.5, 90.5], [120.5, 510.5], [880.5, 510.5]];
        assert_eq!(remarks_of(&corners), Vec::<String>::new());
        let left = [[120.5, 90.5], [480.5, 90.5], [120.5, 510.5], [480.5, 510.5]];
        let found = remarks_of(&left);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].contains("near the right of the frame, beyond x = 48"),
            "{found:?}"
        );
    }
}

//! Places and distances without a tile, where a fit extrapolates.

use crate::measure::MeasuredTile;
use seidel_optics::field::{Frame, ImagePoint};

/// Share of the frame's width or height from a border without a tile that is reported. A chart on the middle half of a frame
/// gave a lens 10 dB worse at the border than one that filled it.
const MAX_BARE_SHARE: f64 = 0.2;

/// Part of the remark that all PSFs are at one distance.
pub const ONE_DISTANCE: &str = "the blur is the same at every other distance";

/// Returns a remark for each side of the frame that has no tile near it, and one where all tiles are at one known distance.
pub(super) fn remarks(frame: &Frame, tiles: &[MeasuredTile]) -> Vec<String> {
    let mut remarks = Vec::from_iter(one_distance(tiles));
    let places: Vec<ImagePoint> = tiles.iter().map(|t| t.centroid).collect();
    remarks.extend(bare_sides(frame, &places, "PSF"));
    remarks
}

fn one_distance(tiles: &[MeasuredTile]) -> Option<String> {
    let distance = tiles.first()?.distance;
    distance.vergence_per_m()?;
    let is_only = tiles.iter().all(|tile| tile.distance == distance);
    is_only.then(|| {
        format!(
            "all PSFs are at {distance}: {ONE_DISTANCE}, and focus cannot change it. Add a set at a second and a third distance"
        )
    })
}

/// Returns a remark that names the sides of the frame with no place near them; `what` names the places. `None` for no bare side.
pub fn bare_sides(frame: &Frame, places: &[ImagePoint], what: &str) -> Option<String> {
    let of_axis = |names: [&str; 2], axis: &str, size: u32, of: fn(&ImagePoint) -> f64| {
        let size = f64::from(size);
        let least = places.iter().map(of).fold(f64::INFINITY, f64::min);
        let most = places.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        let bare = MAX_BARE_SHARE * size;
        let first = (least.is_finite() && least > bare)
            .then(|| format!("{} (before {axis} = {least:.0} of {size:.0} px)", names[0]));
        let last = (most.is_finite() && most < size - bare)
            .then(|| format!("{} (beyond {axis} = {most:.0} of {size:.0} px)", names[1]));
        first.into_iter().chain(last)
    };
    let columns = of_axis(["left", "right"], "x", frame.width_px(), |p| p.x_px);
    let rows = of_axis(["top", "bottom"], "y", frame.height_px(), |p| p.y_px);
    let bare: Vec<String> = columns.chain(rows).collect();
    (!bare.is_empty()).then(|| {
        format!(
            "no {what} lies near these sides of the frame: {}. The blur there is extrapolated: photograph {what}s there too, at the same distance and focus",
            bare.join(", ")
        )
    })
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
        assert!(found[0].contains("right (beyond x = 48"), "{found:?}");
    }
}

//! Parts of the frame without a tile, where a fit extrapolates.

use crate::measure::MeasuredTile;
use seidel_optics::field::Frame;

/// Share of the frame's width or height from a border without a tile that is reported.
const MAX_BARE_SHARE: f64 = 0.3;

/// Returns a remark for each side of the frame that has no tile near it.
pub(super) fn remarks(frame: &Frame, tiles: &[MeasuredTile]) -> Vec<String> {
    let sides = [
        Side::new(
            tiles,
            |t| t.centroid.x_px,
            f64::from(frame.width_px()),
            ["left", "right"],
            "x",
        ),
        Side::new(
            tiles,
            |t| t.centroid.y_px,
            f64::from(frame.height_px()),
            ["top", "bottom"],
            "y",
        ),
    ];
    sides.into_iter().flat_map(Side::remarks).collect()
}

/// The extent of the tiles along one axis of a frame.
struct Side {
    least: f64,
    most: f64,
    size: f64,
    names: [&'static str; 2],
    axis: &'static str,
}

impl Side {
    fn new(
        tiles: &[MeasuredTile],
        place: impl Fn(&MeasuredTile) -> f64,
        size: f64,
        names: [&'static str; 2],
        axis: &'static str,
    ) -> Self {
        let places = || tiles.iter().map(&place);
        Self {
            least: places().fold(f64::INFINITY, f64::min),
            most: places().fold(f64::NEG_INFINITY, f64::max),
            size,
            names,
            axis,
        }
    }

    fn remarks(self) -> Vec<String> {
        let [first, last] = self.names;
        let mut remarks = Vec::new();
        let bare = MAX_BARE_SHARE * self.size;
        let extrapolated = "the blur there is extrapolated. Add PSFs there";
        if self.least > bare && self.least.is_finite() {
            remarks.push(format!(
                "no PSF lies near the {first} of the frame, before {} = {:.0} px of {:.0}: {extrapolated}",
                self.axis, self.least, self.size
            ));
        }
        if self.most < self.size - bare && self.most.is_finite() {
            remarks.push(format!(
                "no PSF lies near the {last} of the frame, beyond {} = {:.0} px of {:.0}: {extrapolated}",
                self.axis, self.most, self.size
            ));
        }
        remarks
    }
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

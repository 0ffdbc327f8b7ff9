//! Places and distances without a tile, where a fit extrapolates.

use crate::measure::MeasuredTile;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::profile::{self, TileCoverage, distance_gap};

/// Part of the remark that all PSFs are at one distance.
pub const ONE_DISTANCE: &str = "the blur is the same at every other distance";

/// Returns remarks on the sides of the frame that have no tile near them, on a gap between distances, and where all tiles are at one
/// known distance.
pub(super) fn remarks(frame: &Frame, tiles: &[MeasuredTile]) -> Vec<String> {
    let places: Vec<ImagePoint> = tiles.iter().map(|t| t.centroid).collect();
    let gap = distance_gap(&by_distance(tiles)).map(|gap| {
        format!(
            "no PSF lies {gap}: the blur there is interpolated. Add a set at a distance between them"
        )
    });
    let all = [one_distance(tiles), bare_sides(frame, &places, "PSF"), gap];
    all.into_iter().flatten().collect()
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

/// Returns the places of `tiles` by distance, from the farthest.
pub(super) fn by_distance<'a>(
    tiles: impl IntoIterator<Item = &'a MeasuredTile>,
) -> Vec<TileCoverage> {
    let mut groups: Vec<(Option<f64>, Vec<ImagePoint>)> = Vec::new();
    for tile in tiles {
        let vergence = tile.distance.vergence_per_m();
        match groups.iter_mut().find(|(of, _)| *of == vergence) {
            Some((_, places)) => places.push(tile.centroid),
            None => groups.push((vergence, vec![tile.centroid])),
        }
    }
    groups.sort_by(|(a, _), (b, _)| a.unwrap_or(-1.0).total_cmp(&b.unwrap_or(-1.0)));
    let groups = groups.into_iter();
    groups
        .map(|(vergence, places)| extent(vergence, places.into_iter()))
        .collect()
}

fn extent(vergence_per_m: Option<f64>, places: impl Iterator<Item = ImagePoint>) -> TileCoverage {
    let nothing = [f64::INFINITY, f64::NEG_INFINITY];
    let empty = TileCoverage {
        vergence_per_m,
        tiles: 0,
        x_px: nothing,
        y_px: nothing,
    };
    let grown = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
    places.fold(empty, |all, place| TileCoverage {
        tiles: all.tiles + 1,
        x_px: grown(all.x_px, place.x_px),
        y_px: grown(all.y_px, place.y_px),
        ..all
    })
}

/// Returns a remark that names the sides of the frame with no place near them; `what` names the places. `None` for no bare side.
pub fn bare_sides(frame: &Frame, places: &[ImagePoint], what: &str) -> Option<String> {
    let bare = profile::bare_sides(&[extent(None, places.iter().copied())], frame)?;
    Some(format!(
        "no {what} lies near these sides of the frame: {bare}. The blur there is extrapolated: photograph {what}s there too, at the same distance and focus"
    ))
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

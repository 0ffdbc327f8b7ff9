//! Coverage of the field by the observed tiles: the effects that they can show, and the captures that are missing.

use super::tiles::{FOLDS, TileData};
use seidel_optics::effects::{self, Effect, FieldNeed};
use seidel_optics::error::{Error, ErrorKind};
use seidel_optics::field::FieldPoint;

/// Minimum number of tiles for a diagnosis.
const MIN_TILES: usize = 6;
/// Numbers of tiles and of places below which a remark asks for more.
const FEW_TILES: usize = 15;
const FEW_PLACES: usize = 5;
/// Distance up to which tiles lie at one place, half frame widths.
const SAME_PLACE: f64 = 0.05;
/// Number of places, and least range of their distances from the axis (half frame widths), that show radial change.
const RADIAL_PLACES: usize = 3;
const MIN_RADIAL_RANGE: f64 = 0.2;
/// Number of places, and least standard deviation of their positions in every direction (half frame widths), that show
/// a change from one side to the other.
const SIDE_PLACES: usize = 4;
const MIN_SIDE_SPREAD: f64 = 0.1;
/// The missing captures.
const SHOOT: &str = "shoot PSFs in the middle, half-way and in all four corners: nine or more places, at two or more distances";

/// The places of the field at which tiles were observed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coverage {
    tiles: usize,
    places: usize,
    /// Range of the distances from the axis, half frame widths.
    radial_range: f64,
    /// Standard deviation of the positions along the direction in which it is smallest, half frame widths.
    side_spread: f64,
}

impl Coverage {
    /// Measures the coverage of `tiles`.
    pub(super) fn of(tiles: &[TileData]) -> Self {
        Self::of_points(tiles.iter().map(|tile| tile.point.at))
    }

    fn of_points(points: impl Iterator<Item = FieldPoint>) -> Self {
        let mut places: Vec<FieldPoint> = Vec::new();
        let mut tiles = 0;
        for point in points {
            tiles += 1;
            let near = |p: &FieldPoint| (p.x - point.x).hypot(p.y - point.y) < SAME_PLACE;
            if !places.iter().any(near) {
                places.push(point);
            }
        }
        let radii = places.iter().map(|p| p.radius());
        let (least, most) = radii.fold((f64::INFINITY, 0.0_f64), |(least, most), r| {
            (least.min(r), most.max(r))
        });
        Self {
            tiles,
            places: places.len(),
            radial_range: (most - least).max(0.0),
            side_spread: smallest_spread(&places),
        }
    }

    /// Returns whether the tiles can show `effect`.
    pub(super) fn shows(&self, effect: &dyn Effect) -> bool {
        match effect.description().field_need {
            FieldNeed::AnyPlace => true,
            FieldNeed::Radii => {
                self.places >= RADIAL_PLACES && self.radial_range >= MIN_RADIAL_RANGE
            }
            FieldNeed::Sides => self.places >= SIDE_PLACES && self.side_spread >= MIN_SIDE_SPREAD,
        }
    }

    /// Checks that there are enough tiles for a diagnosis.
    ///
    /// # Errors
    /// Too few tiles; the message names the effects that tiles at these places can show, and what to shoot.
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.tiles >= MIN_TILES {
            return Ok(());
        }
        let (shown, hidden): (Vec<_>, Vec<_>) = effects::causes().partition(|e| self.shows(*e));
        let hidden = if hidden.is_empty() {
            String::new()
        } else {
            format!(", but not {}", titles(&hidden))
        };
        Err(Error::new(
            "observations",
            format!(
                "hold {} that can be used, fewer than the {MIN_TILES} of a diagnosis. More of them at the same places could show {}{hidden}",
                self.counts(),
                titles(&shown)
            ),
            SHOOT,
        )
        .with_kind(ErrorKind::InsufficientData))
    }

    /// Returns a remark on the effects `hidden` that the tiles cannot show, or on a small number of places; `None` where
    /// the coverage suffices.
    pub(super) fn remark(&self, hidden: &[&'static dyn Effect]) -> Option<String> {
        if !hidden.is_empty() {
            return Some(format!(
                "{} cannot show effects that change over the field, so these were not tried: {}; {SHOOT}",
                self.counts(),
                titles(hidden)
            ));
        }
        (self.tiles < FEW_TILES || self.places < FEW_PLACES).then(|| {
            format!(
                "effects that change over the field rest on {}; to be sure of them, {SHOOT}",
                self.counts()
            )
        })
    }

    fn counts(&self) -> String {
        let places = if self.places == 1 { "place" } else { "places" };
        format!("{} tiles at {} {places}", self.tiles, self.places)
    }
}

/// Returns `folds` where they differ, and else folds by turns, so that something is always held out.
pub(super) fn distinct_folds(folds: Vec<usize>) -> Vec<usize> {
    if folds.iter().any(|fold| *fold != folds[0]) {
        return folds;
    }
    (0..folds.len()).map(|index| index % FOLDS).collect()
}

/// Returns the titles of `effects`, joined by commas.
pub(super) fn titles(effects: &[&'static dyn Effect]) -> String {
    let titles: Vec<&str> = effects.iter().map(|e| e.description().title).collect();
    titles.join(", ")
}

/// Returns the standard deviation of `places` along the direction in which it is smallest.
fn smallest_spread(places: &[FieldPoint]) -> f64 {
    let count = places.len().max(1) as f64;
    let mean = |of: &dyn Fn(&FieldPoint) -> f64| places.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(&|p| p.x), mean(&|p| p.y));
    let xx = mean(&|p| (p.x - x).powi(2));
    let yy = mean(&|p| (p.y - y).powi(2));
    let xy = mean(&|p| (p.x - x) * (p.y - y));
    let half = (xx + yy) / 2.0;
    let least = half - ((xx - yy) / 2.0).hypot(xy);
    least.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coverage(places: &[(f64, f64)], tiles_per_place: usize) -> Coverage {
        let points = places.iter().map(|(x, y)| FieldPoint::new(*x, *y));
        Coverage::of_points(points.flat_map(|p| std::iter::repeat_n(p, tiles_per_place)))
    }

    fn hidden(coverage: &Coverage) -> Vec<&'static str> {
        let all = effects::causes().filter(|e| !coverage.shows(*e));
        all.map(Effect::id).collect()
    }

    const CORNERS: [(f64, f64); 5] = [
        (0.0, 0.0),
        (0.8, 0.5),
        (-0.8, 0.5),
        (0.8, -0.5),
        (-0.8, -0.5),
    ];

    #[test]
    fn one_place_shows_only_what_is_alike_over_the_field() {
        let one = coverage(&[(0.1, 0.0)], 3);
        let unseen = hidden(&one);
        for id in [
            "sensor_tilt",
            "decentre",
            "distortion",
            "vignetting",
            "lateral_colour",
        ] {
            assert!(unseen.contains(&id), "{id}");
        }
        for id in [
            "defocus_offset",
            "pixel_footprint",
            "motion",
            "veiling_glare",
            "tone_curve",
        ] {
            assert!(!unseen.contains(&id), "{id}");
        }
        let error = one.check().expect_err("too few").to_string();
        for part in [
            "3 tiles at 1 place",
            "a focus offset",
            "but not",
            "a tilted sensor",
            "corners",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
        let many = coverage(&[(0.1, 0.0)], 8);
        assert!(many.check().is_ok());
        let remark = many.remark(&[effects::by_id("sensor_tilt").expect("listed")]);
        assert!(remark.is_some_and(|r| r.contains("not tried: a tilted sensor")));
    }

    #[test]
    fn a_row_of_places_shows_radial_change_but_no_tilt() {
        let row: Vec<(f64, f64)> = (0..6).map(|k| (0.15 * f64::from(k), 0.0)).collect();
        assert_eq!(hidden(&coverage(&row, 1)), ["sensor_tilt", "decentre"]);
    }

    #[test]
    fn all_corners_show_everything_and_few_tiles_are_remarked() {
        let few = coverage(&CORNERS, 2);
        assert!(hidden(&few).is_empty() && few.check().is_ok());
        assert!(
            few.remark(&[])
                .is_some_and(|r| r.contains("10 tiles at 5 places"))
        );
        assert_eq!(coverage(&CORNERS, 3).remark(&[]), None);
    }

    #[test]
    fn folds_are_kept_where_they_differ() {
        assert_eq!(distinct_folds(vec![2, 2, 1]), [2, 2, 1]);
        assert_eq!(distinct_folds(vec![2, 2, 2]), [0, 1, 2]);
        assert!(distinct_folds(Vec::new()).is_empty());
    }
}

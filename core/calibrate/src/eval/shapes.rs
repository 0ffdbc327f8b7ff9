//! Observed PSFs and their predictions, pixel by pixel, for display.

use super::{EvalSettings, LensAtDistance, chosen_channels, one_frame};
use crate::measure::{MeasuredTile, measure};
use crate::score::{ImageAutocorrelation, TestImage, prepare_tiles};
use crate::score::{render_kernel, with_pixel_integration};
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::observations::ObservationSet;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::LensProfile;
use seidel_optics::psf::{Gaussian, PsfModel, Pupil, SkewNormal};

/// Field radii shown, relative to the corner: near the axis, half way, near the corner.
pub const SHOWN_RADII: [f64; 3] = [0.1, 0.55, 0.95];

/// Radii that differ by less count as equal. Mirror-symmetric sets hold every radius several times, and
/// rounding must not change the quadrant between distances.
const SAME_RADIUS: f64 = 1e-6;

/// The compared models, most accurate first.
static MODELS: [(&str, &dyn PsfModel); 3] = [
    ("pupil", &Pupil),
    ("skew-normal", &SkewNormal),
    ("Gaussian", &Gaussian),
];

/// An observed PSF and its predictions, all of unit sum on the same square.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeRow {
    /// The observation's file.
    pub file: String,
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Field position.
    pub field: FieldPoint,
    /// Field radius relative to the corner.
    pub corner_share: f64,
    /// Side of the square, px.
    pub side_px: usize,
    /// Measured centroid, px from the top-left corner of the square.
    pub centroid_px: (f64, f64),
    /// Observed samples, zero outside the support, row-major.
    pub observed: Vec<f64>,
    /// Predictions of all applicable models, most accurate first.
    pub predictions: Vec<ShapePrediction>,
}

/// One prediction of an observed PSF.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapePrediction {
    /// Name of the model.
    pub title: &'static str,
    /// Predicted samples, row-major.
    pub samples: Vec<f64>,
    /// Forward-blur SNR of the prediction, dB.
    pub snr_db: f64,
}

/// Returns observed PSFs with the predictions of `lens`, prepared as in [`super::evaluate`].
///
/// Covers the first selected channel, at most three of the selected distances (nearest, middle, farthest),
/// and at each the tiles nearest to [`SHOWN_RADII`], without duplicates.
///
/// # Errors
/// As [`super::evaluate`].
pub fn shapes(
    lens: &LensProfile,
    set: &ObservationSet,
    z: &TestImage,
    settings: &EvalSettings,
) -> Result<Vec<ShapeRow>> {
    one_frame(lens, set)?;
    let predictor = Predictor::new(lens)?;
    let channels = chosen_channels(lens, set, settings)?;
    let none = || {
        Error::new(
            "observations",
            "hold no usable tile to show",
            "choose a channel and distances of the set, and check its saturation marks",
        )
        .with_kind(seidel_optics::ErrorKind::InsufficientData)
    };
    let &(channel, in_lens) = channels.first().ok_or_else(none)?;
    // The evaluation reports excluded tiles.
    let mut rejected = Vec::new();
    let mut measured = measure(std::slice::from_ref(set), settings.support, &mut rejected);
    measured.retain(|tile| {
        let asked = settings.distances.is_empty() || settings.distances.contains(&tile.distance);
        tile.channel == channel && asked
    });
    let mut distances = set.distances();
    distances.retain(|distance| measured.iter().any(|tile| tile.distance == *distance));
    let correlation = ImageAutocorrelation::new(z);
    let mut rows = Vec::new();
    for distance in spread(&distances) {
        let tiles: Vec<&MeasuredTile> =
            measured.iter().filter(|t| t.distance == distance).collect();
        let place = format!("channel {} at {distance}", set.channels[channel]);
        let vergence = predictor.vergence(distance);
        let here = LensAtDistance {
            predictor: &predictor,
            channel: in_lens,
            vergence: vergence.map_err(|error| error.within(&place))?,
        };
        // All tiles of the group are prepared, so that squares and scores equal those of the tables.
        let (side, placed) = prepare_tiles(
            std::slice::from_ref(set),
            &tiles,
            &lens.frame,
            settings.support,
        );
        let scorer = correlation.scorer(side);
        for index in shown(&tiles, &lens.frame) {
            let (measured, tile) = (tiles[index], &placed[index]);
            let square = scorer.blurred_power(&tile.measured);
            let blur = with_pixel_integration(here.blur(tile.field));
            let suited = MODELS
                .iter()
                .filter(|(_, model)| predictor.check_model(*model).is_ok());
            let predictions = suited.map(|&(title, model)| {
                let samples = render_kernel(model, &blur, tile, side);
                ShapePrediction {
                    title,
                    snr_db: tile.snr_db(&scorer, square, &samples),
                    samples,
                }
            });
            rows.push(ShapeRow {
                file: measured.file.clone(),
                channel: set.channels[channel].clone(),
                distance,
                field: tile.field,
                corner_share: tile.field.radius() / lens.frame.corner_radius(),
                side_px: side,
                centroid_px: tile.centroid,
                predictions: predictions.collect(),
                observed: tile.measured.clone(),
            });
        }
    }
    if rows.is_empty() {
        return Err(none());
    }
    Ok(rows)
}

/// Returns the first, middle and last of `all`; all of them if there are at most three.
fn spread(all: &[ObjectDistance]) -> Vec<ObjectDistance> {
    match all.len() {
        0..=3 => all.to_vec(),
        count => vec![all[0], all[(count - 1) / 2], all[count - 1]],
    }
}

/// Returns the indices of the tiles to show, from the axis outwards.
fn shown(tiles: &[&MeasuredTile], frame: &Frame) -> Vec<usize> {
    let corner = frame.corner_radius();
    let mut chosen: Vec<usize> = Vec::new();
    for share in SHOWN_RADII {
        let off: Vec<f64> = tiles
            .iter()
            .map(|tile| (tile.field_point(frame).radius() / corner - share).abs())
            .collect();
        let least = off.iter().copied().fold(f64::INFINITY, f64::min);
        let nearest = off.iter().position(|&v| v <= least + SAME_RADIUS);
        chosen.extend(nearest.filter(|index| !chosen.contains(index)));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::super::evaluate;
    use super::super::tests::{drawn, lens, picture, pupil_lens};
    use super::*;
    use seidel_optics::no_progress;
    use seidel_optics::predict::predict_set;

    #[test]
    fn ends_and_middle_of_distance_and_field_are_shown() {
        let lens = lens();
        let one = drawn(&lens);
        let mut set = one.clone();
        set.observations.clear();
        // With one plane of moments the lens ignores the distance.
        for metres in [4.0, 1.0, 5.0, 2.0, 3.0] {
            set.observations
                .extend(one.observations.iter().cloned().map(|mut o| {
                    o.distance = ObjectDistance::Metres(metres);
                    o
                }));
        }
        let rows = shapes(&lens, &set, &picture(), &EvalSettings::default()).expect("sound");
        let distances: Vec<_> = rows.iter().map(|row| row.distance).collect();
        let want = [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 5.0, 5.0, 5.0];
        assert_eq!(distances, want.map(ObjectDistance::Metres));
        let radii: Vec<f64> = one
            .observations
            .iter()
            .map(|o| lens.frame.field_point(o.centre).radius() / lens.frame.corner_radius())
            .collect();
        for (row, share) in rows.iter().zip(SHOWN_RADII.into_iter().cycle()) {
            let off = (row.corner_share - share).abs();
            // Centroids of cropped tiles deviate slightly from their centres.
            assert!(radii.iter().all(|r| (r - share).abs() > off - 1e-3));
            assert_eq!(row.observed.len(), row.side_px * row.side_px);
            let titles: Vec<_> = row.predictions.iter().map(|p| p.title).collect();
            assert_eq!(titles, ["skew-normal", "Gaussian"]);
        }
        let few = EvalSettings {
            distances: vec![ObjectDistance::Metres(4.0)],
            ..EvalSettings::default()
        };
        let rows = shapes(&lens, &set, &picture(), &few).expect("sound");
        assert_eq!(rows.len(), 3);
        set.observations.retain(|o| o.file == "7.exr");
        let rows = shapes(&lens, &set, &picture(), &few).expect("sound");
        assert_eq!(rows.len(), 1, "one tile is shown once");
        set.observations[0].saturated = true;
        set.observations.truncate(1);
        assert!(shapes(&lens, &set, &picture(), &EvalSettings::default()).is_err());
    }

    #[test]
    fn predictions_match_drawn_psfs_and_scores_match_the_tables() {
        let lens = pupil_lens();
        let predictor = Predictor::new(&lens).expect("sound");
        let places = drawn(&super::super::tests::lens());
        let set = predict_set(&predictor, &places, &Pupil).expect("drawable");
        let settings = EvalSettings::default();
        let rows = shapes(&lens, &set, &picture(), &settings).expect("sound");
        assert_eq!(rows.len(), 3);
        for row in &rows {
            let [pupil, skew, gaussian] = row.predictions.as_slice() else {
                panic!("three models serve a lens of rays");
            };
            assert!(pupil.snr_db > 60.0, "{}", pupil.snr_db);
            assert!(pupil.snr_db > skew.snr_db + 20.0);
            assert!(skew.snr_db > gaussian.snr_db - 3.0);
            let peak = row.observed.iter().copied().fold(0.0, f64::max);
            for (seen, predicted) in row.observed.iter().zip(&pupil.samples) {
                assert!((seen - predicted).abs() < 0.01 * peak);
            }
        }
        // For a set of one tile the mean of the table is its score.
        let mut one = set.clone();
        one.observations.retain(|o| o.file == rows[1].file);
        let alone = shapes(&lens, &one, &picture(), &settings).expect("sound");
        let table = evaluate(&lens, &one, &picture(), &settings, &no_progress).expect("sound");
        let ids = ["pupil-model", "skew-normal-model", "gaussian-model"];
        for (id, prediction) in ids.into_iter().zip(&alone[0].predictions) {
            let methods = &table.groups[0].methods;
            let scored = methods.iter().find(|m| m.id == id).expect("listed");
            assert!((scored.mean_db - prediction.snr_db).abs() < 1e-9, "{id}");
        }
    }
}

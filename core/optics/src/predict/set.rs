//! Predicted PSFs at the positions of an observation set.

use rayon::prelude::*;

use super::Predictor;
use crate::blur_field::BlurField;
use crate::error::{Error, Result};
use crate::field::FieldPoint;
use crate::moments::pixels::PIXEL_VARIANCE_PX2;
use crate::moments::support::{Support, TilePixels};
use crate::observations::{Observation, ObservationSet};
use crate::psf::{LocalBlur, PsfModel, SampleGrid};
use crate::tile::Tile;

/// Predicts the tiles of every observation of `template` with `lens` and `model`.
///
/// Tiles are integrated over pixels and sum to one. Names, sizes, channels, positions and distances are those of
/// `template`.
///
/// If the ideal position is known, the lens determines the position of the PSF; otherwise the PSF has the centroid of
/// the observed tile. If the sensor of the lens has a tone curve, it is applied at the exposure at which the tile has
/// the same sum as the observed one.
///
/// # Errors
/// Rejects a model that cannot draw the lens, another frame size than that of the lens, a channel that the lens does
/// not have, an unknown distance if the blur depends on depth, and a predicted PSF that lies outside its tile.
pub fn predict_set(
    lens: &Predictor,
    template: &ObservationSet,
    model: &dyn PsfModel,
) -> Result<ObservationSet> {
    lens.check_model(model)?;
    template.check_frame(lens.frame())?;
    let channels: Vec<usize> = template
        .channels
        .iter()
        .map(|name| lens.channel_index(name))
        .collect::<Result<_>>()?;
    let observations = template
        .observations
        .par_iter()
        .enumerate()
        .map(|(index, observation)| {
            let tiles = channels
                .iter()
                .enumerate()
                .map(|(channel, &of_lens)| {
                    tile(lens, template, observation, channel, of_lens, model)
                })
                .collect::<Result<_>>()
                .map_err(|e| e.within(&format!("observation {index} ({})", observation.file)))?;
            Ok(Observation {
                tiles,
                noise_sigma: vec![None; channels.len()],
                background: vec![0.0; channels.len()],
                saturated: false,
                gain: None,
                weight_mask: None,
                measurement: None,
                ..observation.clone()
            })
        })
        .collect::<Result<_>>()?;
    Ok(ObservationSet {
        mosaic: None,
        observations,
        ..template.clone()
    })
}

fn tile(
    lens: &Predictor,
    template: &ObservationSet,
    observation: &Observation,
    channel: usize,
    of_lens: usize,
    model: &dyn PsfModel,
) -> Result<Tile> {
    let frame = lens.frame();
    let vergence = lens.vergence(observation.distance)?;
    let observed = &observation.tiles[channel];
    let (at, centre): (FieldPoint, (f64, f64)) = if let Some(ideal) = observation.ideal {
        let at = frame.field_point(ideal);
        let (dx, dy) = lens.blur_at(of_lens, at, vergence).displacement_px;
        let landing = crate::field::ImagePoint::new(ideal.x_px + dx, ideal.y_px + dy);
        (at, observation.tile_point(landing))
    } else {
        let light = observation.light(channel);
        let counted = template.counted(observation, channel);
        let pixels = TilePixels {
            tile: &light,
            counted: counted.as_deref(),
            noise_sigma: observation.noise_sigma[channel],
        };
        let (m, _) = pixels.moments(Support::Auto).ok_or_else(|| {
            Error::new(
                "tile",
                "holds no light to centre the prediction on",
                "give ideal_x and ideal_y, or leave the observation out",
            )
        })?;
        let centroid = observation.frame_point(m.centroid_x, m.centroid_y);
        (frame.field_point(centroid), (m.centroid_x, m.centroid_y))
    };
    let placed = lens.blur_at(of_lens, at, vergence);
    let blur = LocalBlur {
        // Adds the pixel area, over which the sensor integrates. The model `pupil` integrates over
        // pixels itself and does not use the moments.
        moments: placed
            .blur
            .moments
            .with_least_variance(0.0)
            .with_added_variance(PIXEL_VARIANCE_PX2),
        ..placed.blur
    };
    let (width, height) = (observed.width(), observed.height());
    let window = SampleGrid::for_tile(width, height, centre.0, centre.1);
    let mut samples = vec![0.0; window.len()];
    model.sample(&blur, &window, &mut samples);
    let tone = lens.tone(of_lens);
    if !tone.is_linear() {
        let light = observation.light(channel);
        let sum = light.samples().iter().map(|v| f64::from(*v)).sum();
        if let Some(exposure) = tone.exposure(&samples, sum) {
            let values = samples.iter_mut();
            values.for_each(|v| *v = tone.apply(exposure * *v));
        }
    }
    let sum: f64 = samples.iter().sum();
    if sum <= 0.0 || !sum.is_finite() {
        return Err(Error::new(
            "tile",
            format!(
                "the predicted PSF falls outside it, at tile position ({:.1}, {:.1})",
                centre.0, centre.1
            ),
            "check ideal_x, ideal_y and the tile's position",
        ));
    }
    Tile::new(
        width,
        height,
        samples.iter().map(|v| (v / sum) as f32).collect(),
    )
}

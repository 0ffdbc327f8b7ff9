//! The PSFs a lens predicts at the places of an observation set.

use rayon::prelude::*;

use super::Predictor;
use crate::blur_field::BlurField;
use crate::error::{Error, Result};
use crate::field::FieldPoint;
use crate::moments::pixels::PIXEL_VARIANCE_PX2;
use crate::moments::support::{self, Support};
use crate::observations::{Observation, ObservationSet};
use crate::psf::{LocalBlur, PsfModel, SampleGrid};
use crate::tile::Tile;

/// For every observation of `like` the tiles that `lens` predicts with `model`: unit sums, the same
/// names, sizes, channels, positions and distances, integrated over pixels.
///
/// Where the ideal position is known the PSF lands where the lens puts that point; otherwise its
/// centroid is that of the observed tile. Where the lens's sensor has a tone, the observed tile is also
/// read for its exposure: tone acts on the predicted light scaled such that the values that come of it hold
/// as much as the observed tile's.
///
/// # Errors
/// A model that cannot draw the lens, another frame size than the lens's, a channel the lens has not, an
/// unknown distance where the lens depends on it, and a tile that misses the predicted PSF altogether.
pub fn predict_set(
    lens: &Predictor,
    like: &ObservationSet,
    model: &dyn PsfModel,
) -> Result<ObservationSet> {
    lens.check_model(model)?;
    like.check_frame(lens.frame())?;
    let channels: Vec<usize> = like
        .channels
        .iter()
        .map(|name| lens.channel_index(name))
        .collect::<Result<_>>()?;
    let observations = like
        .observations
        .par_iter()
        .enumerate()
        .map(|(index, observation)| {
            let tiles = channels
                .iter()
                .enumerate()
                .map(|(channel, &of_lens)| tile(lens, observation, channel, of_lens, model))
                .collect::<Result<_>>()
                .map_err(|e| e.within(&format!("observation {index} ({})", observation.file)))?;
            Ok(Observation {
                tiles,
                noise_sigma: vec![None; channels.len()],
                background: vec![0.0; channels.len()],
                saturated: false,
                ..observation.clone()
            })
        })
        .collect::<Result<_>>()?;
    Ok(ObservationSet {
        observations,
        ..like.clone()
    })
}

fn tile(
    lens: &Predictor,
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
        let noise = observation.noise_sigma[channel];
        let (m, _) = support::moments(&light, noise, Support::Auto).ok_or_else(|| {
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
        // Never narrower than a pixel: the sensor integrates over its own area. Models that draw rays
        // integrate over pixels themselves.
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
        let seen = observation.light(channel);
        let seen = seen.samples().iter().map(|v| f64::from(*v)).sum();
        if let Some(exposure) = tone.exposure(&samples, seen) {
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

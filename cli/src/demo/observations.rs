//! PSFs of the built-in lens with noise, as if points of light had been photographed.

use seidel_core::{
    BlurField, ImagePoint, LensProfile, ObjectDistance, Observation, ObservationSet, Predictor,
    Result, Tile,
};
use seidel_optics::predict::predict_set;

use super::noise::normal;

/// Point lights across and down the frame.
const GRID: (u32, u32) = (6, 4);
/// Their distances, m.
const DISTANCES_M: [f64; 4] = [f64::INFINITY, 4.0, 2.0, 1.2];
/// Ratio of a tile's peak to its noise.
const PEAK_OVER_NOISE: f64 = 400.0;

/// Returns one observation per point light and distance, predicted by `lens` and with noise added.
///
/// # Errors
/// A lens without a depth law.
pub fn measured(lens: &LensProfile) -> Result<ObservationSet> {
    photographed(lens, &DISTANCES_M, 0)
}

/// Returns observations like [`measured`] at `distances_m`, with the noise of `first_seed` and those after it.
///
/// # Errors
/// A lens without a depth law, and an invalid distance.
pub fn photographed(
    lens: &LensProfile,
    distances_m: &[f64],
    first_seed: u64,
) -> Result<ObservationSet> {
    let predictor = Predictor::new(lens)?;
    let mut observations = Vec::new();
    for &metres in distances_m {
        let distance = ObjectDistance::metres(metres)?;
        for place in 0..GRID.0 * GRID.1 {
            observations.push(Observation {
                file: format!("psf/{:04}.exr", observations.len()),
                ..blank(&predictor, place, GRID, distance)?
            });
        }
    }
    let template = ObservationSet {
        frame: lens.frame,
        axis_stated: true,
        mosaic: None,
        pixel_pitch_um: lens.pixel_pitch_um,
        channels: predictor.channel_names().to_vec(),
        camera: lens.camera.clone(),
        observations,
    };
    let mut set = predict_set(&predictor, &template, predictor.default_model())?;
    for (index, observation) in set.observations.iter_mut().enumerate() {
        for channel in 0..observation.tiles.len() {
            let seed = first_seed + (index * observation.tiles.len() + channel) as u64;
            let (tile, sigma) = with_noise(&observation.tiles[channel], seed)?;
            observation.tiles[channel] = tile;
            observation.noise_sigma[channel] = Some(sigma);
        }
    }
    Ok(set)
}

/// Returns an observation without a file, at a place of a `grid` of point lights, across and down the frame, with empty tiles large enough for
/// its PSFs.
pub(super) fn blank(
    lens: &Predictor,
    place: u32,
    grid: (u32, u32),
    distance: ObjectDistance,
) -> Result<Observation> {
    let frame = lens.frame();
    let share = |k: u32, count: u32| (f64::from(k) + 0.5) / f64::from(count);
    let ideal = ImagePoint::new(
        share(place % grid.0, grid.0) * f64::from(frame.width_px()),
        share(place / grid.0, grid.1) * f64::from(frame.height_px()),
    );
    let vergence = lens.vergence(distance)?;
    let at = frame.field_point(ideal);
    let widest = (0..lens.channel_count())
        .map(|channel| {
            let m = lens.blur_at(channel, at, vergence).blur.moments;
            m.mu20.max(m.mu02).max(0.0).sqrt()
        })
        .fold(0.0, f64::max);
    // Five standard deviations of the widest channel, and room for lateral colour and distortion.
    let side = 2 * (5.0 * widest + 0.01 * frame.half_width_px()).ceil() as usize + 9;
    let dark = Tile::new(side, side, vec![0.0; side * side])?;
    let channels = lens.channel_count();
    Ok(Observation {
        file: String::new(),
        centre: ImagePoint::new(ideal.x_px.floor() + 0.5, ideal.y_px.floor() + 0.5),
        distance,
        ideal: Some(ideal),
        tiles: vec![dark; channels],
        noise_sigma: vec![None; channels],
        background: vec![0.0; channels],
        saturated: false,
        gain: None,
        weight_mask: None,
        measurement: None,
    })
}

/// Returns the tile with Gaussian noise, and the standard deviation of the noise.
fn with_noise(tile: &Tile, seed: u64) -> Result<(Tile, f64)> {
    let peak = tile.samples().iter().copied().fold(0.0, f32::max);
    let sigma = f64::from(peak) / PEAK_OVER_NOISE;
    let noisy = tile
        .samples()
        .iter()
        .enumerate()
        .map(|(index, &light)| (f64::from(light) + sigma * normal(seed, index as u64)) as f32)
        .collect();
    Ok((Tile::new(tile.width(), tile.height(), noisy)?, sigma))
}

//! Simulated measurements for the examples.

use seidel_core::{ImagePoint, Lens, ObjectDistance, Observation, ObservationSet, Result, Tile};
use seidel_optics::predict::predict_set;

/// Side of a PSF tile, px.
const SIDE: usize = 33;

/// Returns the PSFs of `lens` at a grid of `columns` x `rows` point lights over the frame, at three distances: an
/// observation set as a measurement would give it, without noise.
pub(crate) fn measure(lens: &Lens, columns: usize, rows: usize) -> Result<ObservationSet> {
    let profile = lens.profile();
    let channels: Vec<String> = lens.predictor().channel_names().to_vec();
    let (width, height) = (profile.frame.width_px(), profile.frame.height_px());
    let mut places = ObservationSet {
        axis_stated: true,
        pixel_pitch_um: profile.pixel_pitch_um,
        camera: profile.camera.clone(),
        ..ObservationSet::new(profile.frame, channels.clone(), Vec::new())
    };
    // Any light will do for the tiles of the places: `predict_set` draws them anew.
    let mut point = vec![0.0; SIDE * SIDE];
    point[SIDE * SIDE / 2] = 1.0;
    let tile = Tile::new(SIDE, SIDE, point)?;
    for metres in [1.7, 2.0, 2.6] {
        for (column, row) in (0..columns * rows).map(|k| (k % columns, k / columns)) {
            let x = f64::from(width) * (column as f64 + 0.5) / columns as f64;
            let y = f64::from(height) * (row as f64 + 0.5) / rows as f64;
            let label = format!("{metres} m, column {column}, row {row}");
            let (centre, distance) = (ImagePoint::new(x, y), ObjectDistance::metres(metres)?);
            let tiles = vec![tile.clone(); channels.len()];
            places.observations.push(Observation {
                ideal: Some(centre),
                ..Observation::new(label, centre, distance, tiles)
            });
        }
    }
    let model = lens.predictor().default_model();
    predict_set(lens.predictor(), &places, model)
}

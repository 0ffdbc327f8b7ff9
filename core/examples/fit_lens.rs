//! Fits a lens to PSFs drawn from a profile: `cargo run --release -p seidel-core --example fit_lens -- seidel-demo/lens.json`.

use seidel_core::observations::{Observation, ObservationSet};
use seidel_core::predict::predict_set;
use seidel_core::tile::Tile;
use seidel_core::{FitSettings, ImagePoint, Lens, Model, ObjectDistance, fit};

/// Side of a PSF tile, px.
const SIDE: usize = 33;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("give a lens profile, such as seidel-demo/lens.json")?;
    let lens = Lens::from_json(&std::fs::read_to_string(path)?)?;

    // The places of a grid of point lights at three distances; the tiles are drawn below.
    let profile = lens.profile();
    let channels: Vec<String> = lens.predictor().channel_names().to_vec();
    let mut places = ObservationSet {
        frame: profile.frame,
        axis_stated: true,
        pixel_pitch_um: profile.pixel_pitch_um,
        channels: channels.clone(),
        camera: profile.camera.clone(),
        observations: Vec::new(),
    };
    let (width, height) = (profile.frame.width_px(), profile.frame.height_px());
    for metres in [1.7, 2.0, 2.6] {
        for (column, row) in (0..48).map(|k| (k % 8, k / 8)) {
            let x = f64::from(width) * (f64::from(column) + 0.5) / 8.0;
            let y = f64::from(height) * (f64::from(row) + 0.5) / 6.0;
            let mut point = vec![0.0; SIDE * SIDE];
            point[SIDE * SIDE / 2] = 1.0;
            let tile = Tile::new(SIDE, SIDE, point)?;
            places.observations.push(Observation {
                file: format!("{metres} m, column {column}, row {row}"),
                centre: ImagePoint::new(x, y),
                distance: ObjectDistance::metres(metres)?,
                ideal: Some(ImagePoint::new(x, y)),
                tiles: vec![tile; channels.len()],
                noise_sigma: vec![None; channels.len()],
                background: vec![0.0; channels.len()],
                saturated: false,
            });
        }
    }
    let measured = predict_set(lens.predictor(), &places, lens.predictor().default_model())?;

    let settings = FitSettings {
        model: Model::Moments,
        ..FitSettings::default()
    };
    let fitted = fit(&[measured], &settings)?;
    for warning in fitted.warnings() {
        println!("note: {warning}");
    }
    let fitted = Lens::new(fitted.into_lens())?;
    let corner = ImagePoint::new(f64::from(width) * 0.9, f64::from(height) * 0.9);
    let distance = ObjectDistance::metres(2.6)?;
    for channel in &channels {
        let true_blur = lens.blur_at(channel, corner, distance)?.moments;
        let fitted_blur = fitted.blur_at(channel, corner, distance)?.moments;
        println!(
            "{channel}: horizontal variance near the corner {:.2} px², true {:.2} px²",
            fitted_blur.mu20, true_blur.mu20
        );
    }
    Ok(())
}

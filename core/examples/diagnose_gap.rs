//! Diagnoses a lens whose sensor has moved by 30 µm since it was measured:
//! `cargo run --release -p seidel-core --example diagnose_gap -- seidel-demo/lens.json`.

use seidel_core::observations::{Observation, ObservationSet};
use seidel_core::predict::predict_set;
use seidel_core::tile::Tile;
use seidel_core::{
    Controls, DiagnosisSettings, ImagePoint, Lens, ObjectDistance, diagnose, no_progress,
};

/// Side of a PSF tile, px.
const SIDE: usize = 33;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("give a lens profile, such as seidel-demo/lens.json")?;
    let lens = Lens::from_json(&std::fs::read_to_string(path)?)?;
    let moved = lens.with_controls(&Controls {
        sensor_shift_um: Some(30.0),
        ..Controls::default()
    })?;

    let profile = lens.profile();
    let channels: Vec<String> = lens.predictor().channel_names().to_vec();
    let (width, height) = (profile.frame.width_px(), profile.frame.height_px());
    let mut places = ObservationSet {
        frame: profile.frame,
        axis_stated: true,
        pixel_pitch_um: profile.pixel_pitch_um,
        channels: channels.clone(),
        camera: profile.camera.clone(),
        observations: Vec::new(),
    };
    for metres in [1.7, 2.0, 2.6] {
        for (column, row) in (0..24).map(|k| (k % 6, k / 6)) {
            let x = f64::from(width) * (f64::from(column) + 0.5) / 6.0;
            let y = f64::from(height) * (f64::from(row) + 0.5) / 4.0;
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
    let measured = predict_set(
        moved.predictor(),
        &places,
        moved.predictor().default_model(),
    )?;

    let settings = DiagnosisSettings {
        library: ["defocus_offset", "decentre", "vignetting"]
            .map(str::to_owned)
            .to_vec(),
        ..DiagnosisSettings::default()
    };
    let diagnosis = diagnose(&lens, &measured, &settings, &no_progress)?;
    println!(
        "verdict {:?}, added {:?}",
        diagnosis.verdict, diagnosis.added
    );
    println!(
        "gap {:.4} before, {:.4} after",
        diagnosis.gap.before, diagnosis.gap.after
    );
    for cause in &diagnosis.causes {
        println!("{}: probability {:.2}", cause.effect, cause.probability);
    }
    Ok(())
}

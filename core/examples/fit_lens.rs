//! Fits a lens to PSFs drawn from a profile: `cargo run --release -p seidel-core --example fit_lens -- seidel-demo/lens.json`.

mod support;

use seidel_core::{FitSettings, ImagePoint, Lens, Model, ObjectDistance, fit, no_progress};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1);
    let path = path.ok_or("give a lens profile, such as seidel-demo/lens.json")?;
    let lens = Lens::from_json(&std::fs::read_to_string(path)?)?;

    let measured = support::measure(&lens, 8, 6)?;
    let settings = FitSettings {
        model: Model::Moments,
        ..FitSettings::default()
    };
    let fitted = fit(&[measured], &settings, &no_progress)?;
    for warning in fitted.warnings() {
        println!("note: {warning}");
    }
    let fitted = Lens::new(fitted.into_lens())?;

    let frame = lens.profile().frame;
    let corner = ImagePoint::new(
        f64::from(frame.width_px()) * 0.9,
        f64::from(frame.height_px()) * 0.9,
    );
    let distance = ObjectDistance::metres(2.6)?;
    for channel in lens.predictor().channel_names() {
        let true_blur = lens.blur_at(channel, corner, distance)?.moments;
        let fitted_blur = fitted.blur_at(channel, corner, distance)?.moments;
        println!(
            "{channel}: horizontal variance near the corner {:.2} px², true {:.2} px²",
            fitted_blur.mu20, true_blur.mu20
        );
    }
    Ok(())
}

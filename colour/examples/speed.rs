//! How long a 4K picture takes through the project's own config: `cargo run --release -p seidel-colour --example speed`.

use std::time::Instant;

use seidel_colour::{Alphas, Config, Source};

fn main() -> Result<(), seidel_colour::ColourError> {
    let config = Config::load(&Source::Own)?;
    let plane = |k: usize| -> Vec<f32> {
        (0..4096 * 2160)
            .map(|i| ((i * 7919 + k * 104_729) % 9973) as f32 / 9973.0)
            .collect()
    };
    for (from, to) in [
        ("ARRI LogC4", "ACEScg"),
        ("ACEScg", "ARRI LogC4"),
        ("S-Log3 S-Gamut3", "ACEScg"),
        ("ACEScg", "S-Log3 S-Gamut3"),
        ("ACEScg", "Linear Rec.709 (sRGB)"),
    ] {
        let processor = config.processor(from, to)?;
        let mut planes: Vec<Vec<f32>> = (0..3).map(plane).collect();
        let start = Instant::now();
        let report = processor.planes(&mut planes, Alphas::Straight)?;
        println!(
            "{from} to {to}: {:.0} ms, {report:?}",
            start.elapsed().as_secs_f64() * 1e3
        );
    }
    Ok(())
}

//! Times the conversion of a 4096x2160 image through Seidel's own config.
//!
//! Run with `cargo run --release -p seidel-colour --example speed`.

use std::time::Instant;

use seidel_colour::{Alphas, Config, Source};

fn main() -> Result<(), seidel_colour::ColourError> {
    let config = Config::load(&Source::Embedded)?;
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
        let report = processor.convert_planes(&mut planes, Alphas::Straight)?;
        println!(
            "{from} to {to}: {:.0} ms, {report:?}",
            start.elapsed().as_secs_f64() * 1e3
        );
    }
    Ok(())
}

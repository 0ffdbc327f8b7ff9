//! The spaces of the embedded config against golden values from OpenColorIO.

use std::fs;
use std::path::PathBuf;

use seidel_colour::{Alphas, Config, ConversionReport, Source};
use serde_json::Value;

/// Largest allowed difference between two engines, relative to the largest channel of a pixel.
const TOLERANCE: f64 = 2e-6;
/// Below this value, differences count as if relative to it.
const FLOOR: f64 = 1e-3;

/// Reads a file of `luts/golden`.
pub(crate) fn read(name: &str) -> Value {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../luts/golden");
    serde_json::from_str(&fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|v| v.as_f64().unwrap()).collect()
}

fn pixels(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

/// Converts pixels to planes.
fn planes(pixels: &[Vec<f64>]) -> Vec<Vec<f32>> {
    let plane = |k: usize| pixels.iter().map(|p| p[k] as f32).collect();
    (0..3).map(plane).collect()
}

/// Returns the largest difference of `found` from `want`, relative to the largest channel of its pixel.
pub(crate) fn difference(found: &[Vec<f32>], want: &[Vec<f64>]) -> f64 {
    let pixel_difference = |(i, want): (usize, &Vec<f64>)| {
        let size = want.iter().fold(FLOOR, |size, v| v.abs().max(size));
        let channels = want.iter().zip(found);
        let worst = channels.map(|(want, plane)| (f64::from(plane[i]) - want).abs());
        worst.fold(0.0, f64::max) / size
    };
    want.iter()
        .enumerate()
        .map(pixel_difference)
        .fold(0.0, f64::max)
}

#[test]
fn embedded_spaces_match_the_studio_config() {
    let config = Config::load(&Source::Embedded).unwrap();
    let golden = read("acescg.json");
    let mut count = 0;
    for (name, values) in golden["spaces"].as_object().unwrap() {
        // OpenColorIO clamps these two; `curves` tests them.
        if ["CanonLog3 CinemaGamut D55", "Gamma 2.4 Rec.709 - Texture"].contains(&name.as_str()) {
            continue;
        }
        for (from, to, before, after) in [
            (name.as_str(), "ACEScg", "in", "acescg"),
            ("ACEScg", name.as_str(), "light", "out"),
        ] {
            let mut planes = planes(&pixels(&values[before]));
            let processor = config.processor(from, to).unwrap();
            let report = processor
                .convert_planes(&mut planes, Alphas::Straight)
                .unwrap();
            assert_eq!(report, ConversionReport::default());
            let worst = difference(&planes, &pixels(&values[after]));
            assert!(worst <= TOLERANCE, "{from} to {to}: {worst:e}");
        }
        count += 1;
    }
    assert!(count >= 18, "{count}");
}

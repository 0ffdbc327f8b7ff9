//! Stated noise in another unit than the values of the tiles.

use seidel_optics::observations::ObservationSet;

use super::estimates::median_and_scatter;
use super::mistakes::{Change, LEFT, Mistake};

/// Units of values, in full scales: per cent, and codes of 8, 10, 12, 14 and 16 bits.
const FULL_SCALES: [f64; 6] = [100.0, 255.0, 1023.0, 4095.0, 16_383.0, 65_535.0];
/// Relative error of the ratio of measured and stated noise at which it is such a unit, and its largest relative scatter over tiles: light
/// in the rims of tiles differs from one to the next, and a unit does not.
const UNIT_ERROR: f64 = 0.12;
const MAX_SCATTER: f64 = 0.2;
/// Tiles needed.
const MIN_TILES: usize = 6;

/// Returns the mistake that the noise of `set` is stated in codes, or that of codes in shares of full scale; `None` where stated and
/// measured noise differ by no such factor. Light itself needs no unit: tiles are compared at unit sum.
pub(super) fn find(set: &ObservationSet) -> Option<Mistake> {
    let mut ratios = Vec::new();
    for observation in &set.observations {
        for (channel, sigma) in observation.noise_sigma.iter().enumerate() {
            let measured = observation.light(channel).rim_noise();
            if let Some(sigma) = sigma.filter(|s| *s > 0.0 && measured > 0.0) {
                ratios.push(measured / sigma);
            }
        }
    }
    if ratios.len() < MIN_TILES || set.observations.iter().any(|o| o.gain.is_some()) {
        return None;
    }
    let (ratio, scatter) = median_and_scatter(&ratios)?;
    let is_unit = |scale: &f64| (ratio.max(1.0 / ratio) / scale - 1.0).abs() < UNIT_ERROR;
    let scale = FULL_SCALES.into_iter().find(is_unit)?;
    let is_alike = scatter < MAX_SCATTER * ratio;
    is_alike.then(|| match ratio < 1.0 {
        true => mistake(format!("{scale} times too large"), 1.0 / scale),
        false => mistake(format!("{scale} times too small"), scale),
    })
}

/// Returns the mistake of stated noise that `factor` corrects.
fn mistake(amount: String, factor: f64) -> Mistake {
    Mistake {
        id: "noise_scale",
        words: format!(
            "noise_sigma is {amount} for the tiles: it is stated in another unit than their values"
        ),
        remedy: "State noise_sigma in the unit of the samples.".to_owned(),
        largest_share: LEFT,
        change: Change::NoiseScale(factor),
    }
}

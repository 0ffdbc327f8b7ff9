//! Raw photographs of point lights through the built-in lens.

use seidel_core::{LensProfile, ObjectDistance, ObservationSet, Predictor, Result};
use seidel_optics::predict::predict_set;

use super::noise::normal;
use super::observations::blank;

/// Level of black, counts.
pub const BLACK: u16 = 512;
/// Level of clipping, counts.
pub const WHITE: u16 = 16383;
/// Colours of the top-left 2 x 2 pixels.
pub const MOSAIC: &str = "RGGB";
/// Lights across and down the frame.
const GRID: (u32, u32) = (7, 5);
/// Response of the red, green and blue pixels.
const RESPONSES: [f64; 3] = [0.6, 1.0, 0.5];
/// Counts of the brightest green pixel of a light, over the range.
const PEAK_SHARE: f64 = 0.6;
/// Noise of the sensor: counts per electron, and electrons of read noise.
const COUNTS_PER_ELECTRON: f64 = 0.5;
const READ_NOISE: f64 = 4.0;

/// The raw pixels of a photograph, row-major.
pub struct RawPhotograph {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Counts of each pixel.
    pub samples: Vec<u16>,
}

/// Photographs a grid of point lights at a distance of `metres` through `lens`, whose channels are R, G and B, with the photon and read noise
/// of `seed`.
///
/// # Errors
/// A lens without a depth law, and an invalid distance.
pub fn photograph_of_lights(lens: &LensProfile, metres: f64, seed: u64) -> Result<RawPhotograph> {
    let predictor = Predictor::new(lens)?;
    let distance = ObjectDistance::metres(metres)?;
    let lights = (0..GRID.0 * GRID.1)
        .map(|place| blank(&predictor, place, GRID, distance))
        .collect::<Result<_>>()?;
    let places = ObservationSet {
        axis_stated: true,
        ..ObservationSet::new(lens.frame, predictor.channel_names().to_vec(), lights)
    };
    let drawn = predict_set(&predictor, &places, predictor.default_model())?;
    let (width, height) = (lens.frame.width_px(), lens.frame.height_px());
    let mut light = vec![0.0; (width * height) as usize];
    for observation in &drawn.observations {
        let peak = |channel: usize| {
            let samples = observation.tiles[channel].samples().iter();
            f64::from(samples.copied().fold(0.0, f32::max))
        };
        let flux = PEAK_SHARE * f64::from(WHITE - BLACK) / peak(1);
        for (channel, tile) in observation.tiles.iter().enumerate() {
            let first = [
                (observation.centre.x_px, tile.width()),
                (observation.centre.y_px, tile.height()),
            ]
            .map(|(centre, side)| centre as i64 - (side / 2) as i64);
            for (index, sample) in tile.samples().iter().enumerate() {
                let x = first[0] + (index % tile.width()) as i64;
                let y = first[1] + (index / tile.width()) as i64;
                let is_on =
                    (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y);
                if is_on && colour_of(x, y) == channel {
                    light[(y * i64::from(width) + x) as usize] +=
                        flux * RESPONSES[channel] * f64::from(*sample);
                }
            }
        }
    }
    let recorded = light.iter().enumerate().map(|(index, counts)| {
        let electrons = counts / COUNTS_PER_ELECTRON;
        let noise = (electrons + READ_NOISE * READ_NOISE).sqrt() * normal(seed, index as u64);
        let counts = f64::from(BLACK) + COUNTS_PER_ELECTRON * (electrons + noise);
        counts.round().clamp(0.0, f64::from(WHITE)) as u16
    });
    Ok(RawPhotograph {
        width,
        height,
        samples: recorded.collect(),
    })
}

/// Returns the channel of a pixel of [`MOSAIC`].
fn colour_of(x: i64, y: i64) -> usize {
    (x % 2 + y % 2) as usize
}

//! The PSF grid: images of points of light over the frame, each scaled to a peak of 1.

use seidel_core::Rectangle;

use super::task::Outcome;
use crate::host::{Effect, Result};
use crate::lens::{KernelSource, grid_points};
use crate::plate_image::PlateImage;

/// Names of the colour channels of an image.
const COLOURS: [&str; 3] = ["R", "G", "B"];

/// Draws the kernels of the lens over the pixels of `window`, black between them. `vergence_per_m` returns the vergence of
/// a pixel, in 1/m.
///
/// # Errors
/// Those of [`KernelSource::kernel`].
pub(crate) fn draw_psf_grid(
    effect: &Effect,
    lens: &KernelSource,
    result: &PlateImage,
    window: Rectangle,
    vergence_per_m: impl Fn((i32, i32)) -> f64,
) -> Result<Outcome> {
    let colours = COLOURS.len().min(result.channels());
    // All kernels before the first pixel, so that an aborted render leaves the picture as it was.
    let mut points = Vec::new();
    for (x, y) in grid_points(lens.geometry.display) {
        let pixel = (x.floor() as i32, y.floor() as i32);
        let vergence = vergence_per_m(pixel);
        if !(vergence.is_finite() && vergence >= 0.0) {
            continue;
        }
        if effect.is_aborted() {
            return Ok(Outcome::Aborted);
        }
        let kernel = |colour: &&str| {
            let channel = lens.channel_index(colour);
            lens.kernel(channel, (x, y), 1.0 / vergence)
        };
        let kernels = COLOURS[..colours].iter().map(kernel);
        points.push((pixel, kernels.collect::<Result<Vec<_>>>()?));
    }
    for pixel in result.pixels_in(window) {
        for channel in 0..result.channels() {
            result.set(pixel, channel, if channel == 3 { 1.0 } else { 0.0 });
        }
    }
    for (pixel, kernels) in points {
        // One scale for all colours, so that a wider kernel is dimmer.
        let weights = kernels.iter().flat_map(|kernel| &kernel.weights);
        let peak = weights.fold(0.0_f32, |peak, weight| peak.max(*weight));
        for (channel, kernel) in kernels.iter().enumerate() {
            for (k, weight) in kernel.weights.iter().enumerate() {
                let (column, row) = (k % kernel.width, k / kernel.width);
                let target = (
                    pixel.0 + kernel.left + column as i32,
                    pixel.1 + kernel.top + row as i32,
                );
                if window.contains(target.0, target.1) {
                    let before = result.get(target, channel).unwrap_or(0.0);
                    result.set(target, channel, before + weight / peak);
                }
            }
        }
    }
    Ok(Outcome::DONE)
}

//! The PSF grid: images of points of light over the frame, each scaled to a peak of 1.

use seidel_core::Rectangle;

use super::task::Outcome;
use crate::host::{Effect, Result};
use crate::interleaved::Interleaved;
use crate::lens::{KernelRequest, KernelSource, grid_points};
use crate::plate_image::PlateImage;

/// Names of the colour channels of an image.
const COLOURS: [&str; 3] = ["R", "G", "B"];

/// Draws the kernels of the lens over the pixels of `window`, black between them. `vergence_per_m` returns the vergence of
/// a pixel, in 1/m.
///
/// # Errors
/// Those of [`KernelSource::kernels`]; not enough memory.
pub(crate) fn draw_psf_grid(
    effect: &Effect,
    lens: &KernelSource,
    result: &PlateImage,
    window: Rectangle,
    vergence_per_m: impl Fn((i32, i32)) -> f64,
) -> Result<Outcome> {
    let channels = result.channels();
    let colours = COLOURS.len().min(channels);
    let (mut pixels, mut requests) = (Vec::new(), Vec::new());
    for at in grid_points(lens.geometry.display) {
        let pixel = (at.0.floor() as i32, at.1.floor() as i32);
        let vergence = vergence_per_m(pixel);
        if !(vergence.is_finite() && vergence >= 0.0) {
            continue;
        }
        pixels.push(pixel);
        requests.extend(COLOURS[..colours].iter().map(|colour| KernelRequest {
            channel: lens.channel_index(colour),
            at,
            distance_m: 1.0 / vergence,
        }));
    }
    let Some(kernels) = lens.kernels(effect, requests)? else {
        return Ok(Outcome::Aborted);
    };
    let mut grid = Interleaved::new(window, channels, |_, row| {
        // Opaque where there is alpha.
        (row.iter_mut().skip(3).step_by(4)).for_each(|alpha| *alpha = (channels == 4).into());
    })?;
    for (pixel, kernels) in pixels.into_iter().zip(kernels.chunks_exact(colours)) {
        // One scale for all colours, so that a wider kernel is dimmer.
        let weights = kernels.iter().flat_map(|kernel| &kernel.weights);
        let peak = weights.fold(0.0_f32, |peak, weight| peak.max(*weight));
        for (channel, kernel) in kernels.iter().enumerate() {
            for (k, weight) in kernel.weights.iter().enumerate() {
                let (column, row) = (k % kernel.width, k / kernel.width);
                let x = pixel.0 + kernel.left + column as i32;
                let y = pixel.1 + kernel.top + row as i32;
                if let Some(samples) = grid.pixel_mut(x, y) {
                    samples[channel] += weight / peak;
                }
            }
        }
    }
    grid.write_to(result);
    Ok(Outcome::DONE)
}

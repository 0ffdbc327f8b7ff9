//! Predicted kernels on the pixel grid of measured tiles.

use seidel_optics::BlurField;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::predict::Predictor;
use seidel_optics::psf::{LocalBlur, PsfModel, Pupil};

use super::tiles::{PreparedTile, to_unit_sum};

/// Adds the variance of pixel integration to a blur's moments, for kernels sampled at pixel centres. Pupil
/// models integrate over pixels themselves.
pub(crate) fn with_pixel_integration(blur: LocalBlur) -> LocalBlur {
    LocalBlur {
        moments: blur.moments.with_added_variance(PIXEL_VARIANCE_PX2),
        ..blur
    }
}

/// Renders the kernel of `model` for `blur` about the tile's centroid, with unit sum over the square.
pub(crate) fn render_kernel(
    model: &dyn PsfModel,
    blur: &LocalBlur,
    tile: &PreparedTile,
    side: usize,
) -> Vec<f64> {
    let mut kernel = vec![0.0; side * side];
    model.sample(blur, &tile.window(side), &mut kernel);
    let sum: f64 = kernel.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        to_unit_sum(&mut kernel);
    } else {
        // Narrower than the pixel spacing: all light goes to the pixel of the centroid.
        let pixel = |at: f64| at.floor().clamp(0.0, (side - 1) as f64) as usize;
        kernel.fill(0.0);
        kernel[pixel(tile.centroid.1) * side + pixel(tile.centroid.0)] = 1.0;
    }
    kernel
}

/// Renders the kernel that a lens described by its pupil predicts for the tile.
pub(crate) fn predicted_kernel(
    lens: &Predictor,
    channel: usize,
    vergence_per_m: f64,
    tile: &PreparedTile,
    side: usize,
) -> Vec<f64> {
    let blur = lens.blur_at(channel, tile.field, vergence_per_m).blur;
    render_kernel(&Pupil, &with_pixel_integration(blur), tile, side)
}

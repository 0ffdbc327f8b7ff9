//! Kernels that a lens predicts, drawn on the squares of measured tiles.

use seidel_optics::BlurField;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::predict::Predictor;
use seidel_optics::psf::{LocalBlur, PsfModel, Pupil};

use super::tiles::{PlacedTile, to_unit_sum};

/// `blur` as a kernel sampled at pixel centres must have it: its moments gain the pixel's. What is
/// drawn from rays is integrated over pixels by its model.
pub(crate) fn on_pixels(blur: LocalBlur) -> LocalBlur {
    LocalBlur {
        moments: blur.moments.with_added_variance(PIXEL_VARIANCE_PX2),
        ..blur
    }
}

/// The kernel of `model` for `blur` about the tile's centroid, unit sum over the square.
pub(crate) fn draw(
    model: &dyn PsfModel,
    blur: &LocalBlur,
    tile: &PlacedTile,
    side: usize,
) -> Vec<f64> {
    let mut kernel = vec![0.0; side * side];
    model.sample(blur, &tile.window(side), &mut kernel);
    let sum: f64 = kernel.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        to_unit_sum(&mut kernel);
    } else {
        // So narrow that no pixel centre sees it: all light goes to the pixel of the centroid.
        let pixel = |at: f64| at.floor().clamp(0.0, (side - 1) as f64) as usize;
        kernel.fill(0.0);
        kernel[pixel(tile.centroid.1) * side + pixel(tile.centroid.0)] = 1.0;
    }
    kernel
}

/// The kernel that a lens known ray by ray predicts for the tile.
pub(crate) fn kernel_of_lens(
    lens: &Predictor,
    channel: usize,
    vergence_per_m: f64,
    tile: &PlacedTile,
    side: usize,
) -> Vec<f64> {
    let blur = lens.blur_at(channel, tile.field, vergence_per_m).blur;
    draw(&Pupil, &on_pixels(blur), tile, side)
}

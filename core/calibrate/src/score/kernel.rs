//! Predicted kernels on the pixel grid of measured tiles.

use seidel_optics::BlurField;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::predict::Predictor;
use seidel_optics::psf::{LocalBlur, PsfModel, Pupil, SampleGrid};

use super::tiles::{PreparedTile, to_unit_sum};
use crate::least_squares::RegistrationSums;

/// Adds the variance of pixel integration to a blur's moments, for kernels sampled at pixel centres. Pupil
/// models integrate over pixels themselves.
pub(crate) fn with_pixel_integration(blur: LocalBlur) -> LocalBlur {
    LocalBlur {
        moments: blur.moments.with_added_variance(PIXEL_VARIANCE_PX2),
        ..blur
    }
}

/// Renders the kernel of `model` for `blur` about the tile's centroid, with unit sum over the square.
///
/// Where the pixels do not tell the centroid, models of rays are registered: drawn where they fit the tile best, within half a
/// pixel of it. Models by moments are those of the paper, which aligns all kernels by the measured centroid.
pub(crate) fn render_kernel(
    model: &dyn PsfModel,
    blur: &LocalBlur,
    tile: &PreparedTile,
    side: usize,
) -> Vec<f64> {
    if model.needs_rays() && tile.centroid_unknown {
        registered_kernel(model, blur, tile, side)
    } else {
        render_shifted(model, blur, tile, [0.0; 2], side)
    }
}

/// Renders the kernel `shift` px from the tile's centroid.
fn render_shifted(
    model: &dyn PsfModel,
    blur: &LocalBlur,
    tile: &PreparedTile,
    shift: [f64; 2],
    side: usize,
) -> Vec<f64> {
    let centroid = (tile.centroid.0 + shift[0], tile.centroid.1 + shift[1]);
    let window = SampleGrid::for_tile(side, side, centroid.0, centroid.1);
    let mut kernel = vec![0.0; side * side];
    model.sample(blur, &window, &mut kernel);
    let sum: f64 = kernel.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        to_unit_sum(&mut kernel);
    } else {
        // Narrower than the pixel spacing: all light goes to the pixel of the centroid.
        let pixel = |at: f64| at.floor().clamp(0.0, (side - 1) as f64) as usize;
        kernel.fill(0.0);
        kernel[pixel(centroid.1) * side + pixel(centroid.0)] = 1.0;
    }
    kernel
}

/// Largest shift of a registration from the measured centroid, px.
const MAX_SHIFT_PX: f64 = 0.5;
/// Largest number of its Gauss-Newton steps.
const MAX_STEPS: usize = 5;
/// Step of its difference quotients, and the shift below which it ends, px.
const DIFFERENCE_PX: f64 = 0.02;
const END_PX: f64 = 1e-3;

/// Renders the kernel of `model` where it fits the tile best, within half a pixel of the tile's centroid.
///
/// Light within a single pixel has its centroid in the middle of it, wherever it fell.
fn registered_kernel(
    model: &dyn PsfModel,
    blur: &LocalBlur,
    tile: &PreparedTile,
    side: usize,
) -> Vec<f64> {
    let at = |shift| render_shifted(model, blur, tile, shift, side);
    // Samples of other colours of a mosaic are filled in, which would smooth the kernel.
    let counted = tile.counted();
    let error = |kernel: &[f64]| -> f64 {
        let pairs = counted.iter().map(|&k| (tile.measured[k], kernel[k]));
        pairs.map(|(m, k)| (m - k).powi(2)).sum()
    };
    let mut shift = [0.0; 2];
    let mut kernel = at(shift);
    let mut least = error(&kernel);
    for _ in 0..MAX_STEPS {
        let along_x = at([shift[0] + DIFFERENCE_PX, shift[1]]);
        let along_y = at([shift[0], shift[1] + DIFFERENCE_PX]);
        let mut sums = RegistrationSums::default();
        for &k in counted.iter() {
            let value = kernel[k];
            let slopes = [&along_x, &along_y].map(|moved| (moved[k] - value) / DIFFERENCE_PX);
            sums.add(tile.measured[k] - value, slopes);
        }
        let Some(step) = sums.step() else {
            break;
        };
        let moved = [0, 1].map(|k| (shift[k] + step[k]).clamp(-MAX_SHIFT_PX, MAX_SHIFT_PX));
        let candidate = at(moved);
        let left = error(&candidate);
        if left >= least {
            break;
        }
        let travelled = (moved[0] - shift[0]).hypot(moved[1] - shift[1]);
        (shift, kernel, least) = (moved, candidate, left);
        if travelled < END_PX {
            break;
        }
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

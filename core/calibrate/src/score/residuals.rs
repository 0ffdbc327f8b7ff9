//! Residuals of the pixels of a set against a lens, for estimates of their noise.

use rayon::prelude::*;

use super::{predicted_kernel, prepare_tiles};
use crate::measure::measure;
use seidel_optics::error::Result;
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::LensProfile;

/// Residual of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelResidual {
    /// Predicted signal, in the units of the tile.
    pub signal: f64,
    /// Largest predicted signal of the tile.
    pub peak: f64,
    /// Observed less predicted signal.
    pub residual: f64,
    /// Standard deviation of a dark pixel, where known.
    pub sigma: f64,
}

/// Returns the residuals of every counted pixel of `set` above its noise, each tile scaled to its own light and placed where
/// it fits best.
///
/// # Errors
/// A channel or distance that `lens` does not have.
pub fn pixel_residuals(lens: &LensProfile, set: &ObservationSet) -> Result<Vec<PixelResidual>> {
    let predictor = Predictor::new(lens)?;
    let measured = measure(std::slice::from_ref(set), Support::Auto, &mut Vec::new());
    let mut all = Vec::new();
    for (channel, name) in set.channels.iter().enumerate() {
        let of_lens = predictor.channel_index(name)?;
        for distance in set.distances() {
            let tiles: Vec<_> = (measured.iter())
                .filter(|t| t.channel == channel && t.distance == distance)
                .collect();
            let vergence = predictor.vergence(distance)?;
            let sets = std::slice::from_ref(set);
            let (side, prepared) = prepare_tiles(sets, &tiles, &lens.frame, Support::Auto);
            let of_tiles: Vec<Vec<PixelResidual>> = (prepared.par_iter())
                .zip(&tiles)
                .map(|(tile, measured)| {
                    let kernel = predicted_kernel(&predictor, of_lens, vergence, tile, side);
                    let counted = tile.counted();
                    let product: f64 = (counted.iter())
                        .map(|&k| tile.measured[k] * kernel[k])
                        .sum();
                    let power: f64 = counted.iter().map(|&k| kernel[k] * kernel[k]).sum();
                    let share = product / power.max(f64::MIN_POSITIVE);
                    let scale = tile.total;
                    let peak = kernel.iter().copied().fold(0.0, f64::max) * share * scale;
                    let sigma = set.observations[measured.observation].noise_sigma[channel];
                    let of_pixel = |&k: &usize| PixelResidual {
                        signal: share * kernel[k] * scale,
                        peak,
                        residual: (tile.measured[k] - share * kernel[k]) * scale,
                        sigma: sigma.unwrap_or(0.0),
                    };
                    counted.iter().map(of_pixel).collect()
                })
                .collect();
            all.extend(of_tiles.into_iter().flatten());
        }
    }
    Ok(all)
}

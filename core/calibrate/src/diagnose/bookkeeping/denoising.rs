//! Tiles whose noise was blurred with them: by a filter against noise, or by resampling. Optics blur light and leave noise as it is.

use seidel_optics::numeric::{dot, median};
use seidel_optics::tile::Tile;

use super::super::tiles::TileData;
use super::sharpening::blurred;

/// Blurs tried, px.
const BLURS_PX: [f64; 7] = [0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.25];
/// Largest variance of the finest detail in the dark parts of tiles, over that of the stated noise: white noise has 1.
const MAX_FINE_NOISE: f64 = 0.3;
/// Variances of coarse detail, in the same unit, that are blurred noise: less is none, and more is light.
const COARSE_NOISE: std::ops::RangeInclusive<f64> = 0.02..=1.0;
/// Lags of fine and of coarse detail, px.
const FINE_PX: usize = 1;
const COARSE_PX: usize = 4;
/// Light up to which a pixel is dark, over the peak of the prediction.
const DARK: f64 = 0.02;
/// Differences needed in a tile, and tiles needed.
const MIN_DIFFERENCES: usize = 20;
const MIN_TILES: usize = 6;
/// Median of the absolute value of a normal deviate.
const NORMAL_MEDIAN: f64 = 0.674_49;
/// Steps of Van Cittert's iteration that takes the blur off; more of them amplify what is left of noise.
const STEPS: usize = 6;

/// Returns the standard deviation of the blur of light and noise, px, that describes the tiles best; `None` where noise is not stated, or
/// as stated. `pairs` are tiles with their predictions, both of unit sum.
pub(super) fn find<'a>(
    pairs: impl Iterator<Item = (&'a TileData, &'a [f64])> + Clone,
) -> Option<f64> {
    let of_lag = |lag| {
        let each = pairs.clone();
        let mut each: Vec<f64> = each.filter_map(|(t, p)| noise(t, p, lag)).collect();
        (each.len() >= MIN_TILES).then(|| median(&mut each))
    };
    let (fine, coarse) = (of_lag(FINE_PX)?, of_lag(COARSE_PX)?);
    if fine > MAX_FINE_NOISE || fine > coarse / 2.0 || !COARSE_NOISE.contains(&coarse) {
        return None;
    }
    let with_blur = |sigma_px: f64| {
        let terms = pairs.clone().map(|(tile, predicted)| {
            let soft = blurred(predicted, tile.size.0, tile.size.1, sigma_px);
            let residual = tile.residual(&soft);
            dot(&residual, &residual) / tile.norm
        });
        (terms.sum::<f64>(), sigma_px)
    };
    let best = BLURS_PX.into_iter().map(with_blur);
    let (_, sigma_px) = best.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(sigma_px)
}

/// Returns the variance of the mixed second difference of that lag over dark pixels of a tile, over that of its stated noise; `None` with
/// few such pixels or without noise.
fn noise(tile: &TileData, predicted: &[f64], lag: usize) -> Option<f64> {
    let (width, height) = tile.size;
    if tile.sigma <= 0.0 || !tile.counts.is_empty() || width.min(height) <= lag {
        return None;
    }
    let peak = predicted.iter().copied().fold(0.0, f64::max);
    let mut differences = Vec::new();
    for y in 0..height - lag {
        for x in 0..width - lag {
            let at = y * width + x;
            let below = at + lag * width;
            let cell = [at, at + lag, below, below + lag];
            if cell.iter().all(|k| predicted[*k] < DARK * peak) {
                let [a, b, c, d] = cell.map(|k| tile.light[k]);
                differences.push(((a - b - c + d) / 2.0).abs());
            }
        }
    }
    (differences.len() >= MIN_DIFFERENCES).then(|| {
        let sigma = median(&mut differences) / NORMAL_MEDIAN;
        (sigma / tile.sigma).powi(2)
    })
}

/// Returns `tile` without a Gaussian blur, by Van Cittert's iteration.
pub(super) fn undone(tile: &Tile, sigma_px: f64) -> Option<Tile> {
    let (width, height) = (tile.width(), tile.height());
    let stored: Vec<f64> = tile.samples().iter().map(|v| f64::from(*v)).collect();
    let mut light = stored.clone();
    for _ in 0..STEPS {
        let soft = blurred(&light, width, height, sigma_px);
        for ((light, stored), soft) in light.iter_mut().zip(&stored).zip(soft) {
            *light += stored - soft;
        }
    }
    let samples = light.into_iter().map(|v| v as f32).collect();
    Tile::new(width, height, samples).ok()
}

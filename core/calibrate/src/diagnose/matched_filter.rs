//! The place of noisy tiles without ideal position: where the predicted PSF matches their pixels best (matched filter).
//!
//! Pixel noise of standard deviation s moves the centroid of a tile of n pixels by s (sum of (x - c)²)^½ along an axis. That can be wider
//! than the PSF, and steps along gradients do not lead back from there.

use rayon::prelude::*;
use seidel_optics::numeric::dot;
use seidel_optics::psf::pupil::Detail;

use super::gap_problem::weight;
use super::hypothesis::Hypothesis;
use super::jitter::Group;
use super::prediction::TilePredictor;
use super::registration::Registration;
use super::tiles::TileData;

/// Error of a centroid from which on its tile is searched, px. Smaller ones are found along gradients.
const LEAST_ERROR_PX: f64 = 0.25;
/// Distance searched to each side, in standard errors of the centroid, and at most, px.
const REACH_SIGMAS: f64 = 4.0;
const LARGEST_REACH_PX: f64 = 8.0;

/// A tile with its prediction, row-major.
struct Pictures<'a> {
    observed: &'a [f64],
    predicted: Vec<f64>,
    width: usize,
    /// Weight over the squared norm of the light.
    weight: f64,
}

/// Moves each group of tiles whose centroids are lost in noise by the whole pixels by which `hypothesis` at `theta` matches it best.
pub(super) fn place(hypothesis: &Hypothesis, theta: &[f64], tiles: &mut [TileData]) {
    tiles
        .par_chunk_by_mut(|a, b| Group::of(a) == Group::of(b))
        .for_each(|group| {
            let Some(reach) = reach_px(group) else {
                return;
            };
            let mut predictor = TilePredictor::default();
            let pictures = group.iter().map(|tile| {
                let mut predicted = Vec::new();
                let values = hypothesis.values(theta, tile.of_lens);
                predictor.predict(hypothesis, &values, tile, Detail::DRAFT, &mut predicted);
                Pictures {
                    observed: &tile.light,
                    predicted,
                    width: tile.size.0,
                    weight: weight(tile) / tile.norm,
                }
            });
            let [x, y] = best_shift(&pictures.collect::<Vec<_>>(), reach);
            for tile in group {
                tile.corner.0 -= x as f64;
                tile.corner.1 -= y as f64;
            }
        });
}

/// Returns how far the tiles of a group may lie from their centroid, px; `None` where noise moves it by little.
fn reach_px(group: &[TileData]) -> Option<i64> {
    let is_placed_by_centroid =
        |tile: &&TileData| !matches!(tile.registration, Registration::Ideal);
    let placed = group.iter().filter(is_placed_by_centroid);
    let error = placed.map(centroid_error_px).fold(0.0, f64::max);
    let sides = group.iter().map(|tile| tile.size.0.min(tile.size.1));
    let room = sides.min().unwrap_or(0) as f64 / 3.0;
    let reach = (REACH_SIGMAS * error).min(LARGEST_REACH_PX).min(room);
    (error > LEAST_ERROR_PX).then_some(reach.ceil() as i64)
}

/// Returns the standard error of the centroid of `tile` by pixel noise along either axis, px.
fn centroid_error_px(tile: &TileData) -> f64 {
    let side = tile.size.0.max(tile.size.1) as f64;
    tile.sigma * (tile.valid_pixels() as f64 * side * side / 12.0).sqrt()
}

/// Returns the shift in whole pixels, at most `reach` along each axis, by which the predictions match the observed tiles best: with fluxes
/// free, that of the largest sum of squared correlations.
fn best_shift(pictures: &[Pictures], reach: i64) -> [i64; 2] {
    let shifts = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    let match_at = |shift: [i64; 2]| -> f64 {
        let each = pictures.iter().map(|tile| tile.match_at(shift));
        each.sum()
    };
    let scored = shifts.map(|shift| (match_at(shift), shift));
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or([0, 0], |(_, shift)| shift)
}

impl Pictures<'_> {
    /// Returns the energy of the tile that the prediction, moved by `shift`, explains.
    fn match_at(&self, [x, y]: [i64; 2]) -> f64 {
        let (width, height) = (self.width as i64, (self.observed.len() / self.width) as i64);
        let rows = y.max(0)..height.min(height + y);
        let (start, end) = (x.max(0), width.min(width + x));
        let product: f64 = rows
            .map(|row| {
                let at = |first: i64, row: i64| (row * width + first) as usize;
                let count = (end - start) as usize;
                let observed = &self.observed[at(start, row)..][..count];
                let predicted = &self.predicted[at(start - x, row - y)..][..count];
                dot(observed, predicted)
            })
            .sum();
        let norm: f64 = self.predicted.iter().map(|p| p * p).sum();
        self.weight * product.max(0.0).powi(2) / norm.max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    const SIDE: usize = 33;

    /// Returns a Gaussian of unit sum and a standard deviation of 1.2 px, `x` and `y` px from the middle.
    fn spot(x: f64, y: f64) -> Vec<f64> {
        let at = |k: usize| {
            let (u, v) = ((k % SIDE) as f64 - 16.0 - x, (k / SIDE) as f64 - 16.0 - y);
            (-(u * u + v * v) / (2.0 * 1.44)).exp() / (std::f64::consts::TAU * 1.44)
        };
        (0..SIDE * SIDE).map(at).collect()
    }

    #[test]
    fn a_spot_whose_centroid_is_lost_in_noise_is_found() {
        let mut random = SplitMix64::new(9);
        for (x, y) in [(3.0, -2.0), (-5.0, 4.0), (0.0, 0.0)] {
            // Even noise of a twentieth of the peak: the centroid moves by 1.7 px.
            let mut observed = spot(x, y);
            observed
                .iter_mut()
                .for_each(|v| *v += 0.0055 * 12.0_f64.sqrt() * (random.unit() - 0.5));
            let pictures = Pictures {
                observed: &observed,
                predicted: spot(0.0, 0.0),
                width: SIDE,
                weight: 1.0,
            };
            assert_eq!(best_shift(&[pictures], 6), [x as i64, y as i64]);
        }
    }
}

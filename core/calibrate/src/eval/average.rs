//! Average PSF of a group of tiles: the space-invariant baseline of the paper.

use rayon::prelude::*;

use super::spline::Spline;
use crate::score::{PreparedTile, to_unit_sum};

/// Number of shifted tiles in memory at a time.
const CHUNK: usize = 64;

/// Average of all tiles of a group, with and without alignment of centroids.
pub(super) struct Averages {
    /// Average with the centroid at the square's centre, unit sum.
    aligned: Spline,
    /// Average without alignment, unit sum.
    unaligned: Vec<f64>,
}

impl Averages {
    /// Averages `tiles`, on squares of `side` px.
    pub(super) fn of(tiles: &[PreparedTile], side: usize) -> Self {
        let mut aligned = vec![0.0; side * side];
        let mut unaligned = vec![0.0; side * side];
        for chunk in tiles.chunks(CHUNK) {
            let shifted: Vec<Vec<f64>> = chunk
                .par_iter()
                .map(|tile| {
                    let (dx, dy) = tile.off_centre(side);
                    Spline::through(&tile.measured, side).shifted(-dx, -dy)
                })
                .collect();
            // Summed in order, so that the result does not depend on the number of threads.
            for (tile, shifted) in chunk.iter().zip(&shifted) {
                add(&mut aligned, shifted);
                add(&mut unaligned, &tile.measured);
            }
        }
        to_unit_sum(&mut aligned);
        to_unit_sum(&mut unaligned);
        Self {
            aligned: Spline::through(&aligned, side),
            unaligned,
        }
    }

    /// Returns the aligned average, shifted to the centroid of `tile`.
    pub(super) fn aligned_to(&self, tile: &PreparedTile, side: usize) -> Vec<f64> {
        let (dx, dy) = tile.off_centre(side);
        let mut kernel = self.aligned.shifted(dx, dy);
        to_unit_sum(&mut kernel);
        kernel
    }

    /// Returns the average without alignment.
    pub(super) fn unaligned(&self) -> &[f64] {
        &self.unaligned
    }
}

fn add(sum: &mut [f64], image: &[f64]) {
    for (s, v) in sum.iter_mut().zip(image) {
        *s += v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::field::FieldPoint;
    use seidel_optics::moments::CentralMoments;

    const SIDE: usize = 25;

    /// A Gaussian spot of 2 px standard deviation at (`x`, `y`) in square coordinates.
    fn spot(x: f64, y: f64) -> PreparedTile {
        let mut truth: Vec<f64> = (0..SIDE * SIDE)
            .map(|k| {
                let dx = (k % SIDE) as f64 + 0.5 - x;
                let dy = (k / SIDE) as f64 + 0.5 - y;
                (-(dx * dx + dy * dy) / 8.0).exp()
            })
            .collect();
        to_unit_sum(&mut truth);
        PreparedTile {
            field: FieldPoint::new(0.0, 0.0),
            moments: CentralMoments::default(),
            centroid: (x, y),
            measured: truth,
            centroid_unknown: false,
            total: 1.0,
            noise_power: 0.0,
            gaps: None,
        }
    }

    #[test]
    fn aligned_tiles_of_one_shape_average_to_that_shape() {
        let tiles = [spot(12.3, 12.9), spot(11.6, 12.1), spot(13.2, 12.5)];
        let averages = Averages::of(&tiles, SIDE);
        for tile in &tiles {
            let kernel = averages.aligned_to(tile, SIDE);
            let worst = kernel
                .iter()
                .zip(&tile.measured)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            // A quarter of a per cent of the peak: the error of two cubic-spline shifts of so small a spot.
            assert!(worst < 1e-4, "{worst}");
            assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_unaligned_average_is_the_plain_mean() {
        let tiles = [spot(11.0, 12.5), spot(14.0, 12.5)];
        let averages = Averages::of(&tiles, SIDE);
        for (k, value) in averages.unaligned().iter().enumerate() {
            let want = (tiles[0].measured[k] + tiles[1].measured[k]) / 2.0;
            assert!((value - want).abs() < 1e-15);
        }
    }
}

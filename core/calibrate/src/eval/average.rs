//! The average PSF of a data set: the paper's baseline, one blur for the whole field.

use rayon::prelude::*;

use super::spline::Spline;
use crate::score::{PlacedTile, to_unit_sum};

/// How many shifted tiles are held in memory at a time.
const CHUNK: usize = 64;

/// The average of all tiles of a group, with and without bringing them to a common centroid.
pub(super) struct Averages {
    /// Unit sum, centroid on the square's centre pixel.
    aligned: Spline,
    /// Unit sum.
    unaligned: Vec<f64>,
}

impl Averages {
    /// Of `tiles`, which lie in squares of `side` px.
    pub(super) fn of(tiles: &[PlacedTile], side: usize) -> Self {
        let mut aligned = vec![0.0; side * side];
        let mut unaligned = vec![0.0; side * side];
        for chunk in tiles.chunks(CHUNK) {
            let shifted: Vec<Vec<f64>> = chunk
                .par_iter()
                .map(|tile| {
                    let (dx, dy) = tile.off_centre(side);
                    Spline::through(&tile.truth, side).shifted(-dx, -dy)
                })
                .collect();
            // Summed in order, so that the result does not depend on the number of threads.
            for (tile, shifted) in chunk.iter().zip(&shifted) {
                add(&mut aligned, shifted);
                add(&mut unaligned, &tile.truth);
            }
        }
        to_unit_sum(&mut aligned);
        to_unit_sum(&mut unaligned);
        Self {
            aligned: Spline::through(&aligned, side),
            unaligned,
        }
    }

    /// The mean of the tiles moved to a common centroid, moved on to the centroid of `tile`.
    pub(super) fn aligned_to(&self, tile: &PlacedTile, side: usize) -> Vec<f64> {
        let (dx, dy) = tile.off_centre(side);
        let mut kernel = self.aligned.shifted(dx, dy);
        to_unit_sum(&mut kernel);
        kernel
    }

    /// The plain mean of the tiles as they lie.
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

    /// A round spot of 2 px standard deviation at (`x`, `y`) in square coordinates.
    fn spot(x: f64, y: f64) -> PlacedTile {
        let mut truth: Vec<f64> = (0..SIDE * SIDE)
            .map(|k| {
                let dx = (k % SIDE) as f64 + 0.5 - x;
                let dy = (k / SIDE) as f64 + 0.5 - y;
                (-(dx * dx + dy * dy) / 8.0).exp()
            })
            .collect();
        to_unit_sum(&mut truth);
        PlacedTile {
            field: FieldPoint::new(0.0, 0.0),
            plain: CentralMoments::default(),
            centroid: (x, y),
            truth,
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
                .zip(&tile.truth)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            // A quarter of a per cent of the peak: what two cubic splines make of so small a spot.
            assert!(worst < 1e-4, "{worst}");
            assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_unaligned_average_is_the_plain_mean() {
        let tiles = [spot(11.0, 12.5), spot(14.0, 12.5)];
        let averages = Averages::of(&tiles, SIDE);
        for (k, value) in averages.unaligned().iter().enumerate() {
            let want = (tiles[0].truth[k] + tiles[1].truth[k]) / 2.0;
            assert!((value - want).abs() < 1e-15);
        }
    }
}

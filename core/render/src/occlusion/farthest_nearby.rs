//! The farthest surface of a plate within the reach of blur, by blocks.

use super::depth_layers::DepthLayers;
use super::layered_plate::LayeredPlate;
use rayon::prelude::*;

/// Side of a block, px.
const BLOCK_PX: usize = 32;

/// The farthest surface of a plate within the reach of blur, by blocks.
pub(super) struct FarthestNearby {
    columns: usize,
    /// Layer coordinates, row-major.
    coordinates: Vec<f32>,
}

impl FarthestNearby {
    /// Finds the farthest surface of `input` about each block.
    pub(super) fn new(input: &LayeredPlate, layers: &DepthLayers) -> Self {
        let sizes = input.coordinates.par_iter().map(|at| layers.size(*at));
        // Twice the radius of an even disc of the same size, as for estimated samples.
        let reach_px = 2.0 * sizes.reduce(|| 0.0, f32::max);
        let reach = (reach_px / BLOCK_PX as f32).ceil() as usize + 1;
        let columns = input.width.div_ceil(BLOCK_PX);
        let rows = input.height.div_ceil(BLOCK_PX);
        let mut own = vec![f32::INFINITY; columns * rows];
        for (row, line) in input.coordinates.chunks_exact(input.width).enumerate() {
            for (column, block) in line.chunks(BLOCK_PX).enumerate() {
                let own = &mut own[row / BLOCK_PX * columns + column];
                *own = block.iter().fold(*own, |a, b| a.min(*b));
            }
        }
        let along_rows: Vec<f32> = own
            .chunks_exact(columns)
            .flat_map(|line| spread(line.iter().copied(), reach))
            .collect();
        let mut coordinates = vec![0.0; columns * rows];
        for column in 0..columns {
            let line = along_rows.iter().skip(column).step_by(columns).copied();
            for (row, found) in spread(line, reach).into_iter().enumerate() {
                coordinates[row * columns + column] = found;
            }
        }
        Self {
            columns,
            coordinates,
        }
    }

    /// Returns the layer coordinate of the farthest surface about a pixel.
    pub(super) fn at(&self, column: usize, row: usize) -> f32 {
        self.coordinates[row / BLOCK_PX * self.columns + column / BLOCK_PX]
    }
}

/// Returns the least of the `values` up to `reach` places before and after each.
fn spread(values: impl Iterator<Item = f32>, reach: usize) -> Vec<f32> {
    let values: Vec<f32> = values.collect();
    let about = |index: usize| {
        let end = (index + reach + 1).min(values.len());
        let nearby = values[index.saturating_sub(reach)..end].iter();
        nearby.fold(f32::INFINITY, |a, b| a.min(*b))
    };
    (0..values.len()).map(about).collect()
}

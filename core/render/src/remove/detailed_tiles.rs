//! The tiles of a plate that say most about its blur.

use super::gradient::{LinkedPlane, sampled_norms};
use super::winsorised::WinsorisedStatistics;
use crate::{Plane, RenderWindow, Scene, kernel_reach};
use rayon::prelude::*;

/// Returns the tiles of a `plane`, `side` pixels wide or as wide as the plane, in descending order of the product of detail and kernel
/// size.
pub(super) fn detailed_tiles(scene: &Scene, plane: &Plane, side: usize) -> Vec<RenderWindow> {
    let starts = |size: usize| {
        let count = size.div_ceil(side).max(1);
        let last = size.saturating_sub(side);
        (0..count).map(move |k| if count > 1 { last * k / (count - 1) } else { 0 })
    };
    let mut tiles: Vec<(f64, RenderWindow)> = starts(scene.height)
        .flat_map(|row| starts(scene.width).map(move |column| (column, row)))
        .map(|(column, row)| {
            let tile = RenderWindow {
                column,
                row,
                width: side.min(scene.width),
                height: side.min(scene.height),
            };
            (0.0, tile)
        })
        .collect();
    tiles.par_iter_mut().for_each(|(score, tile)| {
        let samples = tile.cut(scene.width, plane.samples);
        let gradients = sampled_norms(LinkedPlane::plain(&samples, tile.width));
        let detail = WinsorisedStatistics::new(gradients).root_mean_square;
        let centre = (tile.row + tile.height / 2) * scene.width + tile.column + tile.width / 2;
        let reach = kernel_reach(scene, *tile, scene.vergence_at(centre));
        *score = detail * reach.right_px.max(reach.up_px);
    });
    tiles.sort_by(|a, b| b.0.total_cmp(&a.0));
    tiles.into_iter().map(|(_, tile)| tile).collect()
}

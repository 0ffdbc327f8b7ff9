//! Pruning of a plan to a window of the plate.
//!
//! The plan stays that of the whole plate, so the tiles of a window equal those of the whole to the bit.

use super::image::Size;
use super::plan::{Level, tiles_covering, tiles_upsampled_from};
use super::tile_grid::{GridIndex, TileGrid};
use crate::scatter::fold;
use crate::{Edges, RenderWindow};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

type Tiles = BTreeSet<GridIndex>;

/// Keeps those tiles of `levels`, finest first, that contribute light to `window`.
///
/// Light beyond the `edges` of the plate of `size` is folded back at `fold_level`.
pub(super) fn prune_to_window(
    levels: &mut [Level],
    fold_level: usize,
    size: Size,
    edges: Edges,
    window: RenderWindow,
) {
    let Some(first) = levels.first() else {
        return;
    };
    let columns = window.column as i32..(window.column + window.width) as i32;
    let rows = window.row as i32..(window.row + window.height) as i32;
    let mut needed = tiles_covering(&first.grid, &columns, &rows);
    for index in 0..levels.len() {
        let above = levels.get(index + 1).map(|level| level.grid);
        let level = &mut levels[index];
        let targets = |tile: GridIndex| folded_tiles(&level.grid, tile, size, edges);
        let keep = |tile: &GridIndex| {
            if index == fold_level {
                targets(*tile).iter().any(|target| needed.contains(target))
            } else {
                needed.contains(tile)
            }
        };
        level.gathered.retain(keep);
        level.upsampled.retain(keep);
        let Some(above) = above else {
            return;
        };
        let sources = level
            .upsampled
            .iter()
            .flat_map(|tile| tiles_upsampled_from(&level.grid, *tile, &above));
        needed = if index < fold_level {
            // Upsampling reads the mirror of the plate, not what lies beyond it.
            sources
                .flat_map(|tile| folded_tiles(&above, tile, size, edges))
                .collect()
        } else {
            sources.collect()
        };
    }
}

/// Returns the tiles of the plate that receive a tile's light once it is folded back; the tile itself where nothing
/// folds.
fn folded_tiles(grid: &TileGrid, tile: GridIndex, size: Size, edges: Edges) -> Tiles {
    let span = |at: i32, size: usize| -> RangeInclusive<i32> {
        let side = grid.tile as i32;
        let on_level = (size >> grid.level).max(1);
        let lands = (at * side..(at + 1) * side).filter_map(|x| fold(x, on_level, edges));
        let ends = lands.fold(None, |ends: Option<(usize, usize)>, x| {
            Some(ends.map_or((x, x), |(low, high)| (low.min(x), high.max(x))))
        });
        ends.map_or(at..=at, |(low, high)| {
            low as i32 / side..=high as i32 / side
        })
    };
    let columns = span(tile.column, size.width);
    span(tile.row, size.height)
        .flat_map(|y| columns.clone().map(move |x| GridIndex::new(y, x)))
        .collect()
}

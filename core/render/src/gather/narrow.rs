//! Leaving out of a plan what a window of the plate does not need.
//!
//! The plan is made for the whole plate, so that a window's tiles are made as the whole's are, to the bit.

use super::grid::Grid;
use super::plan::{Level, tiles_about, tiles_below};
use crate::scatter::fold;
use crate::{Edges, RenderWindow};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

type Tiles = BTreeSet<(i32, i32)>;

/// Keeps of `levels`, the finest first, the tiles that light in `window` comes through, on a plate of `size` whose
/// light beyond its `edges` is folded back at level `folded`.
pub(super) fn narrow(
    levels: &mut [Level],
    folded: usize,
    (size, edges): ((usize, usize), Edges),
    window: RenderWindow,
) {
    let Some(first) = levels.first() else {
        return;
    };
    let columns = window.column as i32..(window.column + window.width) as i32;
    let rows = window.row as i32..(window.row + window.height) as i32;
    let mut needed = tiles_about(&first.grid, &(columns, rows));
    for index in 0..levels.len() {
        let above = levels.get(index + 1).map(|level| level.grid);
        let level = &mut levels[index];
        let home = |place: (i32, i32)| home(&level.grid, place, size, edges);
        let keep = |place: &(i32, i32)| {
            if index == folded {
                home(*place).iter().any(|tile| needed.contains(tile))
            } else {
                needed.contains(place)
            }
        };
        level.gathered.retain(keep);
        level.doubled.retain(keep);
        let Some(above) = above else {
            return;
        };
        let seen = level
            .doubled
            .iter()
            .flat_map(|place| tiles_below(&level.grid, *place, &above));
        needed = if index < folded {
            // Doubling sees the mirror of the plate, not what lies beyond it.
            seen.flat_map(|place| self::home(&above, place, size, edges))
                .collect()
        } else {
            seen.collect()
        };
    }
}

/// The tiles of the plate on which a tile's light lands once it is folded back; itself at least where there is
/// no folding.
fn home(grid: &Grid, (row, column): (i32, i32), size: (usize, usize), edges: Edges) -> Tiles {
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
    let columns = span(column, size.0);
    span(row, size.1)
        .flat_map(|y| columns.clone().map(move |x| (y, x)))
        .collect()
}

//! The plan of a render: which tiles are gathered at which pyramid level.
//!
//! From the finest level up, tiles whose blur is wide enough are upsampled from the next coarser level; the others
//! are gathered where they are needed.

use super::fir::ROWS;
use super::image::{Size, View};
use super::lens_probe::TileSides;
use super::pyramid::MARGIN;
use super::tile_grid::{GridIndex, TileGrid};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The work at one pyramid level.
pub(super) struct Level {
    pub(super) grid: TileGrid,
    /// Tiles to gather at this level.
    pub(super) gathered: BTreeSet<GridIndex>,
    /// Tiles to upsample from the next coarser level.
    pub(super) upsampled: BTreeSet<GridIndex>,
}

/// A rectangle of tiles.
#[derive(Clone)]
pub(super) struct TileExtent {
    pub(super) rows: Range<i32>,
    pub(super) columns: Range<i32>,
}

impl Level {
    /// Returns the smallest rectangle of tiles that holds all work of this level.
    pub(super) fn extent(&self) -> TileExtent {
        let mut all = self.gathered.iter().chain(&self.upsampled);
        let Some(first) = all.next() else {
            return TileExtent {
                rows: 0..0,
                columns: 0..0,
            };
        };
        let first = TileExtent {
            rows: first.row..first.row + 1,
            columns: first.column..first.column + 1,
        };
        all.fold(first, |extent, tile| TileExtent {
            rows: extent.rows.start.min(tile.row)..extent.rows.end.max(tile.row + 1),
            columns: extent.columns.start.min(tile.column)..extent.columns.end.max(tile.column + 1),
        })
    }
}

/// The inputs of a plan.
pub(super) struct PlanInputs<'a> {
    /// Size of the plate.
    pub(super) size: Size,
    /// Largest tiles allowed.
    pub(super) sides: &'a TileSides,
    /// Smallest side of a tile, pixels of its level.
    pub(super) min_tile: usize,
    /// Plate columns to render; they may lie beyond the plate.
    pub(super) columns: Range<i32>,
    /// Plate rows to render; they may lie beyond the plate.
    pub(super) rows: Range<i32>,
    /// Upper bound of how far light travels, px.
    pub(super) reach: i32,
    /// Smallest standard deviation of the blur at a plate point, px.
    pub(super) sigma: &'a dyn Fn((f64, f64)) -> f64,
    /// Smallest standard deviation drawn at a level, pixels of the level.
    pub(super) min_sigma: f64,
    /// Blocks of the plate that hold light.
    pub(super) lit: &'a LitBlocks,
}

/// Plans the work of all levels, finest first.
pub(super) fn plan(inputs: &PlanInputs) -> Vec<Level> {
    let mut sigmas = BTreeMap::new();
    let mut levels = Vec::new();
    let grid_of = |level: u32| {
        let tile = tile_within(inputs.sides.at(level) >> level);
        TileGrid::new(level, tile.max(inputs.min_tile), inputs.size)
    };
    let mut needed = tiles_covering(&grid_of(0), &inputs.columns, &inputs.rows);
    loop {
        let grid = grid_of(levels.len() as u32);
        needed.retain(|tile| {
            let (columns, rows) = (grid.plate_columns(*tile), grid.plate_rows(*tile));
            inputs.lit.any_near(&columns, &rows, inputs.reach)
        });
        if needed.is_empty() {
            return levels;
        }
        let wide_enough = inputs.min_sigma * 2.0 * grid.step();
        let above = grid_of(grid.level + 1);
        // The minimum side limits how much tiles can shrink with their level.
        let above_fits = above.tile << above.level <= inputs.sides.at(above.level);
        let (upsampled, gathered): (BTreeSet<_>, BTreeSet<_>) =
            needed.into_iter().partition(|tile| {
                above_fits && min_sigma_around(&grid, *tile, inputs, &mut sigmas) >= wide_enough
            });
        needed = upsampled
            .iter()
            .flat_map(|tile| tiles_upsampled_from(&grid, *tile, &above))
            .collect();
        levels.push(Level {
            grid,
            gathered,
            upsampled,
        });
    }
}

/// Rounds a tile side down to whole blocks of rows; smaller ones to even numbers, as upsampling needs.
pub(super) fn tile_within(side: usize) -> usize {
    let unit = if side < ROWS { 2 } else { ROWS };
    side / unit * unit
}

/// Returns the tiles of `grid` that cover these plate columns and rows.
pub(super) fn tiles_covering(
    grid: &TileGrid,
    columns: &Range<i32>,
    rows: &Range<i32>,
) -> BTreeSet<GridIndex> {
    let side = (grid.tile << grid.level) as i32;
    let over =
        |range: &Range<i32>| range.start.div_euclid(side)..(range.end - 1).div_euclid(side) + 1;
    let rows = over(rows);
    rows.flat_map(|y| over(columns).map(move |x| GridIndex::new(y, x)))
        .collect()
}

/// Returns the tiles of the next coarser grid `above` that a tile of `grid` is upsampled from.
pub(super) fn tiles_upsampled_from(
    grid: &TileGrid,
    tile: GridIndex,
    above: &TileGrid,
) -> BTreeSet<GridIndex> {
    let margin = MARGIN << above.level;
    let wider = |range: Range<i32>| range.start - margin..range.end + margin;
    let (columns, rows) = (grid.plate_columns(tile), grid.plate_rows(tile));
    tiles_covering(above, &wider(columns), &wider(rows))
}

/// Returns the smallest standard deviation at the corners of a tile and of its neighbours, where its light comes
/// from.
fn min_sigma_around(
    grid: &TileGrid,
    tile: GridIndex,
    inputs: &PlanInputs,
    sigmas: &mut BTreeMap<(i64, i64), f64>,
) -> f64 {
    let mut least = f64::INFINITY;
    for row in tile.row - 1..=tile.row + 2 {
        for column in tile.column - 1..=tile.column + 2 {
            let at = grid.plate_point(GridIndex::new(row, column));
            let at = (
                at.0.clamp(0.0, inputs.size.width as f64),
                at.1.clamp(0.0, inputs.size.height as f64),
            );
            let sigma = *sigmas
                .entry((at.0 as i64, at.1 as i64))
                .or_insert_with(|| (inputs.sigma)(at));
            least = least.min(sigma);
        }
    }
    least
}

/// The square blocks of a plate that hold light.
pub(super) struct LitBlocks {
    columns: usize,
    lit: Vec<bool>,
}

/// Side of a block, px.
const BLOCK: usize = 32;

impl LitBlocks {
    /// All blocks of a plate.
    pub(super) fn all(size: Size) -> Self {
        let columns = size.width.div_ceil(BLOCK);
        Self {
            columns,
            lit: vec![true; columns * size.height.div_ceil(BLOCK)],
        }
    }

    /// The blocks in which any of `planes`, all of one size, is not zero.
    pub(super) fn new(planes: &[View]) -> Self {
        let Some(first) = planes.first() else {
            return Self {
                columns: 0,
                lit: Vec::new(),
            };
        };
        let columns = first.width.div_ceil(BLOCK);
        let mut lit = vec![false; columns * first.height.div_ceil(BLOCK)];
        for plane in planes {
            for (y, row) in plane.samples.chunks_exact(plane.width).enumerate() {
                let line = &mut lit[y / BLOCK * columns..][..columns];
                for (lit, samples) in line.iter_mut().zip(row.chunks(BLOCK)) {
                    *lit = *lit || samples.iter().any(|v| *v != 0.0);
                }
            }
        }
        Self { columns, lit }
    }

    /// Returns the share of blocks that hold light.
    pub(super) fn share(&self) -> f64 {
        let lit = self.lit.iter().filter(|lit| **lit).count();
        lit as f64 / self.lit.len().max(1) as f64
    }

    /// Returns whether any block within `reach` px of a rectangle of columns and rows holds light.
    fn any_near(&self, columns: &Range<i32>, rows: &Range<i32>, reach: i32) -> bool {
        let count = self.lit.len().checked_div(self.columns).unwrap_or(0);
        let over = |range: &Range<i32>, count: usize| {
            let side = BLOCK as i32;
            let first = (range.start - reach)
                .div_euclid(side)
                .clamp(0, count as i32);
            let end = (range.end + reach).div_euclid(side) + 1;
            first as usize..end.clamp(first, count as i32) as usize
        };
        over(rows, count).any(|y| {
            let line = &self.lit[y * self.columns..][..self.columns];
            line[over(columns, self.columns)].iter().any(|lit| *lit)
        })
    }
}

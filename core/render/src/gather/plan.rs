//! Which tiles are gathered at which pyramid level, from the top down: what a coarse level can draw is
//! doubled from it, the rest is gathered where it is needed.

use super::fir::ROWS;
use super::grid::Grid;
use super::image::View;
use super::optics::Sides;
use super::pyramid::MARGIN;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The work at one level.
pub(super) struct Level {
    pub(super) grid: Grid,
    /// Tiles (row, column) to gather here.
    pub(super) gathered: BTreeSet<(i32, i32)>,
    /// Tiles to double from the level above.
    pub(super) doubled: BTreeSet<(i32, i32)>,
}

impl Level {
    /// Tile rows and columns that hold all work of this level.
    pub(super) fn extent(&self) -> (Range<i32>, Range<i32>) {
        let mut all = self.gathered.iter().chain(&self.doubled);
        let Some(&(y, x)) = all.next() else {
            return (0..0, 0..0);
        };
        all.fold((y..y + 1, x..x + 1), |(rows, columns), &(y, x)| {
            (
                rows.start.min(y)..rows.end.max(y + 1),
                columns.start.min(x)..columns.end.max(x + 1),
            )
        })
    }
}

/// What a plan depends on.
pub(super) struct Brief<'a> {
    pub(super) size: (usize, usize),
    /// How wide tiles may be.
    pub(super) sides: &'a Sides,
    /// Least side of a tile, pixels of its level.
    pub(super) least_tile: usize,
    /// Plate pixels to be rendered: columns and rows, which may lie beyond the plate.
    pub(super) wanted: (Range<i32>, Range<i32>),
    /// How far light goes from its source, px.
    pub(super) reach: i32,
    /// Least standard deviation of the blur at a plate point, px.
    pub(super) sigma: &'a dyn Fn((f64, f64)) -> f64,
    /// Least standard deviation drawn at a level, pixels of the level.
    pub(super) least_sigma: f64,
    /// Where there is light to spread.
    pub(super) lit: &'a Lit,
}

/// The work of all levels, finest first.
pub(super) fn plan(brief: &Brief) -> Vec<Level> {
    let mut sigmas = BTreeMap::new();
    let mut levels = Vec::new();
    let grid_of = |level: u32| {
        let tile = tile_within(brief.sides.at(level) >> level);
        Grid::new(level, tile.max(brief.least_tile), brief.size)
    };
    let mut needed = tiles_about(&grid_of(0), &brief.wanted);
    loop {
        let grid = grid_of(levels.len() as u32);
        needed.retain(|place| brief.lit.near(&square(&grid, *place), brief.reach));
        if needed.is_empty() {
            return levels;
        }
        let enough = brief.least_sigma * 2.0 * grid.step();
        let above = grid_of(grid.level + 1);
        // Tiles cannot shrink with their level for ever.
        let above_fits = above.tile << above.level <= brief.sides.at(above.level);
        let (doubled, gathered): (BTreeSet<_>, BTreeSet<_>) =
            needed.into_iter().partition(|place| {
                above_fits && least_about(&grid, *place, brief, &mut sigmas) >= enough
            });
        needed = doubled
            .iter()
            .flat_map(|place| tiles_below(&grid, *place, &above))
            .collect();
        levels.push(Level {
            grid,
            gathered,
            doubled,
        });
    }
}

/// The widest tile of at most `side` pixels that is whole rows of blocks, or doubled from whole pixels.
fn tile_within(side: usize) -> usize {
    let unit = if side < ROWS { 2 } else { ROWS };
    side / unit * unit
}

/// Columns and rows of plate pixels that a tile (row, column) covers.
fn square(grid: &Grid, (row, column): (i32, i32)) -> (Range<i32>, Range<i32>) {
    let side = (grid.tile << grid.level) as i32;
    (
        column * side..(column + 1) * side,
        row * side..(row + 1) * side,
    )
}

/// Tiles of `grid` that cover columns and rows of plate pixels.
pub(super) fn tiles_about(
    grid: &Grid,
    (columns, rows): &(Range<i32>, Range<i32>),
) -> BTreeSet<(i32, i32)> {
    let side = (grid.tile << grid.level) as i32;
    let over =
        |range: &Range<i32>| range.start.div_euclid(side)..(range.end - 1).div_euclid(side) + 1;
    let rows = over(rows);
    rows.flat_map(|y| over(columns).map(move |x| (y, x)))
        .collect()
}

/// Tiles of the level above that a tile is doubled from.
pub(super) fn tiles_below(grid: &Grid, place: (i32, i32), above: &Grid) -> BTreeSet<(i32, i32)> {
    let margin = MARGIN << above.level;
    let wider = |range: Range<i32>| range.start - margin..range.end + margin;
    let (columns, rows) = square(grid, place);
    tiles_about(above, &(wider(columns), wider(rows)))
}

/// Least standard deviation about a tile: at its corners and at those of the tiles about it, where the
/// light it sees comes from.
fn least_about(
    grid: &Grid,
    (row, column): (i32, i32),
    brief: &Brief,
    sigmas: &mut BTreeMap<(i64, i64), f64>,
) -> f64 {
    let mut least = f64::INFINITY;
    for y in row - 1..=row + 2 {
        for x in column - 1..=column + 2 {
            let at = grid.node_at(x, y);
            let at = (
                at.0.clamp(0.0, brief.size.0 as f64),
                at.1.clamp(0.0, brief.size.1 as f64),
            );
            let sigma = *sigmas
                .entry((at.0 as i64, at.1 as i64))
                .or_insert_with(|| (brief.sigma)(at));
            least = least.min(sigma);
        }
    }
    least
}

/// Squares of the plate that hold light.
pub(super) struct Lit {
    columns: usize,
    squares: Vec<bool>,
}

/// Side of a square, px.
const SQUARE: usize = 32;

impl Lit {
    /// Of a plate of some columns and rows that is lit all over.
    pub(super) fn all_of((width, height): (usize, usize)) -> Self {
        let columns = width.div_ceil(SQUARE);
        Self {
            columns,
            squares: vec![true; columns * height.div_ceil(SQUARE)],
        }
    }

    /// Of planes of one size.
    pub(super) fn of(planes: &[View]) -> Self {
        let Some(first) = planes.first() else {
            return Self {
                columns: 0,
                squares: Vec::new(),
            };
        };
        let columns = first.width.div_ceil(SQUARE);
        let mut squares = vec![false; columns * first.height.div_ceil(SQUARE)];
        for plane in planes {
            for (y, row) in plane.samples.chunks_exact(plane.width).enumerate() {
                let line = &mut squares[y / SQUARE * columns..][..columns];
                for (lit, samples) in line.iter_mut().zip(row.chunks(SQUARE)) {
                    *lit = *lit || samples.iter().any(|v| *v != 0.0);
                }
            }
        }
        Self { columns, squares }
    }

    /// Whether light within `reach` px of a rectangle of columns and rows can come from the plate.
    fn near(&self, (columns, rows): &(Range<i32>, Range<i32>), reach: i32) -> bool {
        let count = self.squares.len().checked_div(self.columns).unwrap_or(0);
        let over = |range: &Range<i32>, count: usize| {
            let side = SQUARE as i32;
            let first = (range.start - reach)
                .div_euclid(side)
                .clamp(0, count as i32);
            let end = (range.end + reach).div_euclid(side) + 1;
            first as usize..end.clamp(first, count as i32) as usize
        };
        over(rows, count).any(|y| {
            let line = &self.squares[y * self.columns..][..self.columns];
            line[over(columns, self.columns)].iter().any(|lit| *lit)
        })
    }
}

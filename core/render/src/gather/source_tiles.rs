//! Lit tiles of a plate, each scattered at the coarsest pyramid level that draws its blur.

use super::corner_stencils::{MixStencils, SparseGrid, source_kernels};
use super::image::{Image, Rect, Size, View};
use super::lens_probe::{LensProbe, TileSides};
use super::plan::tile_within;
use super::pyramid::downsample;
use super::tile_grid::{GridIndex, TileGrid};
use seidel_optics::error::Result;
use std::collections::BTreeSet;

/// Side of the squares of the plate that share a level, px.
const SQUARE: usize = 64;

/// Coarsest level.
const COARSEST: u32 = 8;

/// The light of one level, and the kernels that scatter it.
pub(super) struct SourceLevel {
    pub(super) grid: TileGrid,
    /// Light to scatter on this level, plane by plane.
    pub(super) light: Vec<Image>,
    /// Tiles that hold light.
    pub(super) tiles: Vec<GridIndex>,
    /// Kernels at the corners of these tiles.
    pub(super) kernels: SparseGrid<MixStencils>,
    /// The pixels of the level that the light reaches.
    pub(super) reached: Rect,
}

/// Splits `planes` into levels, finest first; the last one holds light.
///
/// # Errors
/// A lens that cannot be drawn at some point.
pub(super) fn source_levels(
    lens: &LensProbe,
    planes: &[View],
    size: Size,
    sides: &TileSides,
) -> Result<Vec<SourceLevel>> {
    let squares = LevelSquares::new(lens, planes, size, sides);
    let mut levels = Vec::new();
    for level in 0..=squares.coarsest() {
        let mut light: Vec<Image> = planes
            .iter()
            .map(|plane| squares.part(plane, level))
            .collect();
        if light.iter().any(|image| !image.samples.is_empty()) {
            for _ in 0..level {
                light = light
                    .iter()
                    .map(|image| downsample(&image.view()))
                    .collect();
            }
        }
        levels.push(SourceLevel::new(
            lens,
            light,
            tile_grid(lens, sides, size, level),
        )?);
    }
    Ok(levels)
}

/// Returns the grid of tiles on a level.
fn tile_grid(lens: &LensProbe, sides: &TileSides, size: Size, level: u32) -> TileGrid {
    let tile = tile_within(sides.at(level) >> level);
    TileGrid::new(
        level,
        tile.max(lens.tolerance.min_tile_for(lens.model)),
        size,
    )
}

impl SourceLevel {
    /// The finest level alone, for `light` in tiles of `side` pixels.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn finest(
        lens: &LensProbe,
        light: Vec<Image>,
        size: Size,
        side: usize,
    ) -> Result<Self> {
        Self::new(lens, light, TileGrid::new(0, side, size))
    }

    fn new(lens: &LensProbe, light: Vec<Image>, grid: TileGrid) -> Result<Self> {
        let mut tiles = BTreeSet::new();
        for image in &light {
            add_lit_tiles(&image.view(), grid.tile as i32, &mut tiles);
        }
        let corners = tiles.iter().flat_map(|tile: &GridIndex| tile.corners());
        let kernels = source_kernels(lens, &grid, &corners.collect())?;
        let reached = reached(&grid, &tiles, &kernels);
        Ok(Self {
            grid,
            light,
            tiles: tiles.into_iter().collect(),
            kernels,
            reached,
        })
    }
}

/// Adds the tiles of `side` pixels in which `image` is not zero.
fn add_lit_tiles(image: &View, side: i32, tiles: &mut BTreeSet<GridIndex>) {
    for (y, line) in image.samples.chunks_exact(image.width.max(1)).enumerate() {
        let row = (image.top + y as i32).div_euclid(side);
        let mut x = 0;
        while let Some(lit) = line[x..].iter().position(|sample| *sample != 0.0) {
            let column = (image.left + (x + lit) as i32).div_euclid(side);
            tiles.insert(GridIndex::new(row, column));
            // On with the next tile.
            x = ((column + 1) * side - image.left) as usize;
            if x >= line.len() {
                break;
            }
        }
    }
}

/// Returns the pixels that kernels spread the light of `tiles` over.
fn reached(
    grid: &TileGrid,
    tiles: &BTreeSet<GridIndex>,
    kernels: &SparseGrid<MixStencils>,
) -> Rect {
    let side = grid.tile as i32;
    let [mut left, mut top, mut right, mut bottom] = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
    for tile in tiles {
        let stencils = tile
            .corners()
            .into_iter()
            .filter_map(|corner| kernels.at(corner));
        for stencil in stencils.flatten() {
            let (columns, rows) = (stencil.columns(), stencil.rows());
            left = left.min(tile.column * side + columns.start);
            right = right.max((tile.column + 1) * side + columns.end);
            top = top.min(tile.row * side + rows.start);
            bottom = bottom.max((tile.row + 1) * side + rows.end);
        }
    }
    if right <= left || bottom <= top {
        return Rect {
            left: 0,
            top: 0,
            width: 0,
            height: 0,
        };
    }
    Rect {
        left,
        top,
        width: (right - left) as usize,
        height: (bottom - top) as usize,
    }
}

/// The level of each square of the plate; `None` where it is dark.
struct LevelSquares {
    columns: usize,
    levels: Vec<Option<u32>>,
}

impl LevelSquares {
    fn new(lens: &LensProbe, planes: &[View], size: Size, sides: &TileSides) -> Self {
        let (columns, rows) = (size.width.div_ceil(SQUARE), size.height.div_ceil(SQUARE));
        let mut lit = BTreeSet::new();
        for plane in planes {
            add_lit_tiles(plane, SQUARE as i32, &mut lit);
        }
        let narrowest = lens.tolerance.min_sigma_for(lens.model);
        let most = (0..=COARSEST).rev().find(|level| {
            let tile = lens.tolerance.min_tile_for(lens.model);
            tile << level <= sides.at(*level)
        });
        let level_of = |index: usize| {
            let (row, column) = (index / columns, index % columns);
            if !lit.contains(&GridIndex::new(row as i32, column as i32)) {
                return None;
            }
            let at = |k: usize, size: usize| (k * SQUARE).min(size) as f64;
            let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
            let sigmas = corners.map(|(y, x)| {
                lens.min_sigma((at(column + x, size.width), at(row + y, size.height)))
            });
            let sigma = sigmas.into_iter().fold(f64::INFINITY, f64::min);
            let level = (sigma / narrowest).log2().floor().max(0.0) as u32;
            Some(level.min(most.unwrap_or(0)))
        };
        Self {
            columns,
            levels: (0..columns * rows).map(level_of).collect(),
        }
    }

    /// Returns the coarsest level of any square.
    fn coarsest(&self) -> u32 {
        self.levels.iter().flatten().copied().max().unwrap_or(0)
    }

    /// Returns the light of `plane` in the squares of `level`.
    fn part(&self, plane: &View, level: u32) -> Image {
        let mut part = Image::zeros(Rect {
            left: 0,
            top: 0,
            width: plane.width,
            height: plane.height,
        });
        if self.levels.iter().all(|own| *own != Some(level)) {
            return Image::default();
        }
        let lines = part.samples.chunks_exact_mut(plane.width.max(1));
        for (y, (out, line)) in lines
            .zip(plane.samples.chunks_exact(plane.width.max(1)))
            .enumerate()
        {
            let levels = &self.levels[y / SQUARE * self.columns..];
            let squares = out.chunks_mut(SQUARE).zip(line.chunks(SQUARE));
            for ((out, line), own) in squares.zip(levels) {
                if *own == Some(level) {
                    out.copy_from_slice(line);
                }
            }
        }
        part
    }
}

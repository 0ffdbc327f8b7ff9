//! Lit tiles of a plate, each scattered at the coarsest pyramid level that draws its blur.
//!
//! Tiles over which the blur changes fast, as beside the line in focus of a tilted lens, are cut into smaller ones.

use super::corner_stencils::{MixStencils, SparseGrid, source_kernels};
use super::image::{Image, Rect, Size, View};
use super::lens_probe::{LensProbe, TileSides};
use super::plan::tile_within;
use super::pyramid::downsample;
use super::stencil::Stencil;
use super::tile_grid::{GridIndex, TileGrid};
use crate::Scene;
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Side of the squares of the plate that share a level, px.
const SQUARE: usize = 32;

/// Coarsest level.
const COARSEST: u32 = 8;

/// Side of tiles that are not cut, pixels of the level.
const SMALLEST_TILE: usize = 4;

/// The light of one level, and the kernels that scatter it.
pub(super) struct SourceLevel {
    /// Light to scatter on this level, that of planes with the same samples once.
    pub(super) light: Vec<Image>,
    /// The tiles that hold light, largest first; at least one part.
    pub(super) parts: Vec<SourceTiles>,
    /// The pixels of the level that the light reaches.
    pub(super) reached: Rect,
}

/// Tiles of one size that hold light.
pub(super) struct SourceTiles {
    pub(super) grid: TileGrid,
    pub(super) tiles: Vec<GridIndex>,
    /// Kernels at the corners of these tiles.
    pub(super) kernels: SparseGrid<MixStencils>,
}

/// Splits `planes` into levels, finest first; the last one holds light.
///
/// # Errors
/// A lens that cannot be drawn at some point.
pub(super) fn source_levels(
    lens: &LensProbe,
    planes: &[View],
    scene: &Scene,
    sides: &TileSides,
) -> Result<Vec<SourceLevel>> {
    let squares = LevelSquares::new(lens, planes, scene, sides);
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
            tile_grid(lens, sides, scene, level),
            scene,
        )?);
    }
    Ok(levels)
}

/// Returns the grid of tiles on a level.
fn tile_grid(lens: &LensProbe, sides: &TileSides, scene: &Scene, level: u32) -> TileGrid {
    let tile = tile_within(sides.at(level) >> level);
    let tile = tile.max(lens.tolerance.min_tile_for(lens.model));
    TileGrid::anchored(level, tile, scene)
}

fn size_of(scene: &Scene) -> Size {
    Size {
        width: scene.width,
        height: scene.height,
    }
}

impl SourceLevel {
    fn new(lens: &LensProbe, light: Vec<Image>, grid: TileGrid, scene: &Scene) -> Result<Self> {
        let views: Vec<View> = light.iter().map(Image::view).collect();
        let tiles = lit_tiles(&views, grid.tile as i32, grid.origin);
        let mut parts = vec![SourceTiles::new(lens, grid, tiles)?];
        while let Some(last) = parts.last_mut() {
            let cut = last.take_changing(lens, scene)?;
            if cut.is_empty() {
                break;
            }
            let grid = last.halves(scene);
            let mut tiles = lit_tiles(&views, grid.tile as i32, grid.origin);
            tiles.retain(|tile| cut.contains(&last.grid.tile_at(grid.first_pixel(*tile))));
            parts.push(SourceTiles::new(lens, grid, tiles)?);
        }
        let reached = parts.iter().map(SourceTiles::reached);
        Ok(Self {
            reached: reached.reduce(Rect::joined).unwrap_or_default(),
            light,
            parts,
        })
    }

    /// Returns the number of tiles.
    pub(super) fn tile_count(&self) -> usize {
        self.parts.iter().map(|part| part.tiles.len()).sum()
    }
}

impl SourceTiles {
    fn new(lens: &LensProbe, grid: TileGrid, tiles: BTreeSet<GridIndex>) -> Result<Self> {
        let corners = tiles.iter().flat_map(|tile| tile.corners());
        Ok(Self {
            grid,
            kernels: source_kernels(lens, &grid, &corners.collect())?,
            tiles: tiles.into_iter().collect(),
        })
    }

    /// The grid of tiles of half the side, which cut each tile into four.
    fn halves(&self, scene: &Scene) -> TileGrid {
        TileGrid::anchored(self.grid.level, self.grid.tile / 2, scene)
    }

    /// Takes the tiles over which the blur changes so fast that kernels at their corners do not tell the one in their middle.
    fn take_changing(&mut self, lens: &LensProbe, scene: &Scene) -> Result<BTreeSet<GridIndex>> {
        if self.grid.tile < 2 * SMALLEST_TILE || !self.grid.tile.is_multiple_of(4) {
            return Ok(BTreeSet::new());
        }
        let allowed = (lens.tolerance).interpolation_error_at(self.grid.level, lens.model);
        let halves = self.halves(scene);
        let middle = |tile: GridIndex| {
            let side = halves.tile as i32;
            halves.tile_at(self.grid.first_pixel(tile).map(|px| px + side))
        };
        // Most tiles need no kernel in the middle: those at opposite corners are nearly alike.
        let differs = |tile: &&GridIndex| {
            let across = [[0, 3], [1, 2]].map(|pair| self.difference(**tile, pair));
            across.into_iter().fold(0.0, f64::max) > CORNER_FACTOR * allowed
        };
        let tiles: Vec<GridIndex> = self.tiles.par_iter().filter(differs).copied().collect();
        let middles = source_kernels(lens, &halves, &tiles.iter().map(|t| middle(*t)).collect())?;
        let changes = |tile: &GridIndex| {
            let found = middles.at(middle(*tile));
            found.is_some_and(|found| self.error(*tile, found) > MIDDLE_FACTOR * allowed)
        };
        let cut: BTreeSet<GridIndex> = tiles.into_iter().filter(changes).collect();
        self.tiles.retain(|tile| !cut.contains(tile));
        Ok(cut)
    }

    /// Returns the largest difference of the kernels at a pair of corners of a tile, as a share of their light.
    fn difference(&self, tile: GridIndex, corners: [usize; 2]) -> f64 {
        let [a, b] = corners.map(|corner| self.kernels.at(tile.corners()[corner]));
        let pairs = a.into_iter().flatten().zip(b.into_iter().flatten());
        pairs
            .map(|(a, b)| Stencil::weighted_sum(&[(a, 1.0), (b, -1.0)]).magnitude())
            .fold(0.0, f64::max)
    }

    /// Returns the largest difference of the kernels in the `middle` of a tile from those interpolated there, as a share of their light.
    fn error(&self, tile: GridIndex, middle: &MixStencils) -> f64 {
        let corners: Vec<&MixStencils> = (tile.corners().into_iter())
            .filter_map(|corner| self.kernels.at(corner))
            .collect();
        let of_mix = |(mix, middle): (usize, &Stencil)| {
            let mut parts = vec![(middle, 1.0)];
            parts.extend(corners.iter().map(|corner| (&corner[mix], -0.25)));
            Stencil::weighted_sum(&parts).magnitude()
        };
        middle.iter().enumerate().map(of_mix).fold(0.0, f64::max)
    }

    /// Returns the pixels that the kernels spread the light of the tiles over.
    fn reached(&self) -> Rect {
        reached(&self.grid, &self.tiles, &self.kernels)
    }
}

/// Factor on the interpolation error above which the difference of opposite corners, and the error in the middle, cut a tile.
const CORNER_FACTOR: f64 = 15.0;
const MIDDLE_FACTOR: f64 = 5.0;

/// Returns the tiles of `side` pixels in which any of `images` is not zero; the first tile begins at `origin`.
fn lit_tiles(images: &[View], side: i32, origin: [i32; 2]) -> BTreeSet<GridIndex> {
    let bands = images.par_iter().flat_map(|image| {
        let bands = image.samples.par_chunks(image.width.max(1) * BAND);
        bands.enumerate().map(|(band, samples)| {
            let mut tiles = BTreeSet::new();
            let part = View {
                top: image.top + (band * BAND) as i32,
                samples,
                ..*image
            };
            add_lit_tiles(&part, side, origin, &mut tiles);
            tiles
        })
    });
    bands.reduce(BTreeSet::new, |mut all, mut part| {
        all.append(&mut part);
        all
    })
}

/// Rows that one thread searches for light.
const BAND: usize = 64;

/// Adds the tiles of `side` pixels in which `image` is not zero to `tiles`; the first tile begins at `origin`.
fn add_lit_tiles(image: &View, side: i32, origin: [i32; 2], tiles: &mut BTreeSet<GridIndex>) {
    let (left, top) = (image.left - origin[0], image.top - origin[1]);
    for (y, line) in image.samples.chunks_exact(image.width.max(1)).enumerate() {
        let row = (top + y as i32).div_euclid(side);
        let mut x = 0;
        while let Some(lit) = line[x..].iter().position(|sample| *sample != 0.0) {
            let column = (left + (x + lit) as i32).div_euclid(side);
            tiles.insert(GridIndex::new(row, column));
            // On with the next tile.
            x = ((column + 1) * side - left) as usize;
            if x >= line.len() {
                break;
            }
        }
    }
}

/// Returns the pixels that kernels spread the light of `tiles` over.
fn reached(grid: &TileGrid, tiles: &[GridIndex], kernels: &SparseGrid<MixStencils>) -> Rect {
    let side = grid.tile as i32;
    let [mut left, mut top, mut right, mut bottom] = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
    for tile in tiles {
        let [x, y] = grid.first_pixel(*tile);
        let stencils = tile
            .corners()
            .into_iter()
            .filter_map(|corner| kernels.at(corner));
        for stencil in stencils.flatten() {
            let (columns, rows) = (stencil.columns(), stencil.rows());
            left = left.min(x + columns.start);
            right = right.max(x + side + columns.end);
            top = top.min(y + rows.start);
            bottom = bottom.max(y + side + rows.end);
        }
    }
    if right <= left || bottom <= top {
        return Rect::default();
    }
    Rect {
        left,
        top,
        width: (right - left) as usize,
        height: (bottom - top) as usize,
    }
}

/// The level of each square of the plate; `None` where it is dark. Squares are fixed to the frame.
struct LevelSquares {
    /// Pixels of the first square that lie outside the plate, along x and y.
    before: [usize; 2],
    columns: usize,
    levels: Vec<Option<u32>>,
}

impl LevelSquares {
    fn new(lens: &LensProbe, planes: &[View], scene: &Scene, sides: &TileSides) -> Self {
        let size = size_of(scene);
        let before = scene.place_in_cell(SQUARE);
        let columns = (size.width + before[0]).div_ceil(SQUARE);
        let rows = (size.height + before[1]).div_ceil(SQUARE);
        let lit = lit_tiles(planes, SQUARE as i32, before.map(|px| -(px as i32)));
        let narrowest = lens.tolerance.min_sigma_for(lens.model);
        let most = (0..=COARSEST).rev().find(|level| {
            let tile = lens.tolerance.min_tile_for(lens.model);
            tile << level <= sides.at(*level)
        });
        // Up to four squares share a corner.
        let corners: BTreeSet<GridIndex> = lit.iter().flat_map(|square| square.corners()).collect();
        let sigma_at = |corner: &GridIndex| {
            let x = first_pixel(corner.column as usize, before[0], size.width);
            let y = first_pixel(corner.row as usize, before[1], size.height);
            (*corner, lens.min_sigma((x as f64, y as f64)))
        };
        let corners: Vec<GridIndex> = corners.into_iter().collect();
        let sigmas: BTreeMap<GridIndex, f64> = corners.par_iter().map(sigma_at).collect();
        let level_of = |index: usize| {
            let square = GridIndex::new((index / columns) as i32, (index % columns) as i32);
            if !lit.contains(&square) {
                return None;
            }
            let sigmas = square.corners().map(|corner| sigmas[&corner]);
            let sigma = sigmas.into_iter().fold(f64::INFINITY, f64::min);
            let level = (sigma / narrowest).log2().floor().max(0.0) as u32;
            Some(level.min(most.unwrap_or(0)))
        };
        Self {
            before,
            columns,
            levels: (0..columns * rows).map(level_of).collect(),
        }
    }

    /// Returns the coarsest level of any square.
    fn coarsest(&self) -> u32 {
        self.levels.iter().flatten().copied().max().unwrap_or(0)
    }

    /// Returns the light of `plane` in the squares of `level`: the rectangle that holds them.
    fn part(&self, plane: &View, level: u32) -> Image {
        let Some([rows, columns]) = self.bounds(level) else {
            return Image::default();
        };
        let pixels = |squares: &Range<usize>, axis: usize, size: usize| {
            let at = |square: usize| first_pixel(square, self.before[axis], size);
            at(squares.start)..at(squares.end)
        };
        let across = pixels(&columns, 0, plane.width);
        let down = pixels(&rows, 1, plane.height);
        let mut part = Image::zeros(Rect {
            left: across.start as i32,
            top: down.start as i32,
            width: across.len(),
            height: down.len(),
        });
        let lines = part.samples.par_chunks_exact_mut(across.len().max(1));
        lines.enumerate().for_each(|(line, out)| {
            let y = down.start + line;
            let row = (y + self.before[1]) / SQUARE;
            let line = &plane.samples[y * plane.width..][..plane.width];
            for column in columns.clone() {
                if self.levels[row * self.columns + column] == Some(level) {
                    let square = pixels(&(column..column + 1), 0, plane.width);
                    let to = square.start - across.start..square.end - across.start;
                    out[to].copy_from_slice(&line[square]);
                }
            }
        });
        part
    }

    /// Returns the rows and columns that hold the squares of `level`; `None` without any.
    fn bounds(&self, level: u32) -> Option<[Range<usize>; 2]> {
        let own = (self.levels.iter().enumerate()).filter(|(_, own)| **own == Some(level));
        own.map(|(index, _)| (index / self.columns, index % self.columns))
            .map(|(row, column)| [row..row + 1, column..column + 1])
            .reduce(|a, b| {
                [0, 1].map(|axis| a[axis].start.min(b[axis].start)..a[axis].end.max(b[axis].end))
            })
    }
}

/// Returns the first pixel of a square along an axis of `size` pixels; `before` of the first square lie outside.
fn first_pixel(square: usize, before: usize, size: usize) -> usize {
    (square * SQUARE).saturating_sub(before).min(size)
}

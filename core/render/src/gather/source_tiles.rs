//! Lit tiles of a plate, each scattered at the coarsest pyramid level that draws its blur.

use super::corner_stencils::{MixStencils, SparseGrid, source_kernels};
use super::image::{Image, Rect, Size, View};
use super::lens_probe::{LensProbe, TileSides};
use super::plan::tile_within;
use super::pyramid::downsample;
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

/// The light of one level, and the kernels that scatter it.
pub(super) struct SourceLevel {
    pub(super) grid: TileGrid,
    /// Light to scatter on this level, that of planes with the same samples once.
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
    fn new(lens: &LensProbe, light: Vec<Image>, grid: TileGrid) -> Result<Self> {
        let views: Vec<View> = light.iter().map(Image::view).collect();
        let tiles = lit_tiles(&views, grid.tile as i32, grid.origin);
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
fn reached(
    grid: &TileGrid,
    tiles: &BTreeSet<GridIndex>,
    kernels: &SparseGrid<MixStencils>,
) -> Rect {
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

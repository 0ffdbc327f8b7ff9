//! Overlapping tiles for weighted overlap-add: a plane is cut into windowed tiles, each is filtered, windowed once more and
//! added to the result.
//!
//! Windows are sines over the overlap. The sum of their squares is one everywhere, so tiles that are not filtered give
//! back the plane.

use rayon::prelude::*;
use std::f64::consts::PI;

/// Share of a tile's side that it has in common with the next tile.
const OVERLAP: f64 = 0.5;
/// Rows that one task adds up.
const BAND_ROWS: usize = 32;

/// The tiles of a plane.
pub(super) struct OverlappingTiles {
    /// Columns and rows of the plane.
    size: (usize, usize),
    /// Side of a tile, px.
    pub(super) side: usize,
    /// Place of each tile, row by row of tiles.
    pub(super) tiles: Vec<Tile>,
    /// Number of tiles in a row of tiles.
    columns: usize,
    /// Distance from one tile to the next, px.
    hop: usize,
    /// The window along one axis.
    window: Vec<f32>,
}

/// The place of a tile, whose parts beyond the plane are black.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tile {
    /// First column on the plane, negative for tiles that begin beyond it.
    left: i32,
    /// First row on the plane, likewise.
    top: i32,
}

/// A tile and its weight in an interpolation.
#[derive(Debug, Clone, Copy)]
pub(super) struct WeightedTile {
    /// Index in [`OverlappingTiles::tiles`].
    pub(super) index: usize,
    pub(super) weight: f32,
}

/// The part of a row of a tile that lies on the plane.
pub(super) struct RowSpan {
    /// Its samples in the tile.
    in_tile: std::ops::Range<usize>,
    /// Its first sample on the plane.
    pub(super) in_plane: usize,
    /// The window of the row.
    window: f32,
}

impl OverlappingTiles {
    /// Covers a plane of `size`, columns and rows, with tiles of `side` pixels that extend equally far beyond opposite
    /// edges.
    pub(super) fn new(size: (usize, usize), side: usize) -> Self {
        let overlap = (OVERLAP * side as f64) as usize;
        let hop = side - overlap;
        let count = |size: usize| (size + overlap).div_ceil(hop);
        let starts = |size: usize| {
            let before = (overlap + count(size) * hop - size) / 2;
            (0..count(size)).map(move |k| (k * hop) as i32 - before as i32)
        };
        Self {
            size,
            side,
            tiles: starts(size.1)
                .flat_map(|top| starts(size.0).map(move |left| Tile { left, top }))
                .collect(),
            columns: count(size.0),
            hop,
            window: (0..side)
                .map(|k| {
                    let inwards = (k.min(side - 1 - k) as f64 + 0.5) / overlap as f64;
                    (0.5 * PI * inwards.min(1.0)).sin() as f32
                })
                .collect(),
        }
    }

    /// Returns the centre of a tile, moved onto the plane.
    pub(super) fn centre(&self, tile: Tile) -> (f64, f64) {
        let along = |start: i32, size: usize| {
            (f64::from(start) + self.side as f64 / 2.0).clamp(0.0, size as f64)
        };
        (along(tile.left, self.size.0), along(tile.top, self.size.1))
    }

    /// Returns the tiles whose centres surround the point (`x`, `y`), with their weights for bilinear interpolation.
    pub(super) fn around(&self, x: f64, y: f64) -> [WeightedTile; 4] {
        let (first, rows) = (self.tiles[0], self.tiles.len() / self.columns);
        let along = |at: f64, first: i32, count: usize| {
            let half = self.side as f64 / 2.0;
            let step =
                ((at - f64::from(first) - half) / self.hop as f64).clamp(0.0, (count - 1) as f64);
            let low = (step as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), (step - low as f64) as f32)
        };
        let (left, right, share_x) = along(x, first.left, self.columns);
        let (top, bottom, share_y) = along(y, first.top, rows);
        let weighted = |row: usize, column: usize, weight: f32| WeightedTile {
            index: row * self.columns + column,
            weight,
        };
        [
            weighted(top, left, (1.0 - share_x) * (1.0 - share_y)),
            weighted(top, right, share_x * (1.0 - share_y)),
            weighted(bottom, left, (1.0 - share_x) * share_y),
            weighted(bottom, right, share_x * share_y),
        ]
    }

    /// Returns whether all of a tile lies on the plane.
    pub(super) fn is_inside(&self, tile: Tile) -> bool {
        let inside = self.row_spans(tile).map(|span| span.in_tile.len());
        inside.sum::<usize>() == self.side * self.side
    }

    /// Returns whether `coverage`, a plane, is above zero on all of a tile.
    pub(super) fn is_covered(&self, coverage: &[f32], tile: Tile) -> bool {
        self.row_spans(tile)
            .all(|span| span.of(coverage).iter().all(|v| *v > 0.0))
    }

    /// Returns whether `coverage`, a plane, is zero on all of a tile.
    pub(super) fn is_uncovered(&self, coverage: &[f32], tile: Tile) -> bool {
        self.row_spans(tile)
            .all(|span| span.of(coverage).iter().all(|v| *v == 0.0))
    }

    /// Returns a windowed tile of `plane`.
    pub(super) fn cut(&self, plane: &[f32], tile: Tile) -> Vec<f32> {
        let mut out = vec![0.0; self.side * self.side];
        for span in self.row_spans(tile) {
            let samples = span.of(plane).iter();
            let windows = &self.window[span.in_tile.start % self.side..];
            for ((out, sample), window) in out[span.in_tile].iter_mut().zip(samples).zip(windows) {
                *out = span.window * window * sample;
            }
        }
        out
    }

    /// Returns a tile of one value, windowed.
    pub(super) fn constant(&self, value: f32) -> Vec<f32> {
        let rows = self.window.iter();
        rows.flat_map(|wy| self.window.iter().map(move |wx| value * wy * wx))
            .collect()
    }

    /// Returns the sum of a tile's window.
    pub(super) fn window_sum(&self) -> f32 {
        self.window.iter().sum::<f32>().powi(2)
    }

    /// Returns the sum of the squares of a tile's window: the power at each frequency of windowed white noise of unit
    /// variance.
    pub(super) fn window_energy(&self) -> f32 {
        self.window.iter().map(|w| w * w).sum::<f32>().powi(2)
    }

    /// Returns the sum of the `filtered` tiles, windowed once more; tiles that are `None` are zero. Tiles are added in
    /// order, so that the sum does not depend on the number of threads.
    pub(super) fn overlap_add(&self, filtered: &[Option<Vec<f32>>]) -> Vec<f32> {
        let mut out = vec![0.0; self.size.0 * self.size.1];
        let bands = out.par_chunks_mut(BAND_ROWS * self.size.0).enumerate();
        bands.for_each(|(band, out)| {
            for (tile, samples) in self.tiles.iter().zip(filtered) {
                if let Some(samples) = samples {
                    self.add(samples, *tile, band * BAND_ROWS, out);
                }
            }
        });
        out
    }

    /// Adds those rows of a tile to `out` that lie on it: rows of the plane from `first` on.
    fn add(&self, samples: &[f32], tile: Tile, first: usize, out: &mut [f32]) {
        let before = first * self.size.0;
        for span in self.row_spans(tile) {
            if span.in_plane < before || span.in_plane >= before + out.len() {
                continue;
            }
            let windows = &self.window[span.in_tile.start % self.side..];
            let out = out[span.in_plane - before..].iter_mut();
            for ((out, sample), window) in out.zip(&samples[span.in_tile]).zip(windows) {
                *out += span.window * window * sample;
            }
        }
    }

    /// Returns the rows of a tile that lie on the plane.
    pub(super) fn row_spans(&self, tile: Tile) -> impl Iterator<Item = RowSpan> + '_ {
        let Tile { left, top } = tile;
        let (width, height) = (self.size.0 as i32, self.size.1 as i32);
        let side = self.side as i32;
        let columns = (-left).max(0) as usize..(width - left).clamp(0, side) as usize;
        let rows = (-top).max(0) as usize..(height - top).clamp(0, side) as usize;
        let rows = if columns.is_empty() { 0..0 } else { rows };
        rows.map(move |y| RowSpan {
            in_tile: y * self.side + columns.start..y * self.side + columns.end,
            in_plane: (top + y as i32) as usize * self.size.0
                + (left + columns.start as i32) as usize,
            window: self.window[y],
        })
    }
}

impl RowSpan {
    /// Returns the samples of `plane` on this span.
    fn of<'p>(&self, plane: &'p [f32]) -> &'p [f32] {
        &plane[self.in_plane..][..self.in_tile.len()]
    }
}

//! Background and its noise: sigma-clipped medians by channel on a mesh, interpolated linearly.

use rayon::prelude::*;

use crate::photograph::Photograph;
use crate::robust::{median, scatter};

/// Side of a cell of the mesh, px: several times the extent of a light, so that most of its pixels are dark.
const CELL_PX: usize = 48;
/// Largest number of cells along an axis. Larger frames get larger cells.
const MAX_CELLS: usize = 64;
/// Clipping threshold in standard deviations, and the largest number of iterations.
const CLIP_SIGMAS: f64 = 3.0;
const MAX_ITERATIONS: usize = 8;
/// Standard deviation of a normal distribution clipped at [`CLIP_SIGMAS`], iterated to the end.
const CLIPPED_SIGMA: f64 = 0.985;

/// Background and noise of one channel.
#[derive(Debug, Clone)]
pub struct Background {
    cell_px: f64,
    columns: usize,
    rows: usize,
    level: Vec<f64>,
    sigma: Vec<f64>,
}

impl Background {
    /// Estimates the background of `channel`.
    pub fn of(photo: &Photograph, channel: usize) -> Self {
        let longest = photo.width.max(photo.height);
        let cell = CELL_PX.max(longest.div_ceil(MAX_CELLS));
        let (columns, rows) = (photo.width.div_ceil(cell), photo.height.div_ceil(cell));
        let plane = &photo.planes[photo.plane_of(channel)];
        let cells: Vec<CellStatistics> = (0..columns * rows)
            .into_par_iter()
            .map(|index| {
                let (left, top) = (index % columns * cell, index / columns * cell);
                let mut values = Vec::with_capacity(cell * cell);
                for y in top..(top + cell).min(photo.height) {
                    for x in left..(left + cell).min(photo.width) {
                        if photo.covers(channel, x, y) && !photo.is_bad(x, y) {
                            values.push(f64::from(plane[y * photo.width + x]));
                        }
                    }
                }
                CellStatistics::of(values)
            })
            .collect();
        let level: Vec<f64> = cells.iter().map(|c| c.level).collect();
        // Rounding to whole steps is noise of its own, even where all samples round to one value.
        let least = photo.errors.quantum / 12_f64.sqrt();
        let sigma: Vec<f64> = cells.iter().map(|c| c.sigma.max(least)).collect();
        Self {
            cell_px: cell as f64,
            columns,
            rows,
            level: median_of_neighbours(&level, columns, rows),
            sigma: median_of_neighbours(&sigma, columns, rows),
        }
    }

    /// Returns the background at frame position (`x`, `y`), counts.
    pub fn level_at(&self, x: f64, y: f64) -> f64 {
        self.interpolate(&self.level, x, y)
    }

    /// Returns the standard deviation of the noise of a dark pixel at frame position (`x`, `y`), counts.
    pub fn sigma_at(&self, x: f64, y: f64) -> f64 {
        self.interpolate(&self.sigma, x, y)
    }

    /// Returns the median standard deviation of the frame.
    pub fn typical_sigma(&self) -> f64 {
        median(&mut self.sigma.clone())
    }

    fn interpolate(&self, values: &[f64], x: f64, y: f64) -> f64 {
        let place = |at: f64, count: usize| {
            let at = (at / self.cell_px - 0.5).clamp(0.0, (count - 1) as f64);
            let low = (at as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), at - low as f64)
        };
        let (left, right, tx) = place(x, self.columns);
        let (top, bottom, ty) = place(y, self.rows);
        let row = |r: usize| {
            values[r * self.columns + left] * (1.0 - tx) + values[r * self.columns + right] * tx
        };
        row(top) * (1.0 - ty) + row(bottom) * ty
    }
}

struct CellStatistics {
    level: f64,
    sigma: f64,
}

impl CellStatistics {
    /// Clips `values` until none departs from their median by more than [`CLIP_SIGMAS`].
    fn of(mut values: Vec<f64>) -> Self {
        let mut sigma = scatter(&values);
        for _ in 0..MAX_ITERATIONS {
            let middle = median(&mut values);
            let before = values.len();
            values.retain(|v| (v - middle).abs() <= CLIP_SIGMAS * sigma);
            let clipped = deviation(&values) / CLIPPED_SIGMA;
            // A constant region has no scatter, and quantised values may have none either.
            sigma = if clipped > 0.0 { clipped } else { sigma };
            if values.len() == before {
                break;
            }
        }
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let middle = median(&mut values);
        // The mode of a slightly skewed distribution (Pearson), which faint wings of lights shift least.
        let mode = 2.5 * middle - 1.5 * mean;
        let is_skewed = (mean - middle).abs() > 0.3 * sigma;
        Self {
            level: if is_skewed { middle } else { mode },
            sigma,
        }
    }
}

fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (square / count).sqrt()
}

/// Replaces every cell by the median of its 3 x 3 neighbours.
fn median_of_neighbours(values: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
    (0..values.len())
        .map(|index| {
            let mut near: Vec<f64> = around(index / columns, rows)
                .flat_map(|row| {
                    around(index % columns, columns).map(move |column| row * columns + column)
                })
                .map(|k| values[k])
                .collect();
            median(&mut near)
        })
        .collect()
}

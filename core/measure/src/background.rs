//! Background and its noise: sigma-clipped medians by channel on a mesh, smoothed by robust planes and interpolated linearly.

use rayon::prelude::*;

use crate::photograph::Photograph;
use seidel_optics::numeric::{median, scatter};

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
    /// Width and height of a cell, px.
    cell_px: [f64; 2],
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
                let range =
                    |k: usize, count: usize, size: usize| k * size / count..(k + 1) * size / count;
                let mut values = Vec::with_capacity(cell * cell);
                for y in range(index / columns, rows, photo.height) {
                    for x in range(index % columns, columns, photo.width) {
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
            cell_px: [
                photo.width as f64 / columns as f64,
                photo.height as f64 / rows as f64,
            ],
            columns,
            rows,
            level: plane_of_neighbours(&level, columns, rows),
            sigma: median_of_neighbours(&sigma, columns, rows),
        }
    }

    /// Returns the background at frame position (`x`, `y`), counts.
    pub fn level_at(&self, x: f64, y: f64) -> f64 {
        // Half a cell at the border of the frame lies outside all centres of cells, where a sloping background goes on.
        self.interpolate(&self.level, x, y, 0.5)
    }

    /// Returns the standard deviation of the noise of a dark pixel at frame position (`x`, `y`), counts.
    pub fn sigma_at(&self, x: f64, y: f64) -> f64 {
        self.interpolate(&self.sigma, x, y, 0.0)
    }

    /// Returns the median level of the frame, counts.
    pub fn typical_level(&self) -> f64 {
        median(&mut self.level.clone())
    }

    /// Returns the median standard deviation of the frame.
    pub fn typical_sigma(&self) -> f64 {
        median(&mut self.sigma.clone())
    }

    /// Interpolates `values` between the centres of cells, and extrapolates them by at most `beyond` cells.
    fn interpolate(&self, values: &[f64], x: f64, y: f64, beyond: f64) -> f64 {
        let place = |at: f64, count: usize| {
            let at = (at - 0.5).clamp(-beyond, (count - 1) as f64 + beyond);
            let low = (at.max(0.0) as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), at - low as f64)
        };
        let (left, right, tx) = place(x / self.cell_px[0], self.columns);
        let (top, bottom, ty) = place(y / self.cell_px[1], self.rows);
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

/// Replaces every cell by a robust plane through its 3 x 3 neighbours, or through the nearest 3 x 3 cells at the border of
/// the mesh. Medians alone would take the level of a sloping background at the border from farther inside.
fn plane_of_neighbours(values: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    if columns < 3 || rows < 3 {
        return median_of_neighbours(values, columns, rows);
    }
    (0..values.len())
        .map(|index| {
            let (column, row) = (index % columns, index / columns);
            let left = column.saturating_sub(1).min(columns - 3);
            let top = row.saturating_sub(1).min(rows - 3);
            let at = |x: usize, y: usize| values[(top + y) * columns + left + x];
            let slope_x = median_slope(|line, k| at(k, line));
            let slope_y = median_slope(at);
            let mut here: Vec<f64> = (0..9)
                .map(|k| {
                    let (x, y) = (k % 3, k / 3);
                    let to_x = column as f64 - (left + x) as f64;
                    let to_y = row as f64 - (top + y) as f64;
                    at(x, y) + slope_x * to_x + slope_y * to_y
                })
                .collect();
            median(&mut here)
        })
        .collect()
}

/// Returns the median slope of all pairs of values on three lines (Theil 1950).
fn median_slope(value: impl Fn(usize, usize) -> f64) -> f64 {
    let mut slopes = Vec::with_capacity(9);
    for line in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| value(line, k));
        slopes.extend([b - a, c - b, (c - a) / 2.0]);
    }
    median(&mut slopes)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_follows_a_slope_up_to_the_border_and_ignores_a_bright_cell() {
        let (columns, rows) = (6, 4);
        let slope = |k: usize| 100.0 + 3.0 * (k % columns) as f64 - 2.0 * (k / columns) as f64;
        let mut values: Vec<f64> = (0..columns * rows).map(slope).collect();
        values[0] = 1e6;
        values[9] = 1e6;
        for (k, found) in plane_of_neighbours(&values, columns, rows)
            .iter()
            .enumerate()
        {
            assert!((found - slope(k)).abs() < 1e-9, "cell {k}: {found}");
        }
    }

    #[test]
    fn a_sloping_level_goes_on_to_the_border_of_the_frame() {
        let mesh = Background {
            cell_px: [50.0, 40.0],
            columns: 3,
            rows: 3,
            level: (0..9).map(|k| 10.0 + 5.0 * (k % 3) as f64).collect(),
            sigma: vec![2.0; 9],
        };
        for (x, level) in [(0.0, 7.5), (25.0, 10.0), (100.0, 17.5), (150.0, 22.5)] {
            assert!((mesh.level_at(x, 60.0) - level).abs() < 1e-9, "{x}");
        }
        assert_eq!(mesh.sigma_at(0.0, 0.0), 2.0);
    }
}

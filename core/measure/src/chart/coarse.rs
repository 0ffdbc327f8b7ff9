//! A photograph of one channel, binned, and the filters that registration compares.

use rayon::prelude::*;

use crate::photograph::Photograph;

use super::picture::Grid;

/// Standard deviation of the low-pass filter over that of the high-pass filter.
const BAND: f64 = 4.0;

/// An image of `columns` x `rows` values.
#[derive(Debug, Clone)]
pub(crate) struct Plane {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) values: Vec<f64>,
}

/// A binned photograph.
#[derive(Debug, Clone)]
pub(crate) struct Coarse {
    pub(crate) plane: Plane,
    /// Photograph positions of the values.
    pub(crate) grid: Grid,
    /// Share of the usable pixels that are clipped.
    pub(crate) clipped: f64,
}

impl Coarse {
    /// Bins the pixels of `channel` to at most `largest` along the longer side, so that a mosaic has samples in every bin.
    pub(crate) fn of(photo: &Photograph, channel: usize, largest: usize) -> Self {
        let longest = photo.width.max(photo.height);
        let least = if photo.mosaic.is_some() { 2 } else { 1 };
        // Even, so that every bin has the same pixels of the mosaic.
        let bin = longest.div_ceil(largest).next_multiple_of(least);
        let (columns, rows) = ((photo.width / bin).max(1), (photo.height / bin).max(1));
        let samples = &photo.planes[photo.plane_of(channel)];
        let mut centroid = [0.0; 2];
        let mut count = 0.0;
        for index in 0..bin * bin {
            let (x, y) = (index % bin, index / bin);
            if photo.covers(channel, x, y) {
                centroid[0] += x as f64 + 0.5;
                centroid[1] += y as f64 + 0.5;
                count += 1.0;
            }
        }
        let (mut clipped, mut used) = (0.0, 0.0);
        let mut values = vec![0.0; columns * rows];
        for (index, value) in values.iter_mut().enumerate() {
            let (left, top) = (index % columns * bin, index / columns * bin);
            let (mut sum, mut weight) = (0.0, 0.0);
            for k in 0..bin * bin {
                let (x, y) = (left + k % bin, top + k / bin);
                if x >= photo.width
                    || y >= photo.height
                    || !photo.covers(channel, x, y)
                    || photo.is_bad(x, y)
                {
                    continue;
                }
                let sample = samples[y * photo.width + x];
                used += 1.0;
                clipped += f64::from(u8::from(sample >= photo.white));
                sum += f64::from(sample);
                weight += 1.0;
            }
            *value = if weight > 0.0 { sum / weight } else { 0.0 };
        }
        Self {
            plane: Plane {
                columns,
                rows,
                values,
            },
            grid: Grid {
                origin: centroid.map(|v| v / f64::max(count, 1.0)),
                step: bin as f64,
                columns,
                rows,
            },
            clipped: clipped / f64::max(used, 1.0),
        }
    }
}

impl Plane {
    /// Returns the plane after a Gaussian filter; borders repeat.
    pub(crate) fn blurred(&self, sigma: f64) -> Self {
        let radius = (3.0 * sigma).ceil().max(1.0) as i64;
        let weights: Vec<f64> = (-radius..=radius)
            .map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp())
            .collect();
        let total: f64 = weights.iter().sum();
        let near =
            |at: usize, k: i64, length: usize| (at as i64 + k).clamp(0, length as i64 - 1) as usize;
        let mut along = vec![0.0; self.values.len()];
        let rows = along.par_chunks_exact_mut(self.columns);
        let lines = self.values.par_chunks_exact(self.columns);
        rows.zip(lines).for_each(|(out, line)| {
            let padded: Vec<f64> = (-radius..self.columns as i64 + radius)
                .map(|at| line[near(0, at, self.columns)])
                .collect();
            for (first, weight) in weights.iter().enumerate() {
                add_weighted(out, &padded[first..], *weight);
            }
        });
        let mut values = vec![0.0; self.values.len()];
        let rows = values.par_chunks_exact_mut(self.columns).enumerate();
        rows.for_each(|(row, out)| {
            for (weight, k) in weights.iter().zip(-radius..=radius) {
                let first = near(row, k, self.rows) * self.columns;
                add_weighted(out, &along[first..], *weight / (total * total));
            }
        });
        Self { values, ..*self }
    }

    /// Returns the plane between two Gaussian filters, divided by its local standard deviation: independent of uneven light
    /// and of contrast. Values outside `inside` are replaced by the mean first.
    pub(crate) fn band(&self, sigma: f64, inside: &[bool]) -> Self {
        let count = inside.iter().filter(|i| **i).count().max(1) as f64;
        let mean = self
            .values
            .iter()
            .zip(inside)
            .filter(|(_, i)| **i)
            .map(|(v, _)| v)
            .sum::<f64>()
            / count;
        let filled = self
            .values
            .iter()
            .zip(inside)
            .map(|(v, i)| if *i { *v } else { mean });
        let filled = Self {
            values: filled.collect(),
            ..*self
        };
        let (fine, wide) = (filled.blurred(sigma), filled.blurred(BAND * sigma));
        let mut band = Self {
            values: fine
                .values
                .iter()
                .zip(&wide.values)
                .map(|(a, b)| a - b)
                .collect(),
            ..*self
        };
        let square = Self {
            values: band.values.iter().map(|v| v * v).collect(),
            ..*self
        };
        let local = square.blurred(2.0 * BAND * sigma);
        let floor = 1e-3 * local.values.iter().copied().fold(1e-30, f64::max);
        for (value, square) in band.values.iter_mut().zip(&local.values) {
            *value /= (square + floor).sqrt();
        }
        band
    }
}

/// Adds `values` times `weight` to `sums`, as many as there are sums.
fn add_weighted(sums: &mut [f64], values: &[f64], weight: f64) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

//! The kernels of the pixels of a light, as columns of a matrix.

use super::light_lattice::hat;
use super::vectors::dot_of_rows;
use crate::{LocalKernel, LocalKernels, RenderWindow};
use seidel_optics::error::Result;

/// Largest distance between the points at which kernels are drawn, px; they are interpolated between these.
const NODE_DISTANCE: usize = 12;
/// Mean common area of two kernels that overlap, as a share of a kernel's.
const OVERLAP_SHARE: f64 = 0.3;

/// Kernels at the nodes of a grid over a region.
pub(super) struct KernelGrid {
    first: (usize, usize),
    step: (f32, f32),
    columns: usize,
    pub(super) kernels: Vec<LocalKernel>,
}

impl KernelGrid {
    /// Draws the kernels over the pixels from `first` to `last`, both inclusive.
    pub(super) fn new(
        kernels: &LocalKernels,
        first: (usize, usize),
        last: (usize, usize),
    ) -> Result<Self> {
        let along = |first: usize, last: usize| {
            let steps = (last - first).div_ceil(NODE_DISTANCE).max(1);
            (steps + 1, (last - first).max(1) as f32 / steps as f32)
        };
        let (columns, step_x) = along(first.0, last.0);
        let (rows, step_y) = along(first.1, last.1);
        let kernels = (0..columns * rows)
            .map(|k| {
                let x = first.0 as f64 + f64::from(step_x) * (k % columns) as f64;
                let y = first.1 as f64 + f64::from(step_y) * (k / columns) as f64;
                kernels.at((x + 0.5, y + 0.5))
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            first,
            step: (step_x, step_y),
            columns,
            kernels,
        })
    }

    /// Returns the kernels around a pixel, with their weights for bilinear interpolation.
    fn around(&self, pixel: (usize, usize)) -> [(&LocalKernel, f32); 4] {
        let rows = self.kernels.len() / self.columns;
        let along = |at: usize, first: usize, step: f32, count: usize| {
            let place = (at - first) as f32 / step;
            let low = (place as usize).min(count - 2);
            (low, place - low as f32)
        };
        let (x, across) = along(pixel.0, self.first.0, self.step.0, self.columns);
        let (y, down) = along(pixel.1, self.first.1, self.step.1, rows);
        let kernel = |x: usize, y: usize| &self.kernels[y * self.columns + x];
        [
            (kernel(x, y), (1.0 - across) * (1.0 - down)),
            (kernel(x + 1, y), across * (1.0 - down)),
            (kernel(x, y + 1), (1.0 - across) * down),
            (kernel(x + 1, y + 1), across * down),
        ]
    }

    /// Returns the kernel at the node nearest to a pixel.
    pub(super) fn nearest(&self, pixel: (usize, usize)) -> &LocalKernel {
        let around = self.around(pixel);
        let heaviest = around.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        heaviest.map_or(&self.kernels[0], |(kernel, _)| kernel)
    }

    /// Returns the window of a plate of `size` that light from the pixels `first` to `last` reaches.
    pub(super) fn window(&self, last: (usize, usize), size: (usize, usize)) -> RenderWindow {
        let ends = |of: &dyn Fn(&LocalKernel) -> (i32, i32)| {
            let all = self.kernels.iter().map(of);
            all.fold((0, 1), |(low, high), (a, b)| (low.min(a), high.max(b)))
        };
        let (left, right) = ends(&|k| (k.left, k.left + k.width as i32));
        let (top, bottom) = ends(&|k| (k.top, k.top + k.height as i32));
        let low = |first: usize, reach: i32| first.saturating_sub(reach.unsigned_abs() as usize);
        let high = |last: usize, reach: i32, size: usize| (last + reach as usize).min(size);
        let (column, row) = (low(self.first.0, left), low(self.first.1, top));
        RenderWindow {
            column,
            row,
            width: high(last.0, right, size.0) - column,
            height: high(last.1, bottom, size.1) - row,
        }
    }

    /// Returns the light that a source of unit brightness at `pixel` brings to the samples of `window`. Its light is spread
    /// over the pixels around by [`hat`] weights of this `spacing`.
    pub(super) fn column(
        &self,
        pixel: (usize, usize),
        spacing: usize,
        window: RenderWindow,
    ) -> Column {
        let (x, y) = (
            pixel.0 as i32 - window.column as i32,
            pixel.1 as i32 - window.row as i32,
        );
        let around = self.around(pixel);
        let margin = spacing as i32 - 1;
        let ends = |of: &dyn Fn(&LocalKernel) -> (i32, i32)| {
            let all = around.iter().map(|(kernel, _)| of(kernel));
            let (low, high) = all.fold((i32::MAX, i32::MIN), |(low, high), (a, b)| {
                (low.min(a), high.max(b))
            });
            (low - margin, (high - low + 2 * margin) as usize)
        };
        let (left, width) = ends(&|k| (k.left, k.left + k.width as i32));
        let (top, height) = ends(&|k| (k.top, k.top + k.height as i32));
        let mut blended = vec![0.0; width * height];
        for (kernel, share) in around {
            for (row, samples) in kernel.weights.chunks_exact(kernel.width.max(1)).enumerate() {
                let start = ((kernel.top - top) as usize + row) * width;
                let out = &mut blended[start + (kernel.left - left) as usize..];
                for (out, sample) in out.iter_mut().zip(samples) {
                    *out += share * sample;
                }
            }
        }
        if spacing > 1 {
            spread(&mut blended, width, spacing);
        }
        Column::cut(&blended, width, (x + left, y + top), window)
    }

    /// Returns the number of samples of a kernel.
    pub(super) fn kernel_area(&self) -> usize {
        self.kernels[0].weights.len()
    }

    /// Returns the largest distance of sources, px: this share of the kernels' smaller side.
    pub(super) fn max_spacing(&self, share: f64) -> usize {
        let sides = (self.kernels.iter()).map(|kernel| kernel.width.min(kernel.height));
        ((share * sides.min().unwrap_or(0) as f64) as usize).max(1)
    }

    /// Returns about how many multiplications the inner products of `count` columns of this region take.
    pub(super) fn work(&self, count: usize, last: (usize, usize)) -> f64 {
        let kernel = &self.kernels[0];
        // The share of pairs whose kernels overlap, along one axis.
        let share = |kernel: usize, first: usize, last: usize| {
            (2.0 * kernel as f64 / (last - first + 1) as f64).min(1.0)
        };
        let pairs = 0.5
            * (count * count) as f64
            * share(kernel.width, self.first.0, last.0)
            * share(kernel.height, self.first.1, last.1);
        pairs * OVERLAP_SHARE * (kernel.width * kernel.height) as f64
    }
}

/// A column of a matrix over the samples of a window: zero outside a rectangle.
pub(super) struct Column {
    left: usize,
    top: usize,
    width: usize,
    /// The samples of the rectangle, row-major.
    weights: Vec<f32>,
}

impl Column {
    /// Returns a column over a window `width` samples wide, all of whose samples are given.
    pub(super) fn full(width: usize, weights: Vec<f32>) -> Self {
        Self {
            left: 0,
            top: 0,
            width,
            weights,
        }
    }

    /// Cuts what lies in `window` from a plane of `width` columns whose first sample is at `first`, column and row of the
    /// window.
    fn cut(plane: &[f32], width: usize, first: (i32, i32), window: RenderWindow) -> Self {
        let inside = |first: i32, count: usize, size: usize| {
            let end = |at: i32| at.clamp(0, size as i32);
            end(first)..end(first + count as i32)
        };
        let columns = inside(first.0, width, window.width);
        let rows = inside(first.1, plane.len() / width.max(1), window.height);
        let weights = rows.clone().flat_map(|y| {
            let start = (y - first.1) as usize * width + (columns.start - first.0) as usize;
            &plane[start..start + columns.len()]
        });
        Self {
            left: columns.start as usize,
            top: rows.start as usize,
            width: columns.len(),
            weights: weights.copied().collect(),
        }
    }

    /// Returns the sum of the squares of the samples.
    pub(super) fn square_sum(&self) -> f64 {
        self.weights.iter().map(|w| f64::from(*w).powi(2)).sum()
    }

    fn height(&self) -> usize {
        self.weights.len() / self.width.max(1)
    }

    /// Returns the column with each sample multiplied by its element of `gains`, of a window `window_width` samples wide.
    pub(super) fn scaled(&self, gains: &[f32], window_width: usize) -> Self {
        let rows = self.weights.chunks_exact(self.width.max(1)).enumerate();
        let weights = rows.flat_map(|(y, row)| {
            let gains = &gains[(self.top + y) * window_width + self.left..];
            row.iter().zip(gains).map(|(weight, gain)| weight * gain)
        });
        Self {
            weights: weights.collect(),
            ..*self
        }
    }

    /// Adds `gain` times this column to `plane`, a window `window_width` samples wide.
    pub(super) fn add_to(&self, plane: &mut [f32], window_width: usize, gain: f32) {
        for (y, row) in self.weights.chunks_exact(self.width.max(1)).enumerate() {
            let out = &mut plane[(self.top + y) * window_width + self.left..];
            for (out, weight) in out.iter_mut().zip(row) {
                *out += gain * weight;
            }
        }
    }

    /// Adds `gain` times this column to `plane`, each sample multiplied by its element of `weights`.
    pub(super) fn add_weighted_to(
        &self,
        plane: &mut [f32],
        weights: &[f32],
        window_width: usize,
        gain: f32,
    ) {
        for (y, row) in self.weights.chunks_exact(self.width.max(1)).enumerate() {
            let start = (self.top + y) * window_width + self.left;
            let out = plane[start..].iter_mut().zip(&weights[start..]);
            for ((out, weight), sample) in out.zip(row) {
                *out += gain * weight * sample;
            }
        }
    }

    /// Returns the inner product with a plane of a window `window_width` samples wide.
    pub(super) fn dot_plane(&self, plane: &[f32], window_width: usize) -> f64 {
        let rows = self.weights.chunks_exact(self.width.max(1)).enumerate();
        dot_of_rows(rows.map(|(y, row)| {
            let start = (self.top + y) * window_width + self.left;
            (row, &plane[start..start + self.width])
        }))
    }

    /// Returns the number of samples of the rectangle.
    pub(super) fn area(&self) -> usize {
        self.weights.len()
    }

    /// Returns the inner product of two columns.
    pub(super) fn dot(&self, other: &Self) -> f64 {
        let left = self.left.max(other.left);
        let right = (self.left + self.width).min(other.left + other.width);
        let top = self.top.max(other.top);
        let bottom = (self.top + self.height()).min(other.top + other.height());
        if left >= right {
            return 0.0;
        }
        let part = |of: &Self, y: usize| (y - of.top) * of.width + left - of.left;
        dot_of_rows((top..bottom).map(|y| {
            let (a, b) = (part(self, y), part(other, y));
            let length = right - left;
            (&self.weights[a..a + length], &other.weights[b..b + length])
        }))
    }
}

/// Convolves `plane`, `width` samples wide, with [`hat`] weights along rows and columns. Its border of `spacing` - 1 samples
/// must be 0.
fn spread(plane: &mut [f32], width: usize, spacing: usize) {
    let reach = spacing - 1;
    let weights: Vec<f32> = hat(spacing).collect();
    for stride in [1, width] {
        let before = plane.to_vec();
        plane.fill(0.0);
        for (at, sample) in before.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            for (k, weight) in weights.iter().enumerate() {
                plane[at + k * stride - reach * stride] += weight * sample;
            }
        }
    }
}

//! The kernels of the pixels of a light, as columns of a matrix.

use super::vectors::short_dot;
use crate::{LocalKernel, LocalKernels, RenderWindow};
use seidel_optics::error::Result;

/// Largest distance between the points at which kernels are drawn, px; they are interpolated between these.
const NODE_DISTANCE: usize = 12;

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

    /// Returns the light that a source of unit light at `pixel` brings to the samples of `window`.
    pub(super) fn column(&self, pixel: (usize, usize), window: RenderWindow) -> Column {
        let around = self.around(pixel);
        let rows = around.iter().map(|(kernel, _)| {
            let top = pixel.1 as i32 + kernel.top - window.row as i32;
            (top, top + kernel.height as i32)
        });
        let (top, bottom) = rows.fold((i32::MAX, i32::MIN), |(low, high), (a, b)| {
            (low.min(a), high.max(b))
        });
        let inside = |row: i32| row.clamp(0, window.height as i32) as usize;
        let (top, bottom) = (inside(top), inside(bottom));
        let mut column = Column {
            first: top * window.width,
            weights: vec![0.0; bottom.saturating_sub(top) * window.width],
        };
        for (kernel, share) in around {
            column.add(window, pixel, kernel, share);
        }
        column
    }
}

/// A column of a matrix over the samples of a window: zero but for consecutive samples.
pub(super) struct Column {
    /// The first sample that is not zero.
    pub(super) first: usize,
    /// The samples from there on.
    pub(super) weights: Vec<f32>,
}

impl Column {
    /// Returns the samples that are not zero.
    pub(super) fn span(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.weights.len()
    }

    /// Returns the column with each sample multiplied by its element of `gains`.
    pub(super) fn scaled(&self, gains: &[f32]) -> Self {
        let pairs = self.weights.iter().zip(&gains[self.span()]);
        Self {
            first: self.first,
            weights: pairs.map(|(weight, gain)| weight * gain).collect(),
        }
    }

    /// Returns the inner product of two columns.
    pub(super) fn dot(&self, other: &Self) -> f64 {
        let from = self.first.max(other.first);
        let to = self.span().end.min(other.span().end);
        if to <= from {
            return 0.0;
        }
        short_dot(
            &self.weights[from - self.first..to - self.first],
            &other.weights[from - other.first..to - other.first],
        )
    }

    /// Adds `share` of the `kernel` of the source at `pixel`.
    fn add(
        &mut self,
        window: RenderWindow,
        pixel: (usize, usize),
        kernel: &LocalKernel,
        share: f32,
    ) {
        let left = pixel.0 as i32 + kernel.left - window.column as i32;
        let top = pixel.1 as i32 + kernel.top - window.row as i32;
        for (y, row) in kernel.weights.chunks_exact(kernel.width.max(1)).enumerate() {
            let y = top + y as i32;
            if !(0..window.height as i32).contains(&y) {
                continue;
            }
            for (x, weight) in row.iter().enumerate() {
                let x = left + x as i32;
                if (0..window.width as i32).contains(&x) {
                    self.weights[y as usize * window.width + x as usize - self.first] +=
                        share * weight;
                }
            }
        }
    }
}

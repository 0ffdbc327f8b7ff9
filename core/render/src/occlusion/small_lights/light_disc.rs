//! The blurred light of a few pixels in one plane.

use crate::{LocalKernel, RenderWindow, Scene};

/// The blurred light of a few pixels in one plane.
pub(super) struct LightDisc {
    pub(super) plane: usize,
    /// First column and row on the plate; may be outside it.
    pub(super) left: i32,
    top: i32,
    width: usize,
    /// Light of each pixel, row-major.
    samples: Vec<f32>,
}

impl LightDisc {
    /// Spreads the `lights` of pixels, column first, by a kernel.
    pub(super) fn new(
        plane: usize,
        lights: &[((usize, usize), f32)],
        kernel: &LocalKernel,
    ) -> Self {
        let ends = |of: fn(&(usize, usize)) -> usize| {
            let all = lights.iter().map(|(pixel, _)| of(pixel) as i32);
            all.fold((i32::MAX, i32::MIN), |(low, high), at| {
                (low.min(at), high.max(at))
            })
        };
        let (columns, rows) = (ends(|p| p.0), ends(|p| p.1));
        let width = kernel.width + (columns.1 - columns.0) as usize;
        let height = kernel.height + (rows.1 - rows.0) as usize;
        let mut samples = vec![0.0; width * height];
        for (pixel, light) in lights {
            let (dx, dy) = (pixel.0 as i32 - columns.0, pixel.1 as i32 - rows.0);
            let first = dy as usize * width + dx as usize;
            let lines = kernel.weights.chunks_exact(kernel.width.max(1));
            for (line, weights) in lines.enumerate() {
                let out = &mut samples[first + line * width..];
                for (sample, weight) in out.iter_mut().zip(weights) {
                    *sample += light * weight;
                }
            }
        }
        Self {
            plane,
            left: columns.0 + kernel.left,
            top: rows.0 + kernel.top,
            width,
            samples,
        }
    }

    /// First and end column.
    pub(super) fn columns(&self) -> (i32, i32) {
        (self.left, self.left + self.width as i32)
    }

    /// First and end row.
    pub(super) fn rows(&self) -> (i32, i32) {
        let height = self.samples.len() / self.width.max(1);
        (self.top, self.top + height as i32)
    }

    /// Largest distance of its pixels from a point along x or y, px.
    pub(super) fn reach_px(&self, at: (f64, f64)) -> f64 {
        let (x, y) = at;
        let (columns, rows) = (self.columns(), self.rows());
        let reach =
            |(first, end): (i32, i32), at: f64| (at - f64::from(first)).max(f64::from(end) - at);
        reach(columns, x).max(reach(rows, y))
    }

    pub(super) fn is_lit(&self, column: i32, row: i32) -> bool {
        let (columns, rows) = (self.columns(), self.rows());
        if !(columns.0..columns.1).contains(&column) || !(rows.0..rows.1).contains(&row) {
            return false;
        }
        let line = (row - self.top) as usize * self.width;
        self.samples[line + (column - self.left) as usize] != 0.0
    }

    /// Multiplies the light by `share`.
    pub(super) fn dim(&mut self, share: f32) {
        for sample in &mut self.samples {
            *sample *= share;
        }
    }

    pub(super) fn line_mut(&mut self, row: i32) -> Option<&mut [f32]> {
        let (first, end) = self.rows();
        let line = (first..end)
            .contains(&row)
            .then(|| (row - first) as usize)?;
        Some(&mut self.samples[line * self.width..][..self.width])
    }

    /// Adds the light to `out`, a `window` of a plane; light that leaves the plate is lost. `transmittance` takes the index of a pixel
    /// of the plate.
    pub(super) fn add(
        &self,
        out: &mut [f32],
        scene: &Scene,
        window: RenderWindow,
        transmittance: impl Fn(usize) -> f32,
    ) {
        let place = |at: i32, size: usize, first: usize, count: usize| {
            let at = usize::try_from(at).ok().filter(|at| *at < size)?;
            Some((at, at.checked_sub(first).filter(|k| *k < count)?))
        };
        for (line, samples) in self.samples.chunks_exact(self.width.max(1)).enumerate() {
            let row = self.top + line as i32;
            let Some((row, y)) = place(row, scene.height, window.row, window.height) else {
                continue;
            };
            for (k, sample) in samples.iter().enumerate() {
                let column = self.left + k as i32;
                let column = place(column, scene.width, window.column, window.width);
                if let Some((column, x)) = column.filter(|_| *sample != 0.0) {
                    out[y * window.width + x] += sample * transmittance(row * scene.width + column);
                }
            }
        }
    }
}

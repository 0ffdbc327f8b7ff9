//! Rectangles of samples at one pyramid level; beyond them there is nothing.

use rayon::prelude::*;

/// A rectangle of samples whose first lies at column `left` and row `top` of the level.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: &'a [f32],
}

/// A [`View`] that owns its samples.
#[derive(Default, Clone)]
pub(super) struct Image {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: Vec<f32>,
}

impl Image {
    /// An image of zeros.
    pub(super) fn zeros((left, top): (i32, i32), (width, height): (usize, usize)) -> Self {
        Self {
            left,
            top,
            width,
            height,
            samples: vec![0.0; width * height],
        }
    }

    pub(super) fn view(&self) -> View<'_> {
        View {
            left: self.left,
            top: self.top,
            width: self.width,
            height: self.height,
            samples: &self.samples,
        }
    }
}

impl Image {
    /// The rectangle of some columns and rows from `place` on, zero where nothing is.
    pub(super) fn cropped(&self, (place, size): ((i32, i32), (usize, usize))) -> Self {
        let mut part = Self::zeros(place, size);
        part.add(self);
        part
    }

    /// Adds the samples of `other` that lie in this image.
    pub(super) fn add(&mut self, other: &Self) {
        let place = (self.left, self.top);
        add_to(place, self.width, &mut self.samples, other);
    }

    /// Adds the samples of `parts` that lie in this image, in order, so that sums do not depend on threads.
    pub(super) fn add_all(&mut self, parts: &[Self]) {
        let (left, top, width) = (self.left, self.top, self.width);
        let bands = self.samples.par_chunks_mut(BAND * width.max(1));
        bands.enumerate().for_each(|(band, samples)| {
            let place = (left, top + (band * BAND) as i32);
            for part in parts {
                add_to(place, width, samples, part);
            }
        });
    }
}

/// Rows to which one thread adds.
const BAND: usize = 32;

/// Adds the samples of `other` that lie in an image `width` wide from `place` on.
fn add_to((left, top): (i32, i32), width: usize, samples: &mut [f32], other: &Image) {
    let end = |start: i32, size: usize| start + size as i32;
    let columns = left.max(other.left)..end(left, width).min(end(other.left, other.width));
    let height = samples.len() / width.max(1);
    let rows = top.max(other.top)..end(top, height).min(end(other.top, other.height));
    if columns.is_empty() {
        return;
    }
    for row in rows {
        let to = (row - top) as usize * width + (columns.start - left) as usize;
        let from = (row - other.top) as usize * other.width + (columns.start - other.left) as usize;
        let out = &mut samples[to..to + columns.len()];
        for (out, sample) in out.iter_mut().zip(&other.samples[from..]) {
            *out += sample;
        }
    }
}

impl View<'_> {
    /// Copies the rectangle of `size` (columns, rows) from (`left`, `top`) on into `out`, rows of
    /// `stride`, with zeros for what lies beyond and for the rest of each row. Whether any is not zero.
    pub(super) fn copy(
        &self,
        (left, top): (i32, i32),
        (width, height): (usize, usize),
        stride: usize,
        out: &mut Vec<f32>,
    ) -> bool {
        out.resize(height * stride, 0.0);
        let start = (self.left - left).clamp(0, width as i32) as usize;
        let end = (self.left + self.width as i32 - left).clamp(0, width as i32) as usize;
        let mut lit = false;
        for (row, line) in out.chunks_exact_mut(stride).enumerate() {
            let y = top + row as i32 - self.top;
            if !(0..self.height as i32).contains(&y) || end <= start {
                line.fill(0.0);
                continue;
            }
            let first = y as usize * self.width + (left + start as i32 - self.left) as usize;
            let inside = &self.samples[first..first + end - start];
            line[..start].fill(0.0);
            line[start..end].copy_from_slice(inside);
            line[end..].fill(0.0);
            lit = lit || inside.iter().any(|v| *v != 0.0);
        }
        lit
    }
}

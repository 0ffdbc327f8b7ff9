//! Rectangles of samples at one pyramid level; everything beyond a rectangle is zero.

use rayon::prelude::*;

/// Columns and rows of a plate or of a level of its pyramid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) width: usize,
    pub(super) height: usize,
}

/// A rectangle of a level's pixels, which may lie beyond the plate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Rect {
    /// First column.
    pub(super) left: i32,
    /// First row.
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Rect {
    /// Returns the rectangle that holds both; empty ones do not count.
    pub(super) fn joined(self, other: Self) -> Self {
        if self.width == 0 {
            return other;
        }
        if other.width == 0 {
            return self;
        }
        let (left, top) = (self.left.min(other.left), self.top.min(other.top));
        let end = |start: i32, size: usize| start + size as i32;
        let right = end(self.left, self.width).max(end(other.left, other.width));
        let bottom = end(self.top, self.height).max(end(other.top, other.height));
        Self {
            left,
            top,
            width: (right - left) as usize,
            height: (bottom - top) as usize,
        }
    }
}

/// Borrowed samples of a rectangle, row-major.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    /// First column.
    pub(super) left: i32,
    /// First row.
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: &'a [f32],
}

/// Owned samples of a rectangle, row-major.
#[derive(Default, Clone)]
pub(super) struct Image {
    /// First column.
    pub(super) left: i32,
    /// First row.
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: Vec<f32>,
}

impl Image {
    /// Zeros over `rect`.
    pub(super) fn zeros(rect: Rect) -> Self {
        Self {
            left: rect.left,
            top: rect.top,
            width: rect.width,
            height: rect.height,
            samples: vec![0.0; rect.width * rect.height],
        }
    }

    pub(super) fn rect(&self) -> Rect {
        Rect {
            left: self.left,
            top: self.top,
            width: self.width,
            height: self.height,
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

    /// Returns the samples within `rect`, zero beyond this image.
    pub(super) fn cropped(&self, rect: Rect) -> Self {
        let mut part = Self::zeros(rect);
        part.add(self);
        part
    }

    /// Adds the samples of `other` that lie in this image.
    pub(super) fn add(&mut self, other: &Self) {
        add_rows(self.left, self.top, self.width, &mut self.samples, other);
    }

    /// Adds the samples of `parts` that lie in this image, in order, so that sums do not depend on threads.
    pub(super) fn add_all(&mut self, parts: &[Self]) {
        let (left, top, width) = (self.left, self.top, self.width);
        let bands = self.samples.par_chunks_mut(BAND * width.max(1));
        bands.enumerate().for_each(|(band, samples)| {
            let top = top + (band * BAND) as i32;
            for part in parts {
                add_rows(left, top, width, samples, part);
            }
        });
    }
}

/// Rows that one thread adds.
const BAND: usize = 32;

/// Adds the samples of `other` that lie in an image of `width` columns starting at (`left`, `top`).
fn add_rows(left: i32, top: i32, width: usize, samples: &mut [f32], other: &Image) {
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

impl<'a> View<'a> {
    /// A whole plane of a plate.
    pub(super) fn whole(size: Size, samples: &'a [f32]) -> Self {
        Self {
            left: 0,
            top: 0,
            width: size.width,
            height: size.height,
            samples,
        }
    }

    /// Copies `rect` into `out` with rows of `stride` samples, zero beyond the view and at the end of each row.
    /// Returns whether any sample is not zero.
    pub(super) fn copy(&self, rect: Rect, stride: usize, out: &mut [f32]) -> bool {
        let Rect {
            left, top, width, ..
        } = rect;
        let start = (self.left - left).clamp(0, width as i32) as usize;
        let end = (self.left + self.width as i32 - left).clamp(0, width as i32) as usize;
        let mut lit = false;
        for (row, line) in out.chunks_exact_mut(stride).take(rect.height).enumerate() {
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

//! Rectangles of samples at one pyramid level; beyond them there is nothing.

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
        let end = |start: i32, size: usize| start + size as i32;
        let columns =
            self.left.max(other.left)..end(self.left, self.width).min(end(other.left, other.width));
        let rows =
            self.top.max(other.top)..end(self.top, self.height).min(end(other.top, other.height));
        if columns.is_empty() {
            return;
        }
        for row in rows {
            let start = |image: &Self| {
                (row - image.top) as usize * image.width + (columns.start - image.left) as usize
            };
            let (to, from) = (start(self), start(other));
            let out = &mut self.samples[to..to + columns.len()];
            for (out, sample) in out.iter_mut().zip(&other.samples[from..]) {
                *out += sample;
            }
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

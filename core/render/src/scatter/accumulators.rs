//! Accumulators of scattered light: a single-precision strip for one source row, a double-precision band for many.
//!
//! A strip is filled in single precision at full vector width and emptied into its band after each source row. So no
//! single-precision sum has more terms than a kernel has columns; sums of hundreds of thousands of small terms would
//! lose digits.

use crate::Edges;
use seidel_optics::psf::KernelRows;
use std::ops::Range;

/// The scattered light of one source row in all planes, on rows around it and beyond the plate's edges.
pub(crate) struct Strip {
    plate_width: usize,
    /// Plate column of the first sample; not positive.
    left: i32,
    /// Samples per row.
    stride: usize,
    /// Rows kept, relative to the source row.
    rows: Range<i32>,
    /// Rows with light added since the strip was last emptied.
    used: Range<i32>,
    planes: Vec<Vec<f32>>,
}

impl Strip {
    pub(crate) fn new(plate_width: usize, plane_count: usize) -> Self {
        Self {
            plate_width,
            left: 0,
            stride: plate_width,
            rows: 0..0,
            used: 0..0,
            planes: vec![Vec::new(); plane_count],
        }
    }

    /// Makes room for `kernel` around plate column `column`; [`Strip::add`] relies on it.
    pub(crate) fn make_room(&mut self, kernel: &KernelRows, column: i32) {
        let (columns, rows) = (kernel.columns(), kernel.rows());
        self.used = if self.used.is_empty() {
            rows.clone()
        } else {
            self.used.start.min(rows.start)..self.used.end.max(rows.end)
        };
        let beyond_left = self.left - (column + columns.start);
        let beyond_right = column + columns.end - (self.left + self.stride as i32);
        if beyond_left <= 0
            && beyond_right <= 0
            && self.rows.start <= rows.start
            && rows.end <= self.rows.end
        {
            return;
        }
        // Half as much again as needed: blur grows smoothly, so few reallocations are enough.
        let spare = |missing: i32| {
            if missing > 0 {
                missing + missing / 2
            } else {
                0
            }
        };
        let left = self.left - spare(beyond_left);
        let stride = (self.left - left) as usize + self.stride + spare(beyond_right) as usize;
        let all = if self.rows.is_empty() {
            rows
        } else {
            self.rows.start - spare(self.rows.start - rows.start)
                ..self.rows.end + spare(rows.end - self.rows.end)
        };
        for plane in &mut self.planes {
            let mut roomy = vec![0.0; stride * all.len()];
            for (row, line) in self.rows.clone().zip(plane.chunks_exact(self.stride)) {
                let start = (row - all.start) as usize * stride + (self.left - left) as usize;
                roomy[start..start + self.stride].copy_from_slice(line);
            }
            *plane = roomy;
        }
        (self.left, self.stride, self.rows) = (left, stride, all);
    }

    /// Adds `gain` times the kernel's weights around plate column `column`.
    pub(crate) fn add(&mut self, plane: usize, kernel: &KernelRows, column: i32, gain: f32) {
        let samples = self.planes[plane].as_mut_slice();
        pulp::Arch::new().dispatch(AddKernel {
            samples,
            left: self.left - column,
            top: self.rows.start,
            stride: self.stride,
            kernel,
            gain,
        });
    }

    /// Moves all light to `band`; the strip belongs to plate row `source_row`.
    pub(crate) fn empty_into(&mut self, band: &mut Band, source_row: i32) {
        let used = std::mem::replace(&mut self.used, 0..0);
        for row in used.clone() {
            let Some(target) = fold(source_row + row, band.height, band.edges) else {
                continue;
            };
            band.make_room(target);
            for (plane, gathered) in self.planes.iter().zip(&mut band.planes) {
                let start = (row - self.rows.start) as usize * self.stride;
                let line = &plane[start..start + self.stride];
                let out = (target - band.rows.start) * self.plate_width;
                let out = &mut gathered[out..out + self.plate_width];
                add_row(line, self.left, out, band.edges);
            }
        }
        let cleared = (used.start - self.rows.start) as usize * self.stride
            ..(used.end - self.rows.start) as usize * self.stride;
        for plane in &mut self.planes {
            plane[cleared.clone()].fill(0.0);
        }
    }
}

/// The loop of [`Strip::add`]. A type rather than a closure, whose shim is not always inlined: its loops would then be
/// compiled without vector instructions.
struct AddKernel<'a> {
    samples: &'a mut [f32],
    /// Column of the first sample, relative to the source pixel.
    left: i32,
    /// Row of the first sample, relative to the source pixel.
    top: i32,
    stride: usize,
    kernel: &'a KernelRows,
    gain: f32,
}

impl pulp::WithSimd for AddKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for span in self.kernel.spans() {
            let (row, column, weights) = (span.row, span.column, span.weights);
            let start = (row - self.top) as usize * self.stride + (column - self.left) as usize;
            let out = &mut self.samples[start..start + weights.len()];
            let (out, _) = out.as_chunks_mut::<{ KernelRows::PADDING }>();
            let (weights, _) = weights.as_chunks::<{ KernelRows::PADDING }>();
            for (out, weights) in out.iter_mut().zip(weights) {
                // Copies tell the compiler that the two buffers do not overlap.
                let (mut block, weights) = (*out, *weights);
                for (light, weight) in block.iter_mut().zip(weights) {
                    *light += self.gain * weight;
                }
                *out = block;
            }
        }
    }
}

/// The loop over the part of a row on the plate; a type for the reason given at [`AddKernel`].
struct AddInside<'a> {
    inside: &'a [f32],
    out: &'a mut [f64],
}

impl pulp::WithSimd for AddInside<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for (out, light) in self.out.iter_mut().zip(self.inside) {
            *out += f64::from(*light);
        }
    }
}

/// Adds a strip's row, which starts at plate column `left`, to a row of the plate.
fn add_row(line: &[f32], left: i32, out: &mut [f64], edges: Edges) {
    let (before, rest) = line.split_at(-left as usize);
    let (inside, after) = rest.split_at(out.len());
    pulp::Arch::new().dispatch(AddInside { inside, out });
    let width = out.len();
    let mut outside = |light: f32, column: i32| {
        if light != 0.0
            && let Some(column) = fold(column, width, edges)
        {
            out[column] += f64::from(light);
        }
    };
    for (light, column) in before.iter().zip(left..) {
        outside(*light, column);
    }
    for (light, column) in after.iter().zip(width as i32..) {
        outside(*light, column);
    }
}

/// Returns the pixel on which light at `index` lands along an axis of `size` pixels.
///
/// Mirrored edges reflect at the outer edges of the first and last pixel, as often as needed. `None` where the light is
/// lost.
pub(crate) fn fold(index: i32, size: usize, edges: Edges) -> Option<usize> {
    let size = i32::try_from(size).expect("plate sizes are checked to fit");
    if (0..size).contains(&index) {
        return Some(index as usize);
    }
    match edges {
        Edges::Black => None,
        Edges::Mirror => {
            let index = index.rem_euclid(2 * size);
            Some(index.min(2 * size - 1 - index) as usize)
        }
    }
}

/// The scattered light of a band of source rows, on all plate rows that it reaches.
pub(crate) struct Band {
    width: usize,
    height: usize,
    edges: Edges,
    rows: Range<usize>,
    planes: Vec<Vec<f64>>,
}

impl Band {
    /// An empty band on a plate of `width` x `height` pixels.
    pub(crate) fn new(width: usize, height: usize, edges: Edges, plane_count: usize) -> Self {
        Self {
            width,
            height,
            edges,
            rows: 0..0,
            planes: vec![Vec::new(); plane_count],
        }
    }

    /// Returns the memory held, bytes.
    pub(crate) fn size_bytes(&self) -> usize {
        self.planes.len() * self.rows.len() * self.width * size_of::<f64>()
    }

    /// Adds this band's light to whole planes.
    pub(crate) fn merge_into(&self, total: &mut [Vec<f64>]) {
        let place = self.rows.start * self.width..self.rows.end * self.width;
        for (total, plane) in total.iter_mut().zip(&self.planes) {
            for (total, light) in total[place.clone()].iter_mut().zip(plane) {
                *total += light;
            }
        }
    }

    /// Makes room for plate row `row`.
    fn make_room(&mut self, row: usize) {
        if self.rows.contains(&row) {
            return;
        }
        let rows = if self.rows.is_empty() {
            row..row + 1
        } else {
            self.rows.start.min(row)..self.rows.end.max(row + 1)
        };
        for plane in &mut self.planes {
            if rows.start < self.rows.start && !self.rows.is_empty() {
                let added = (self.rows.start - rows.start) * self.width;
                plane.splice(0..0, std::iter::repeat_n(0.0, added));
            }
            plane.resize(rows.len() * self.width, 0.0);
        }
        self.rows = rows;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_mirrors_at_the_outer_edges() {
        let folded: Vec<_> = (-7..=8)
            .map(|index| fold(index, 3, Edges::Mirror).expect("mirrors keep light"))
            .collect();
        assert_eq!(folded, [0, 0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1, 2]);
        assert_eq!(fold(-1, 3, Edges::Black), None);
        assert_eq!(fold(2, 3, Edges::Black), Some(2));
        assert_eq!(fold(-5, 1, Edges::Mirror), Some(0));
    }
}

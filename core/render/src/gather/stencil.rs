//! Stencils: the weights with which an output pixel gathers its sources.

use seidel_optics::psf::KernelRows;
use std::ops::Range;

/// Weights by the offset of a source from an output pixel, column by column. The stencil of a single kernel is that
/// kernel mirrored at its source.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Stencil {
    /// Offset of the first column.
    pub(super) left: i32,
    /// Offset of the first row.
    pub(super) top: i32,
    /// Columns.
    pub(super) width: usize,
    /// Rows.
    pub(super) height: usize,
    /// Weights, column after column.
    pub(super) weights: Vec<f32>,
}

impl Stencil {
    /// A stencil of zeros over `columns` and `rows` of offsets.
    pub(super) fn zeros(columns: Range<i32>, rows: Range<i32>) -> Self {
        let (width, height) = (columns.len(), rows.len());
        Self {
            left: columns.start,
            top: rows.start,
            width,
            height,
            weights: vec![0.0; width * height],
        }
    }

    /// Mirrors a drawn kernel at its source and divides it by its sum. Takes the weights at offsets up to `reach` along x
    /// and y, or all.
    pub(super) fn from_kernel(drawn: &KernelRows, reach: Option<[i32; 2]>) -> Self {
        let (columns, rows) = (drawn.columns(), drawn.rows());
        let mut columns = 1 - columns.end..1 - columns.start;
        let mut rows = 1 - rows.end..1 - rows.start;
        if let Some([x, y]) = reach {
            (columns, rows) = (within(columns, x), within(rows, y));
        }
        let mut stencil = Self::zeros(columns, rows);
        let (columns, rows) = (stencil.columns(), stencil.rows());
        let share = (1.0 / drawn.sum()) as f32;
        for span in drawn.spans().filter(|span| rows.contains(&-span.row)) {
            let y = (-span.row - stencil.top) as usize;
            // The offset of weight k is -(column + k).
            let first = (1 - columns.end - span.column).max(0) as usize;
            let end = (1 - columns.start - span.column).max(0) as usize;
            let end = end.min(span.weights.len());
            for (k, weight) in (first..end).zip(span.weights.iter().skip(first)) {
                let x = (-(span.column + k as i32) - stencil.left) as usize;
                stencil.weights[x * stencil.height + y] = share * weight;
            }
        }
        stencil
    }

    /// Turns offsets of sources from a target into those of targets from a source.
    pub(super) fn mirrored(mut self) -> Self {
        (self.left, self.top) = (1 - self.columns().end, 1 - self.rows().end);
        self.weights.reverse();
        self
    }

    /// Returns the stencil mirrored along x and y, as `along` says.
    pub(super) fn mirrored_along(&self, along: [bool; 2]) -> Self {
        let mut out = self.clone();
        if along[0] {
            out.left = 1 - self.columns().end;
            let columns = self.weights.chunks_exact(self.height.max(1)).rev();
            let lines = out.weights.chunks_exact_mut(self.height.max(1));
            lines
                .zip(columns)
                .for_each(|(out, line)| out.copy_from_slice(line));
        }
        if along[1] {
            out.top = 1 - self.rows().end;
            let columns = out.weights.chunks_exact_mut(self.height.max(1));
            columns.for_each(<[f32]>::reverse);
        }
        out
    }

    /// Returns the column offsets covered.
    pub(super) fn columns(&self) -> Range<i32> {
        self.left..self.left + self.width as i32
    }

    /// Returns the row offsets covered.
    pub(super) fn rows(&self) -> Range<i32> {
        self.top..self.top + self.height as i32
    }

    /// Returns the weights of column `x`, counted from the first.
    pub(super) fn column(&self, x: usize) -> &[f32] {
        &self.weights[x * self.height..(x + 1) * self.height]
    }

    /// Returns the row offsets and weights of the column at offset `x`, from its first to its last non-zero weight.
    pub(super) fn nonzero_column(&self, x: i32) -> (Range<i32>, &[f32]) {
        if !self.columns().contains(&x) {
            return (0..0, &[]);
        }
        let column = self.column((x - self.left) as usize);
        let first = column.iter().position(|w| *w != 0.0).unwrap_or(0);
        let end = column
            .iter()
            .rposition(|w| *w != 0.0)
            .map_or(first, |k| k + 1);
        let start = self.top + first as i32;
        (start..start + (end - first) as i32, &column[first..end])
    }

    /// Returns the sum of all weights.
    pub(super) fn sum(&self) -> f64 {
        self.weights.iter().map(|w| f64::from(*w)).sum()
    }

    /// Adds `gain` times `other` moved by (`dx`, `dy`), all of which this stencil covers.
    fn add(&mut self, other: &Self, dx: i32, dy: i32, gain: f32) {
        let x = (other.left + dx - self.left) as usize;
        let y = (other.top + dy - self.top) as usize;
        for (column, weights) in other.weights.chunks_exact(other.height.max(1)).enumerate() {
            let start = (x + column) * self.height + y;
            let out = &mut self.weights[start..start + other.height];
            for (out, weight) in out.iter_mut().zip(weights) {
                *out += gain * weight;
            }
        }
    }

    /// Adds `other` times the separable weights `across` and `down`, one for each column and row of this stencil.
    /// Weights of `other` that this stencil does not cover are skipped.
    pub(super) fn add_weighted(&mut self, other: &Self, across: &[f32], down: &[f32]) {
        let columns = overlap(self.columns(), other.columns());
        let rows = overlap(self.rows(), other.rows());
        if rows.is_empty() {
            return;
        }
        let (top, other_top) = (
            (rows.start - self.top) as usize,
            (rows.start - other.top) as usize,
        );
        let down = &down[top..top + rows.len()];
        for x in columns {
            let column = (x - self.left) as usize;
            let gain = across[column];
            if gain == 0.0 {
                continue;
            }
            let start = column * self.height + top;
            let out = &mut self.weights[start..start + rows.len()];
            let weights = &other.column((x - other.left) as usize)[other_top..][..rows.len()];
            for ((out, weight), down) in out.iter_mut().zip(weights).zip(down) {
                *out += gain * down * weight;
            }
        }
    }

    /// Returns the sum of `parts`, each times its gain, over the bounding rectangle of all.
    pub(super) fn weighted_sum(parts: &[(&Self, f64)]) -> Self {
        let Some(((first, _), rest)) = parts.split_first() else {
            return Self::default();
        };
        let join = |a: Range<i32>, b: Range<i32>| a.start.min(b.start)..a.end.max(b.end);
        let (columns, rows) = rest
            .iter()
            .fold((first.columns(), first.rows()), |(x, y), (s, _)| {
                (join(x, s.columns()), join(y, s.rows()))
            });
        let mut sum = Self::zeros(columns, rows);
        for (part, gain) in parts {
            sum.add(part, 0, 0, *gain as f32);
        }
        sum
    }

    /// Returns the sum of the absolute weights.
    pub(super) fn magnitude(&self) -> f64 {
        self.weights.iter().map(|w| f64::from(w.abs())).sum()
    }

    /// Convolves the stencil along both axes with a symmetric `filter`, given from its middle tap to one side.
    pub(super) fn filtered(&self, filter: &[f64]) -> Self {
        let side = filter.len() as i32 - 1;
        let tap = |k: i32| filter[k.unsigned_abs() as usize] as f32;
        let wider = |offsets: Range<i32>| offsets.start - side..offsets.end + side;
        let mut across = Self::zeros(wider(self.columns()), self.rows());
        for k in -side..=side {
            across.add(self, k, 0, tap(k));
        }
        let mut both = Self::zeros(across.columns(), wider(self.rows()));
        for k in -side..=side {
            both.add(&across, 0, k, tap(k));
        }
        both
    }

    /// Subtracts `share` times 1/12 px² of variance along both axes, the variance that integration over a pixel adds.
    pub(super) fn sharpen(&self, share: f64) -> Self {
        let side = (-share / 24.0) as f32;
        let wider = |offsets: Range<i32>| offsets.start - 1..offsets.end + 1;
        let mut wide = Self::zeros(wider(self.columns()), wider(self.rows()));
        let across = [(-1, side), (0, 1.0 - 2.0 * side), (1, side)];
        for (dx, gx) in across {
            for (dy, gy) in across {
                wide.add(self, dx, dy, gx * gy);
            }
        }
        wide
    }

    /// Truncates the smallest weights at the rim, at most `share` of the light, and crops to the rest. The sum of
    /// weights is kept.
    pub(super) fn trim(&mut self, share: f64) {
        let floor = self.truncation_floor(share);
        let kept = |weights: &[f32]| weights.iter().any(|w| w.abs() >= floor);
        let columns: Vec<usize> = (0..self.width).filter(|x| kept(self.column(*x))).collect();
        let (Some(&first), Some(&last)) = (columns.first(), columns.last()) else {
            return;
        };
        let (mut low, mut high) = (self.height, 0);
        for x in first..=last {
            for (y, weight) in self.column(x).iter().enumerate() {
                if weight.abs() >= floor {
                    low = low.min(y);
                    high = high.max(y + 1);
                }
            }
        }
        let before = self.sum();
        let mut weights = Vec::with_capacity((last + 1 - first) * (high - low));
        for x in first..=last {
            let column = &self.column(x)[low..high];
            let start = column.iter().position(|w| w.abs() >= floor);
            let end = column.iter().rposition(|w| w.abs() >= floor);
            weights.extend(column.iter().enumerate().map(|(y, weight)| {
                let inside = start.is_some_and(|s| s <= y) && end.is_some_and(|e| y <= e);
                if inside { *weight } else { 0.0 }
            }));
        }
        self.left += first as i32;
        self.top += low as i32;
        (self.width, self.height) = (last + 1 - first, high - low);
        self.weights = weights;
        let after = self.sum();
        if after != 0.0 {
            let gain = (before / after) as f32;
            self.weights.iter_mut().for_each(|w| *w *= gain);
        }
    }

    /// Returns the weights at offsets up to `reach` along each axis, unchanged; `None` if that is all of them.
    pub(super) fn cropped(&self, reach: [i32; 2]) -> Option<Self> {
        let columns = within(self.columns(), reach[0]);
        let rows = within(self.rows(), reach[1]);
        if (&columns, &rows) == (&self.columns(), &self.rows()) {
            return None;
        }
        let mut out = Self::zeros(columns, rows);
        if out.weights.is_empty() {
            return Some(out);
        }
        let first = (out.top - self.top) as usize;
        let height = out.height;
        for (x, column) in out.columns().zip(out.weights.chunks_exact_mut(height)) {
            let own = self.column((x - self.left) as usize);
            column.copy_from_slice(&own[first..first + height]);
        }
        Some(out)
    }

    /// Returns the absolute weight below which all weights together hold at most `share` of the light, to a quarter of
    /// an octave.
    fn truncation_floor(&self, share: f64) -> f32 {
        // A histogram over the exponent and the first two mantissa bits.
        const BITS: u32 = 21;
        let mut light = vec![0.0_f64; 1 << (31 - BITS)];
        let mut total = 0.0;
        for weight in &self.weights {
            let size = weight.abs();
            light[(size.to_bits() >> BITS) as usize] += f64::from(size);
            total += f64::from(size);
        }
        let mut lost = 0.0;
        for (bin, light) in light.iter().enumerate() {
            lost += light;
            if lost > share * total {
                return f32::from_bits((bin as u32) << BITS);
            }
        }
        0.0
    }
}

/// Returns the offsets of a range that are at most `reach`.
fn within(offsets: Range<i32>, reach: i32) -> Range<i32> {
    overlap(offsets, -reach..reach + 1)
}

/// Returns the intersection of two ranges.
fn overlap(a: Range<i32>, b: Range<i32>) -> Range<i32> {
    a.start.max(b.start)..a.end.min(b.end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::psf::Kernel;

    #[test]
    fn weights_that_are_not_covered_are_skipped() {
        let mut part = Stencil::zeros(-1..2, -1..2);
        part.weights.fill(1.0);
        for (columns, rows, inside) in [
            (-3..5, -3..5, 9.0),
            (0..5, -3..1, 4.0),
            // Beside it, on either side.
            (-3..5, 2..9, 0.0),
            (-3..5, -9..-4, 0.0),
            (5..9, -3..5, 0.0),
            (-9..-4, -3..5, 0.0),
        ] {
            let shares = vec![1.0; columns.len().max(rows.len())];
            let mut sum = Stencil::zeros(columns.clone(), rows.clone());
            sum.add_weighted(&part, &shares, &shares);
            assert_eq!(sum.sum(), inside, "{columns:?} {rows:?}");
        }
    }

    #[test]
    fn weights_beyond_the_reach_are_not_taken() {
        let (width, height) = (19, 11);
        let weights = (0..width * height).map(|k| (k + 1) as f32).collect();
        let kernel = Kernel {
            left: -4,
            top: -7,
            width,
            height,
            weights,
        };
        let mut drawn = KernelRows::default();
        drawn.copy_from(&kernel);
        let whole = Stencil::from_kernel(&drawn, None);
        assert!((whole.sum() - 1.0).abs() < 1e-6);
        for reach in [[3, 2], [0, 0], [40, 1], [2, 40], [40, 40]] {
            let part = Stencil::from_kernel(&drawn, Some(reach));
            let expected = whole.cropped(reach).unwrap_or_else(|| whole.clone());
            assert_eq!(part, expected, "{reach:?}");
        }
        // Beside the source on either side.
        for left in [-40, 40] {
            drawn.copy_from(&Kernel {
                left,
                ..kernel.clone()
            });
            let part = Stencil::from_kernel(&drawn, Some([5, 5]));
            assert!(part.weights.is_empty());
        }
    }

    #[test]
    fn a_cropped_stencil_has_the_weights_up_to_the_reach() {
        let mut whole = Stencil::zeros(-4..6, -3..3);
        for (k, weight) in whole.weights.iter_mut().enumerate() {
            *weight = k as f32;
        }
        assert_eq!(whole.cropped([5, 3]), None);
        let part = whole.cropped([2, 9]).expect("smaller");
        assert_eq!((part.columns(), part.rows()), (-2..3, -3..3));
        for x in -2..3 {
            let own = whole.column((x + 4) as usize);
            assert_eq!(part.column((x + 2) as usize), own);
        }
        let none = Stencil::zeros(7..9, -3..3)
            .cropped([5, 5])
            .expect("smaller");
        assert!(none.weights.is_empty());
    }
}

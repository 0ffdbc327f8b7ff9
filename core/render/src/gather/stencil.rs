//! Stencils: kernels turned round, as an output pixel sees its sources.

use seidel_optics::psf::KernelRows;
use std::ops::Range;

/// Weights by the offset of a source from an output pixel, column by column. Where it is made of one
/// source's kernel, the weight at an offset is that kernel's at the opposite one.
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

    /// The kernel `drawn`, of unit sum, turned round.
    pub(super) fn of_kernel(drawn: &KernelRows) -> Self {
        let (columns, rows) = (drawn.columns(), drawn.rows());
        let mut stencil = Self::zeros(
            1 - columns.end..1 - columns.start,
            1 - rows.end..1 - rows.start,
        );
        let share = (1.0 / drawn.sum()) as f32;
        for span in drawn.spans() {
            let y = (-span.row - stencil.top) as usize;
            for (k, weight) in span.weights.iter().enumerate() {
                let x = (-(span.column + k as i32) - stencil.left) as usize;
                stencil.weights[x * stencil.height + y] = share * weight;
            }
        }
        stencil
    }

    /// Offsets of columns that it covers.
    pub(super) fn columns(&self) -> Range<i32> {
        self.left..self.left + self.width as i32
    }

    /// Offsets of rows that it covers.
    pub(super) fn rows(&self) -> Range<i32> {
        self.top..self.top + self.height as i32
    }

    /// The weights of column `x`, counted from the first.
    pub(super) fn column(&self, x: usize) -> &[f32] {
        &self.weights[x * self.height..(x + 1) * self.height]
    }

    /// Rows and weights of the column at offset `x` between its first and its last weight that is not
    /// zero.
    pub(super) fn lit(&self, x: i32) -> (Range<i32>, &[f32]) {
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

    /// Sum of all weights.
    pub(super) fn sum(&self) -> f64 {
        self.weights.iter().map(|w| f64::from(*w)).sum()
    }

    /// Adds `gain` times `weights`, columns of `height` whose first lies at offset `left` and `top`: all
    /// covered by this stencil.
    fn add(&mut self, (left, top): (i32, i32), height: usize, weights: &[f32], gain: f32) {
        let (x, y) = ((left - self.left) as usize, (top - self.top) as usize);
        for (column, weights) in weights.chunks_exact(height.max(1)).enumerate() {
            let start = (x + column) * self.height + y;
            let out = &mut self.weights[start..start + height];
            for (out, weight) in out.iter_mut().zip(weights) {
                *out += gain * weight;
            }
        }
    }

    /// Adds `other` times `across` and `down`, which hold one weight for each of this stencil's columns
    /// and rows; what this stencil does not cover is left out.
    pub(super) fn add_shared(&mut self, other: &Self, across: &[f32], down: &[f32]) {
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

    /// The stencil that sees the whole of `parts`, each times its gain.
    pub(super) fn mean_of(parts: &[(&Self, f64)]) -> Self {
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
            sum.add(
                (part.left, part.top),
                part.height,
                &part.weights,
                *gain as f32,
            );
        }
        sum
    }

    /// With an even `filter`, its middle tap first, laid over it along both axes.
    pub(super) fn filtered(&self, filter: &[f64]) -> Self {
        let side = filter.len() as i32 - 1;
        let tap = |k: i32| filter[k.unsigned_abs() as usize] as f32;
        let wider = |offsets: Range<i32>| offsets.start - side..offsets.end + side;
        let mut across = Self::zeros(wider(self.columns()), self.rows());
        for k in -side..=side {
            across.add(
                (self.left + k, self.top),
                self.height,
                &self.weights,
                tap(k),
            );
        }
        let mut both = Self::zeros(across.columns(), wider(self.rows()));
        for k in -side..=side {
            both.add(
                (across.left, across.top + k),
                across.height,
                &across.weights,
                tap(k),
            );
        }
        both
    }

    /// Takes away one twelfth px² of variance times `share` along both axes: what integration over a
    /// pixel adds.
    pub(super) fn sharpen(&self, share: f64) -> Self {
        let side = (-share / 24.0) as f32;
        let wider = |offsets: Range<i32>| offsets.start - 1..offsets.end + 1;
        let mut wide = Self::zeros(wider(self.columns()), wider(self.rows()));
        let across = [(-1, side), (0, 1.0 - 2.0 * side), (1, side)];
        for (dx, gx) in across {
            for (dy, gy) in across {
                let place = (self.left + dx, self.top + dy);
                wide.add(place, self.height, &self.weights, gx * gy);
            }
        }
        wide
    }

    /// Leaves out the smallest weights, `share` of the light in all, and frees the room about the rest;
    /// what is left gets the light of what was.
    pub(super) fn trim(&mut self, share: f64) {
        let floor = self.floor_of(share);
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

    /// The size of weight below which all weights together hold at most `share` of the light, to a
    /// quarter of a power of two.
    fn floor_of(&self, share: f64) -> f32 {
        // A histogram over exponents and the two first bits behind.
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

/// What two ranges have in common.
fn overlap(a: Range<i32>, b: Range<i32>) -> Range<i32> {
    a.start.max(b.start)..a.end.min(b.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_covered_is_left_out() {
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
            sum.add_shared(&part, &shares, &shares);
            assert_eq!(sum.sum(), inside, "{columns:?} {rows:?}");
        }
    }
}

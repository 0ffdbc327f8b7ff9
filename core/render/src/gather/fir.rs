//! The inner loop: an FIR filter over a tile whose taps vary bilinearly between the stencils at its corners.

use super::stencil::Stencil;
use std::ops::Range;

/// Output rows summed together.
pub(super) const ROWS: usize = 8;
/// Largest number of output columns per vector; gathered tiles are multiples of it wide.
pub(super) const LANES: usize = 16;

/// The FIR filter of a tile: for each tap the weight at the tile's top-left outer corner and its change per pixel along
/// x, along y and along both.
#[derive(Default)]
pub(super) struct BilinearFir {
    /// Column offsets of the sources.
    pub(super) columns: Range<i32>,
    /// Row offsets of the sources.
    pub(super) rows: Range<i32>,
    runs: Vec<TapRun>,
    taps: Vec<[f32; 4]>,
    /// The runs of taps that reach the lit sources from the current block of output rows.
    block_runs: Vec<TapRun>,
    /// Their taps at the first row of the block.
    block_taps: Vec<[f32; 4]>,
}

/// The columns and rows of sources outside which all are black.
#[derive(Clone)]
pub(super) struct LitSources {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl LitSources {
    /// All sources.
    pub(super) const ALL: Self = Self {
        columns: 0..usize::MAX,
        rows: 0..usize::MAX,
    };
}

/// Consecutive taps down one column of sources.
#[derive(Clone, Copy)]
pub(super) struct TapRun {
    /// Column of the sources, from the first one.
    pub(super) column: usize,
    /// Row of the first source, from the first one.
    pub(super) row: usize,
    /// Index of the first tap.
    pub(super) first: usize,
    /// Index after the last tap.
    pub(super) end: usize,
}

impl BilinearFir {
    /// Sets the filter to the stencils at the corners (top left, top right, bottom left, bottom right) of a tile of
    /// `side` pixels.
    pub(super) fn set(&mut self, corners: [&Stencil; 4], side: usize) {
        let spread = |of: &dyn Fn(&Stencil) -> Range<i32>| {
            let ranges = corners.iter().map(|s| of(s)).filter(|r| !r.is_empty());
            ranges
                .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
                .unwrap_or(0..0)
        };
        (self.columns, self.rows) = (spread(&Stencil::columns), spread(&Stencil::rows));
        self.runs.clear();
        self.taps.clear();
        let per = 1.0 / side as f32;
        for x in self.columns.clone() {
            let columns = corners.map(|s| s.nonzero_column(x));
            let lit = columns
                .iter()
                .filter(|(r, _)| !r.is_empty())
                .map(|(r, _)| r.clone());
            let Some(rows) = lit.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)) else {
                continue;
            };
            let first = self.taps.len();
            for y in rows.clone() {
                let [a, b, c, d] = columns.each_ref().map(|(rows, weights)| {
                    let inside = rows.contains(&y);
                    if inside {
                        weights[(y - rows.start) as usize]
                    } else {
                        0.0
                    }
                });
                self.taps
                    .push([a, (b - a) * per, (c - a) * per, (d - c - b + a) * per * per]);
            }
            self.runs.push(TapRun {
                column: (x - self.columns.start) as usize,
                row: (rows.start - self.rows.start) as usize,
                first,
                end: self.taps.len(),
            });
        }
    }

    /// Returns the transposed filter, from a tile's pixels to its sources. Its output starts at the first column and
    /// row of the sources.
    pub(super) fn transposed(&self) -> Self {
        let (last_column, last_row) = (self.columns.len() - 1, self.rows.len() - 1);
        let mut transposed = Self {
            columns: 1 - self.columns.end..1 - self.columns.start,
            rows: 1 - self.rows.end..1 - self.rows.start,
            ..Self::default()
        };
        for run in self.runs.iter().rev() {
            let first = transposed.taps.len();
            let taps = &self.taps[run.first..run.end];
            for (k, &[at, by_x, by_y, by_both]) in taps.iter().enumerate().rev() {
                // The same weights, with the origin moved to the source.
                let (x, y) = (run.column as f32, (run.row + k) as f32);
                transposed.taps.push([
                    at - x * by_x - y * by_y + x * y * by_both,
                    by_x - y * by_both,
                    by_y - x * by_both,
                    by_both,
                ]);
            }
            transposed.runs.push(TapRun {
                column: last_column - run.column,
                row: last_row - (run.row + taps.len() - 1),
                first,
                end: transposed.taps.len(),
            });
        }
        transposed
    }

    /// The runs of taps, by column.
    pub(super) fn runs(&self) -> &[TapRun] {
        &self.runs
    }

    /// The taps: for each the weight at the tile's top-left outer corner and its change along x, y and both.
    pub(super) fn taps(&self) -> &[[f32; 4]] {
        &self.taps
    }

    /// Returns the number of taps.
    pub(super) fn len(&self) -> usize {
        self.taps.len()
    }

    /// Writes output rows of `side` pixels to `out`, row-major.
    ///
    /// `sources` are rows of `stride` samples that begin at the first column and row of the sources of the top-left
    /// output pixel. Each row is padded with [`LANES`] samples. Taps on sources that are not `lit` are passed over.
    pub(super) fn gather(
        &mut self,
        sources: &[f32],
        stride: usize,
        lit: &LitSources,
        side: usize,
        out: &mut [f32],
    ) {
        for (block, out) in out.chunks_exact_mut(ROWS * side).enumerate() {
            self.set_block(block * ROWS, &lit.rows);
            pulp::Arch::new().dispatch(Block {
                runs: &self.block_runs,
                taps: &self.block_taps,
                sources: &sources[block * ROWS * stride..],
                stride,
                lit_columns: &lit.columns,
                side,
                out,
            });
        }
    }

    /// Sets the taps of the [`ROWS`] output rows from `first_row` on, those that reach the `lit` rows of sources.
    fn set_block(&mut self, first_row: usize, lit: &Range<usize>) {
        // Taps at the centre of the block's first row.
        let down = first_row as f32 + 0.5;
        self.block_runs.clear();
        self.block_taps.clear();
        for run in &self.runs {
            let row = first_row + run.row;
            let all = &self.taps[run.first..run.end];
            let unlit = lit.start.saturating_sub(row + ROWS - 1);
            let end = all.len().min(lit.end.saturating_sub(row));
            if unlit >= end {
                continue;
            }
            let first = self.block_taps.len();
            let taps = all[unlit..end].iter();
            self.block_taps
                .extend(taps.map(|&[at, by_x, by_y, by_both]| {
                    [at + down * by_y, by_x + down * by_both, by_y, by_both]
                }));
            self.block_runs.push(TapRun {
                column: run.column,
                row: run.row + unlit,
                first,
                end: self.block_taps.len(),
            });
        }
    }
}

/// The sums of [`ROWS`] rows of a tile. A type rather than a closure, so that `dispatch` compiles its loops with the
/// machine's vector instructions.
struct Block<'a> {
    runs: &'a [TapRun],
    taps: &'a [[f32; 4]],
    sources: &'a [f32],
    stride: usize,
    lit_columns: &'a Range<usize>,
    side: usize,
    out: &'a mut [f32],
}

impl pulp::WithSimd for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let mut places = [0.0_f32; LANES];
        for first in (0..self.side).step_by(S::F32_LANES) {
            for (k, place) in places.iter_mut().enumerate() {
                *place = (first + k) as f32 + 0.5;
            }
            let across = load::<S>(&places, 0);
            let mut sums = [simd.splat_f32s(0.0); ROWS];
            for run in self.runs {
                let column = run.column + first;
                if column >= self.lit_columns.end || column + S::F32_LANES <= self.lit_columns.start
                {
                    continue;
                }
                let taps = &self.taps[run.first..run.end];
                let mut start = run.row * self.stride + column;
                let (fours, rest) = taps.as_chunks::<4>();
                for taps in fours {
                    let rows = &self.sources[start..];
                    add::<S, 4, 11>(simd, taps, across, rows, self.stride, &mut sums);
                    start += 4 * self.stride;
                }
                for tap in rest {
                    let rows = &self.sources[start..];
                    add::<S, 1, 8>(simd, &[*tap], across, rows, self.stride, &mut sums);
                    start += self.stride;
                }
            }
            for (row, sum) in sums.into_iter().enumerate() {
                let at = row * self.side + first;
                let out = &mut self.out[at..at + S::F32_LANES];
                let (out, _) = S::as_mut_simd_f32s(out);
                out[0] = sum;
            }
        }
    }
}

/// Adds `N` consecutive taps of a column to the sums of [`ROWS`] rows. Each of the `M` = `N` + [`ROWS`] - 1 rows of
/// sources is read once.
#[inline(always)]
fn add<S: pulp::Simd, const N: usize, const M: usize>(
    simd: S,
    taps: &[[f32; 4]; N],
    across: S::f32s,
    sources: &[f32],
    stride: usize,
    sums: &mut [S::f32s; ROWS],
) {
    let mut rows = [across; M];
    for (k, row) in rows.iter_mut().enumerate() {
        *row = load::<S>(sources, k * stride);
    }
    for (k, &[at, by_x, by_y, by_both]) in taps.iter().enumerate() {
        let mut weight = simd.mul_add_f32s(simd.splat_f32s(by_x), across, simd.splat_f32s(at));
        let change = simd.mul_add_f32s(simd.splat_f32s(by_both), across, simd.splat_f32s(by_y));
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum = simd.mul_add_f32s(weight, rows[k + i], *sum);
            weight = simd.add_f32s(weight, change);
        }
    }
}

/// Loads a vector of `samples` from `start` on.
#[inline(always)]
pub(super) fn load<S: pulp::Simd>(samples: &[f32], start: usize) -> S::f32s {
    S::as_simd_f32s(&samples[start..start + S::F32_LANES]).0[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_on_black_sources_may_be_passed_over() {
        let (taps, tile) = (41, 16);
        let corner = |gain: f32| {
            let mut stencil = Stencil::zeros(-20..21, -20..21);
            for (k, weight) in stencil.weights.iter_mut().enumerate() {
                *weight = gain * (1.0 + (k as f32).sin());
            }
            stencil
        };
        let corners = [1.0, 0.7, 0.5, 0.9].map(corner);
        let mut fir = BilinearFir::default();
        fir.set(corners.each_ref(), tile);
        let (side, stride) = (64, 64 + taps + LANES);
        let lit = LitSources {
            columns: 40..56,
            rows: 37..53,
        };
        let mut sources = vec![0.0; stride * (side + taps)];
        for y in lit.rows.clone() {
            for x in lit.columns.clone() {
                sources[y * stride + x] = ((x * y) as f32).cos();
            }
        }
        let mut gathered = |lit: &LitSources| {
            let mut out = vec![0.0; side * side];
            fir.gather(&sources, stride, lit, side, &mut out);
            out
        };
        let all = gathered(&LitSources::ALL);
        assert!(all.iter().any(|v| *v != 0.0));
        assert_eq!(gathered(&lit), all);
    }
}

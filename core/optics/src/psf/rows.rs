//! Kernels stored as one span of weights a row, for the exact renderer.

use super::kernel::KernelGrid;
use super::pupil::{PsfImage, Workspace};
use super::skew_normal_samples::{Curve, LANES, Scan};
use super::{Kernel, Mixture};
use std::ops::Range;

/// A kernel as spans of weights, one a row, in a reusable buffer.
///
/// The weights are not normalised; divide by [`KernelRows::sum`]. Spans are padded to whole SIMD vectors, so that
/// loops over them have no remainder. The padding holds samples of the density or zeros.
#[derive(Debug, Default)]
pub struct KernelRows {
    spans: Vec<Span>,
    weights: Vec<f32>,
    sum: f64,
    columns: Range<i32>,
    rows: Range<i32>,
    /// Buffers of the `pupil` model.
    pub(super) scratch: (Workspace, PsfImage),
}

/// A run of neighbouring weights in one row of a kernel.
#[derive(Debug, Clone, Copy)]
pub struct KernelSpan<'a> {
    /// Row relative to the source pixel.
    pub row: i32,
    /// Column of the first weight relative to the source pixel.
    pub column: i32,
    /// The weights, a multiple of [`KernelRows::PADDING`] of them.
    pub weights: &'a [f32],
}

/// The place of a span relative to the source pixel and in the buffer.
#[derive(Debug, Clone, Copy)]
struct Span {
    row: i32,
    column: i32,
    start: usize,
    len: usize,
}

impl KernelRows {
    /// The length of every span is a multiple of this.
    pub const PADDING: usize = LANES;

    /// The spans from top to bottom; at most one a row.
    #[inline(always)]
    pub fn spans(&self) -> impl Iterator<Item = KernelSpan<'_>> {
        self.spans.iter().map(|span| KernelSpan {
            row: span.row,
            column: span.column,
            weights: &self.weights[span.start..span.start + span.len],
        })
    }

    /// Returns the sum of all weights of the kernel, which is positive.
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// Sets the sum of a kernel of which the rows hold a part.
    pub(super) fn set_sum(&mut self, sum: f64) {
        self.sum = sum;
    }

    /// Returns the columns that hold weights, relative to the source pixel, including padding.
    pub fn columns(&self) -> Range<i32> {
        self.columns.clone()
    }

    /// Returns the rows that hold weights, relative to the source pixel.
    pub fn rows(&self) -> Range<i32> {
        self.rows.clone()
    }

    /// Copies a dense kernel, whose weights sum to one.
    pub fn copy_from(&mut self, kernel: &Kernel) {
        self.clear();
        self.reserve(kernel.height, kernel.width);
        let len = kernel.width.next_multiple_of(LANES);
        for (row, line) in kernel.weights.chunks_exact(kernel.width).enumerate() {
            let start = row * len;
            self.weights[start..start + len].fill(0.0);
            self.weights[start..start + kernel.width].copy_from_slice(line);
            self.push(Span {
                row: kernel.top + row as i32,
                column: kernel.left,
                start,
                len,
            });
        }
        self.sum = kernel.weights.iter().map(|&w| f64::from(w)).sum();
    }

    /// Copies the nonzero span of each row of an image with `width` columns.
    ///
    /// Its first pixel lies at column `left` and row `top` relative to the source pixel.
    pub(super) fn copy_from_image(&mut self, light: &[f64], left: i32, top: i32, width: usize) {
        self.clear();
        self.reserve(light.len() / width, width);
        let mut start = 0;
        for (row, line) in light.chunks_exact(width).enumerate() {
            let Some(first) = line.iter().position(|v| *v > 0.0) else {
                continue;
            };
            let end = line.iter().rposition(|v| *v > 0.0).unwrap_or(first) + 1;
            let len = (end - first).next_multiple_of(LANES);
            let weights = &mut self.weights[start..start + len];
            for (weight, light) in weights.iter_mut().zip(&line[first..end]) {
                *weight = *light as f32;
            }
            weights[end - first..].fill(0.0);
            self.sum += line[first..end].iter().sum::<f64>();
            self.push(Span {
                row: top + row as i32,
                column: left + first as i32,
                start,
                len,
            });
            start += len;
        }
    }

    /// Draws `mixture` with its centroid `shift_px` (x, y) from the centre of the source pixel.
    ///
    /// A density that no pixel centre samples becomes the single pixel nearest to its centroid.
    pub(super) fn draw(&mut self, mixture: &Mixture, shift_px: (f64, f64)) {
        let grid = KernelGrid::new(&mixture.bounds(), shift_px);
        self.clear();
        self.reserve(grid.samples.height, grid.samples.width);
        pulp::Arch::new().dispatch(Drawing {
            rows: self,
            mixture,
            grid,
        });
        if self.sum <= 0.0 {
            self.clear();
            self.weights[..LANES].fill(0.0);
            self.weights[0] = 1.0;
            self.sum = 1.0;
            self.push(Span {
                row: shift_px.1.round() as i32,
                column: shift_px.0.round() as i32,
                start: 0,
                len: LANES,
            });
        }
    }

    #[inline(always)]
    fn draw_on(&mut self, mixture: &Mixture, grid: &KernelGrid) {
        let KernelGrid {
            left,
            top,
            samples: window,
        } = grid;
        let (left, top) = (*left, *top);
        let mut sums = [0.0_f64; LANES];
        match mixture {
            Mixture::One(part) => {
                let scan = Scan::new(part, 1.0, window);
                for row in 0..window.height {
                    if let Some((curve, columns)) = scan.row(row) {
                        let place = (left, top + row as i32);
                        self.fill(place, columns, &[curve], &mut sums);
                    }
                }
            }
            Mixture::Two([first, second]) => {
                let first = Scan::new(first, 0.5, window);
                let second = Scan::new(second, 0.5, window);
                for row in 0..window.height {
                    let place = (left, top + row as i32);
                    match (first.row(row), second.row(row)) {
                        (None, None) => {}
                        (Some((curve, columns)), None) | (None, Some((curve, columns))) => {
                            self.fill(place, columns, &[curve], &mut sums);
                        }
                        (Some((a, here)), Some((b, there))) => {
                            let both = here.start.min(there.start)..here.end.max(there.end);
                            self.fill(place, both, &[a, b], &mut sums);
                        }
                    }
                }
            }
        }
        self.sum = sums.iter().sum();
    }

    /// Appends the span over `columns` of a row, whose first pixel lies at `place` (column, row).
    ///
    /// The weights are the sum of the `curves`. They are added to the sum of each lane: in single precision along
    /// the row, in double precision from row to row.
    #[inline(always)]
    fn fill<const N: usize>(
        &mut self,
        place: (i32, i32),
        columns: Range<usize>,
        curves: &[Curve; N],
        sums: &mut [f64; LANES],
    ) {
        let start = self.spans.last().map_or(0, |span| span.start + span.len);
        let len = columns.len().next_multiple_of(LANES);
        let mut row_sums = [0.0_f32; LANES];
        let (blocks, _) = self.weights[start..start + len].as_chunks_mut::<LANES>();
        for (block, out) in blocks.iter_mut().enumerate() {
            let mut total = [0.0; LANES];
            for curve in curves {
                let mut drawn = [0.0; LANES];
                curve.sample(columns.start + block * LANES, &mut drawn);
                for (total, drawn) in total.iter_mut().zip(drawn) {
                    *total += drawn;
                }
            }
            *out = total;
            for (sum, weight) in row_sums.iter_mut().zip(total) {
                *sum += weight;
            }
        }
        for (sum, row_sum) in sums.iter_mut().zip(row_sums) {
            *sum += f64::from(row_sum);
        }
        self.push(Span {
            row: place.1,
            column: place.0 + columns.start as i32,
            start,
            len,
        });
    }

    #[inline(always)]
    fn push(&mut self, span: Span) {
        let end = span.column + span.len as i32;
        if self.spans.is_empty() {
            self.columns = span.column..end;
            self.rows = span.row..span.row + 1;
        } else {
            self.columns = self.columns.start.min(span.column)..self.columns.end.max(end);
            self.rows.end = span.row + 1;
        }
        self.spans.push(span);
    }

    fn clear(&mut self) {
        self.spans.clear();
        self.sum = 0.0;
        (self.columns, self.rows) = (0..0, 0..0);
    }

    /// Reserves space for `height` spans over `width` columns. The buffer only grows; stale weights are overwritten
    /// before they are read.
    fn reserve(&mut self, height: usize, width: usize) {
        let room = height.max(1) * width.next_multiple_of(LANES).max(LANES);
        if self.weights.len() < room {
            self.weights.resize(room, 0.0);
        }
        self.spans.reserve(height);
    }
}

/// [`KernelRows::draw_on`] for `pulp::Arch::dispatch`. Not a closure: the shim around a closure is not always
/// inlined, and its body is then compiled without the vector instructions.
struct Drawing<'a> {
    rows: &'a mut KernelRows,
    mixture: &'a Mixture,
    grid: KernelGrid,
}

impl pulp::WithSimd for Drawing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.rows.draw_on(self.mixture, &self.grid);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FieldPoint;
    use crate::moments::MeridionalMoments;
    use crate::psf::{
        ALL, KernelBounds, LocalBlur, PsfModel, SampleGrid, SkewNormal, SkewNormalDensity,
        draw_kernel,
    };
    use pulp::WithSimd;

    /// Compares scalar code with AVX2 and with the best instruction set of the machine.
    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let bits = |rows: &KernelRows| -> Vec<(i32, i32, Vec<u32>)> {
            let bits = |span: KernelSpan| {
                let weights = span.weights.iter().map(|w| w.to_bits());
                (span.row, span.column, weights.collect())
            };
            rows.spans().map(bits).collect()
        };
        let first = SkewNormalDensity::new([30.0, 9.0, 12.0], [6.0, -2.0]);
        let second = SkewNormalDensity::new([30.0, -9.0, 12.0], [0.1, 2.5]);
        for mixture in [Mixture::One(first), Mixture::Two([first, second])] {
            let grid = KernelGrid::new(&mixture.bounds(), (0.3, -0.6));
            let drawn_by = |draw: &dyn Fn(Drawing)| {
                let mut rows = KernelRows::default();
                rows.reserve(grid.samples.height, grid.samples.width);
                draw(Drawing {
                    rows: &mut rows,
                    mixture: &mixture,
                    grid,
                });
                rows
            };
            let plain = drawn_by(&|drawing| drawing.with_simd(pulp::Scalar::new()));
            let best = drawn_by(&|drawing| pulp::Arch::new().dispatch(drawing));
            assert!(plain.sum > 0.0 && bits(&plain).len() > 20);
            assert_eq!((bits(&plain), plain.sum), (bits(&best), best.sum));
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = pulp::x86::V3::try_new() {
                let common = drawn_by(&|drawing| pulp::Simd::vectorize(avx2, drawing));
                assert_eq!((bits(&plain), plain.sum), (bits(&common), common.sum));
            }
        }
    }

    /// A model with the default [`PsfModel::draw_rows`].
    struct Plain;

    impl PsfModel for Plain {
        fn id(&self) -> &'static str {
            "plain"
        }

        fn kernel_bounds(&self, blur: &LocalBlur) -> KernelBounds {
            SkewNormal.kernel_bounds(blur)
        }

        fn sample(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f64]) {
            SkewNormal.sample(blur, window, out);
        }

        fn sample_f32(&self, blur: &LocalBlur, window: &SampleGrid, out: &mut [f32]) {
            SkewNormal.sample_f32(blur, window, out);
        }
    }

    #[test]
    fn rows_agree_with_the_dense_kernel() {
        for (sigma2, shift) in [
            (1e-9, (0.5001, -0.2)),
            (0.1, (0.3, 0.45)),
            (4.0, (0.0, 0.0)),
            (90.0, (-17.3, 5.25)),
        ] {
            let meridian = FieldPoint::new(0.3, -0.5).meridian();
            let moments = MeridionalMoments {
                mu20: 2.0 * sigma2,
                mu02: sigma2,
                mu30: 1.1 * sigma2.powf(1.5),
                mu12: 0.4 * sigma2.powf(1.5),
            }
            .in_image(meridian);
            let blur = LocalBlur::from_moments(moments, meridian);
            let plain: &dyn PsfModel = &Plain;
            for model in ALL.iter().filter(|m| !m.needs_rays()).chain([&plain]) {
                let (mut kernel, mut rows) = (Kernel::default(), KernelRows::default());
                draw_kernel(*model, &blur, shift, &mut kernel);
                model.draw_rows(&blur, shift, &mut rows);
                let peak = kernel.weights.iter().copied().fold(0.0, f32::max);
                let mut seen = 0.0;
                for KernelSpan {
                    row,
                    column,
                    weights,
                } in rows.spans()
                {
                    assert!(rows.rows().contains(&row) && weights.len() % LANES == 0);
                    for (k, weight) in weights.iter().enumerate() {
                        let (x, y) = (column + k as i32 - kernel.left, row - kernel.top);
                        let inside = (0..kernel.width as i32).contains(&x);
                        let dense = if inside {
                            kernel.weights[y as usize * kernel.width + x as usize]
                        } else {
                            0.0
                        };
                        let weight = (f64::from(*weight) / rows.sum()) as f32;
                        assert!((weight - dense).abs() <= 1e-5 * peak, "{}", model.id());
                        seen += weight;
                    }
                }
                assert!((seen - 1.0).abs() < 1e-5, "{} at {sigma2}", model.id());
            }
        }
    }
}

//! The inner loop of scattering: a tile's light spread by taps that vary bilinearly between the kernels at its corners.

use super::fir::{BilinearFir, LANES, ROWS, TapRun, load};
use super::image::{Image, Rect};
use std::ops::Range;

/// Black rows above and below a tile: output rows are summed [`ROWS`] at a time.
const PADDING: usize = ROWS;

/// Pixels of a row that are loaded together. Aligned to a line of the cache: a load across two lines takes twice the time.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Vector([f32; LANES]);

/// The light of a tile, padded for [`spread`].
pub(super) struct TileLight {
    side: usize,
    /// Samples, one column of vectors after the other, each with [`PADDING`] black rows above and below.
    samples: Vec<Vector>,
    /// Rows with light in each column of vectors.
    lit: Vec<Range<usize>>,
}

impl TileLight {
    /// Takes the tile of `side` pixels at (`left`, `top`) from `image`, if it holds light.
    pub(super) fn take(image: &Image, left: i32, top: i32, side: usize) -> Option<Self> {
        let cut = |start: i32, own: i32, length: usize| {
            let inside = |at: i32| at.clamp(0, side as i32) as usize;
            inside(own - start)..inside(own + length as i32 - start)
        };
        let across = cut(left, image.left, image.width);
        let down = cut(top, image.top, image.height);
        let line = |row: usize| {
            let y = (top + row as i32 - image.top) as usize;
            let x = (left + across.start as i32 - image.left) as usize;
            &image.samples[y * image.width + x..][..across.len()]
        };
        let is_lit = |row: &usize| line(*row).iter().any(|v| *v != 0.0);
        if across.is_empty() || !down.clone().any(|row| is_lit(&row)) {
            return None;
        }
        let vectors = side.div_ceil(LANES);
        let height = side + 2 * PADDING;
        let mut samples = vec![Vector([0.0; LANES]); vectors * height];
        let mut lit = Vec::with_capacity(vectors);
        for (index, column) in samples.chunks_exact_mut(height).enumerate() {
            let first = index * LANES;
            let (start, end) = (across.start.max(first), across.end.min(first + LANES));
            let mut rows = 0..0;
            if start < end {
                for row in down.clone() {
                    let from = &line(row)[start - across.start..end - across.start];
                    column[PADDING + row].0[start - first..end - first].copy_from_slice(from);
                    if from.iter().any(|v| *v != 0.0) {
                        rows = if rows.is_empty() { row } else { rows.start }..row + 1;
                    }
                }
            }
            lit.push(rows);
        }
        Some(Self { side, samples, lit })
    }

    /// Returns a column of vectors.
    #[inline(always)]
    fn column(&self, index: usize) -> &[Vector] {
        let height = self.side + 2 * PADDING;
        &self.samples[index * height..][..height]
    }
}

/// Planes that are spread together: they share the work on the taps.
const TOGETHER: usize = 2;

/// Spreads the light of the same tile at (`left`, `top`) of some planes with the kernels that `fir` interpolates: offsets are those of
/// the target from the source.
pub(super) fn spread(fir: &BilinearFir, tiles: &[&TileLight], left: i32, top: i32) -> Vec<Image> {
    let (whole, rest) = tiles.as_chunks::<TOGETHER>();
    let pairs = whole
        .iter()
        .flat_map(|pair| spread_together(fir, pair, left, top));
    let single = rest
        .iter()
        .flat_map(|tile| spread_together(fir, std::array::from_ref(tile), left, top));
    pairs.chain(single).collect()
}

/// [`spread`] for `N` planes.
fn spread_together<const N: usize>(
    fir: &BilinearFir,
    tiles: &[&TileLight; N],
    left: i32,
    top: i32,
) -> [Image; N] {
    let side = tiles[0].side;
    let width = side.next_multiple_of(LANES) + fir.columns.len();
    let rect = Rect {
        left: left + fir.columns.start,
        top: top + fir.rows.start,
        width,
        height: side + fir.rows.len() + ROWS,
    };
    let mut out: [Image; N] = std::array::from_fn(|_| Image::zeros(rect));
    pulp::Arch::new().dispatch(Spreading {
        runs: fir.runs(),
        taps: fir.taps(),
        tiles,
        stride: width,
        out: out.each_mut().map(|image| image.samples.as_mut_slice()),
    });
    out
}

/// [`spread_together`] for `pulp::Arch::dispatch`.
struct Spreading<'a, const N: usize> {
    runs: &'a [TapRun],
    taps: &'a [[f32; 4]],
    tiles: &'a [&'a TileLight; N],
    stride: usize,
    out: [&'a mut [f32]; N],
}

impl<const N: usize> pulp::WithSimd for Spreading<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, simd: S) {
        let mut places = [0.0_f32; LANES];
        let width = self.tiles[0].lit.len() * LANES;
        for first in (0..width).step_by(S::F32_LANES) {
            let (index, lane) = (first / LANES, first % LANES);
            let lit = (self.tiles.iter().map(|tile| tile.lit[index].clone()))
                .filter(|lit| !lit.is_empty())
                .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
            let Some(lit) = lit else {
                continue;
            };
            let columns = self.tiles.each_ref().map(|tile| tile.column(index));
            for (k, place) in places.iter_mut().enumerate() {
                *place = (first + k) as f32 + 0.5;
            }
            let across = load::<S>(&places, 0);
            for run in self.runs {
                let taps = &self.taps[run.first..run.end];
                let end = run.row + taps.len() + lit.end - 1;
                for row in (run.row + lit.start..end).step_by(ROWS) {
                    // Tap k takes row `row + i` from source row `row + i - run.row - k`.
                    let from = (row + 1).saturating_sub(run.row + lit.end);
                    let to = (row + ROWS - run.row - lit.start).min(taps.len());
                    let mut sums = [[simd.splat_f32s(0.0); ROWS]; N];
                    for (k, tap) in taps[..to].iter().enumerate().skip(from) {
                        let source = row + PADDING - run.row - k;
                        let rows = columns.map(|column| rows_from(column, source));
                        let y = source as f32 - PADDING as f32 + 0.5;
                        add::<S, N>(simd, *tap, across, y, rows, lane, &mut sums);
                    }
                    let start = row * self.stride + run.column + first;
                    for (out, sums) in self.out.iter_mut().zip(sums) {
                        for (i, sum) in sums.into_iter().enumerate() {
                            let at = start + i * self.stride;
                            let out = &mut out[at..at + S::F32_LANES];
                            let (out, _) = S::as_mut_simd_f32s(out);
                            out[0] = simd.add_f32s(out[0], sum);
                        }
                    }
                }
            }
        }
    }
}

/// Returns [`ROWS`] rows of a column of vectors.
#[inline(always)]
fn rows_from(column: &[Vector], first: usize) -> &[Vector; ROWS] {
    match column[first..].first_chunk() {
        Some(rows) => rows,
        None => unreachable!("columns are padded"),
    }
}

/// Adds one tap to the sums of [`ROWS`] rows of `N` planes; the first source row lies at `y` and the columns at `across`, px from the
/// tile's corner.
#[inline(always)]
fn add<S: pulp::Simd, const N: usize>(
    simd: S,
    [at, by_x, by_y, by_both]: [f32; 4],
    across: S::f32s,
    y: f32,
    sources: [&[Vector; ROWS]; N],
    lane: usize,
    sums: &mut [[S::f32s; ROWS]; N],
) {
    let change = simd.mul_add_f32s(simd.splat_f32s(by_both), across, simd.splat_f32s(by_y));
    let base = simd.mul_add_f32s(simd.splat_f32s(by_x), across, simd.splat_f32s(at));
    let mut weight = simd.mul_add_f32s(change, simd.splat_f32s(y), base);
    for i in 0..ROWS {
        for (sums, sources) in sums.iter_mut().zip(sources) {
            let samples = load::<S>(&sources[i].0, lane);
            sums[i] = simd.mul_add_f32s(weight, samples, sums[i]);
        }
        weight = simd.add_f32s(weight, change);
    }
}

#[cfg(test)]
mod tests {
    use super::super::stencil::Stencil;
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    /// Kernels of other places and sizes at each corner.
    fn kernels(random: &mut SplitMix64) -> [Stencil; 4] {
        std::array::from_fn(|k| {
            let k = k as i32;
            let mut kernel = Stencil::zeros(-3 - k..4 + 2 * k, -9 + 2 * k..5 + 3 * k);
            let weight = |_| random.unit() as f32 - 0.2;
            kernel.weights = (0..kernel.weights.len()).map(weight).collect();
            kernel
        })
    }

    #[test]
    fn light_is_spread_as_by_brute_force() {
        let random = &mut SplitMix64::new(5);
        for side in [4, 16, 24, 40] {
            let corners = kernels(random);
            let [a, b, c, d] = &corners;
            let mut fir = BilinearFir::default();
            fir.set([a, b, c, d], side);
            let (left, top) = (-7, 13);
            let mut image = Image::zeros(Rect {
                left: left + 1,
                top: top - 5,
                width: side + 3,
                height: side + 9,
            });
            for sample in &mut image.samples {
                // Mostly dark.
                *sample = (random.unit() as f32 - 0.7).max(0.0);
            }
            let light = || TileLight::take(&image, left, top, side).expect("light");
            let found = spread(&fir, &[&light(), &light(), &light()], left, top);
            assert_eq!(found[0].samples, found[1].samples);
            assert_eq!(found[0].samples, found[2].samples);
            let found = &found[0];
            let mut expected = Image::zeros(found.rect());
            for row in 0..side {
                for column in 0..side {
                    let (x, y) = (left + column as i32, top + row as i32);
                    let place = image.cropped(Rect {
                        left: x,
                        top: y,
                        width: 1,
                        height: 1,
                    });
                    let share = |k: usize| (k as f32 + 0.5) / side as f32;
                    let (across, down) = (share(column), share(row));
                    let shares = [
                        (1.0 - across) * (1.0 - down),
                        across * (1.0 - down),
                        (1.0 - across) * down,
                        across * down,
                    ];
                    for (kernel, share) in corners.iter().zip(shares) {
                        for (at, dx) in kernel.columns().enumerate() {
                            for (dy, weight) in kernel.rows().zip(kernel.column(at)) {
                                let to_x = (x + dx - expected.left) as usize;
                                let to_y = (y + dy - expected.top) as usize;
                                expected.samples[to_y * expected.width + to_x] +=
                                    share * weight * place.samples[0];
                            }
                        }
                    }
                }
            }
            for (found, expected) in found.samples.iter().zip(&expected.samples) {
                assert!((found - expected).abs() < 1e-4, "{found} {expected}");
            }
        }
    }

    #[test]
    fn a_dark_tile_holds_no_light() {
        let image = Image::zeros(Rect {
            left: 0,
            top: 0,
            width: 40,
            height: 40,
        });
        assert!(TileLight::take(&image, 16, 16, 16).is_none());
    }
}

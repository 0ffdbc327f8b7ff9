//! The inner loop of scattering: a tile's light spread by taps that vary bilinearly between the kernels at its corners.

use super::fir::{BilinearFir, LANES, ROWS, TapRun, load};
use super::image::{Image, Rect};
use std::ops::Range;

/// Black rows above and below a tile: output rows are summed [`ROWS`] at a time.
const PADDING: usize = ROWS;

/// The light of a tile, padded for [`spread`].
#[derive(Default)]
pub(super) struct TileLight {
    side: usize,
    /// Samples a row, a multiple of [`LANES`].
    stride: usize,
    samples: Vec<f32>,
    /// Rows with light in each vector of columns.
    lit: Vec<Range<usize>>,
}

impl TileLight {
    /// Takes the tile of `side` pixels at (`left`, `top`) from `image`; returns whether it holds light.
    pub(super) fn take(&mut self, image: &Image, left: i32, top: i32, side: usize) -> bool {
        self.side = side;
        self.stride = side.next_multiple_of(LANES);
        let rect = Rect {
            left,
            top,
            width: side,
            height: side,
        };
        self.samples.clear();
        self.samples.resize(PADDING * self.stride, 0.0);
        let mut tile = Vec::new();
        let lit = image.view().copy(rect, self.stride, &mut tile);
        self.samples.extend_from_slice(&tile);
        self.samples.resize((side + 2 * PADDING) * self.stride, 0.0);
        self.lit.clear();
        for first in (0..self.stride).step_by(LANES) {
            let is_lit = |row: &usize| {
                let start = (PADDING + row) * self.stride + first;
                self.samples[start..start + LANES].iter().any(|v| *v != 0.0)
            };
            let start = (0..side).find(is_lit).unwrap_or(0);
            let end = (0..side).rev().find(is_lit).map_or(start, |row| row + 1);
            self.lit.push(start..end);
        }
        lit
    }
}

/// Spreads the light of a tile at (`left`, `top`) with the kernels that `fir` interpolates: offsets are those of the target from the
/// source.
pub(super) fn spread(fir: &BilinearFir, tile: &TileLight, left: i32, top: i32) -> Image {
    let width = tile.stride + fir.columns.len();
    let height = tile.side + fir.rows.len() + ROWS;
    let mut out = Image::zeros(Rect {
        left: left + fir.columns.start,
        top: top + fir.rows.start,
        width,
        height,
    });
    pulp::Arch::new().dispatch(Spreading {
        runs: fir.runs(),
        taps: fir.taps(),
        tile,
        stride: width,
        out: &mut out.samples,
    });
    out
}

/// [`spread`] for `pulp::Arch::dispatch`.
struct Spreading<'a> {
    runs: &'a [TapRun],
    taps: &'a [[f32; 4]],
    tile: &'a TileLight,
    stride: usize,
    out: &'a mut [f32],
}

impl pulp::WithSimd for Spreading<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let mut places = [0.0_f32; LANES];
        for first in (0..self.tile.stride).step_by(S::F32_LANES) {
            let lit = self.tile.lit[first / LANES].clone();
            if lit.is_empty() {
                continue;
            }
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
                    let mut sums = [simd.splat_f32s(0.0); ROWS];
                    for (k, tap) in taps[..to].iter().enumerate().skip(from) {
                        let source = row + PADDING - run.row - k;
                        let rows = &self.tile.samples[source * self.tile.stride + first..];
                        let y = source as f32 - PADDING as f32 + 0.5;
                        add::<S>(simd, *tap, across, y, rows, self.tile.stride, &mut sums);
                    }
                    let start = row * self.stride + run.column + first;
                    for (i, sum) in sums.into_iter().enumerate() {
                        let at = start + i * self.stride;
                        let out = &mut self.out[at..at + S::F32_LANES];
                        let (out, _) = S::as_mut_simd_f32s(out);
                        out[0] = simd.add_f32s(out[0], sum);
                    }
                }
            }
        }
    }
}

/// Adds one tap to the sums of [`ROWS`] rows; the first source row lies at `y` and the columns at `across`, px from the tile's corner.
#[inline(always)]
fn add<S: pulp::Simd>(
    simd: S,
    [at, by_x, by_y, by_both]: [f32; 4],
    across: S::f32s,
    y: f32,
    sources: &[f32],
    stride: usize,
    sums: &mut [S::f32s; ROWS],
) {
    let change = simd.mul_add_f32s(simd.splat_f32s(by_both), across, simd.splat_f32s(by_y));
    let base = simd.mul_add_f32s(simd.splat_f32s(by_x), across, simd.splat_f32s(at));
    let mut weight = simd.mul_add_f32s(change, simd.splat_f32s(y), base);
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = simd.mul_add_f32s(weight, load::<S>(sources, i * stride), *sum);
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
            let mut light = TileLight::default();
            assert!(light.take(&image, left, top, side));
            let found = spread(&fir, &light, left, top);
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
        assert!(!TileLight::default().take(&image, 16, 16, 16));
    }
}

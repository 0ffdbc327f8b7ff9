//! Local transfer functions of a lens, and filters built from them.
//!
//! A plane is cut into overlapping tiles. In each, the lens is approximated by a convolution with its kernel at the
//! tile's centre, whose transfer function is h(f). A filter multiplies the spectrum of a tile by a function of h and of
//! |D(f)|², the power response of the gradient.

use super::gradient::power_response;
use super::overlapping_tiles::OverlappingTiles;
use super::tile_fft::{FftBuffers, TileFft};
use crate::{LocalKernels, RenderWindow, Scene, kernel_reach};
use rayon::prelude::*;
use seidel_fourier::Complex;
use seidel_optics::error::Result;
use std::f64::consts::PI;

/// Largest side of a tile, px, which bounds time and memory.
const MAX_SIDE: usize = 768;
/// Largest change of the kernel size from one side of a wide tile to the other, as a share of the size.
const MAX_CHANGE: f64 = 0.15;
/// Variance that is added to that of kernels before they are compared, px²: sharp kernels are alike.
const SHARP_VARIANCE_PX2: f64 = 0.5;
/// Means over frequencies look at every fifth. No side is a multiple of five, so these are evenly spread.
const FREQUENCY_STEP: usize = 5;

/// The transfer functions of a lens at one vergence over a plane.
pub(super) struct TransferFunctions {
    pub(super) tiles: OverlappingTiles,
    /// The transfer function of each tile, column by column.
    spectra: Vec<Vec<Complex<f32>>>,
    /// |D|² at each frequency, column by column.
    gradient_power: Vec<f32>,
    fft: TileFft,
}

/// The use of transfer functions, which decides how wide their tiles are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Filters of a whole canvas: the wider the tiles, the better where blur changes slowly.
    Filter,
    /// Filters of a depth layer: most of a wide tile would lie beyond it.
    LayerFilter,
    /// Estimates of noise, and filters without iterations: blur must not change within a tile.
    Local,
}

impl Purpose {
    /// Returns the least side of a tile, px, which is doubled until it is a multiple of the width of the widest kernel, and that
    /// multiple.
    fn least_side(self) -> (usize, f64) {
        match self {
            Self::Filter => (96, 4.0),
            Self::LayerFilter => (96, 1.5),
            Self::Local => (48, 1.0),
        }
    }
}

/// Returns the side of the tiles of a plane of `size` px for a kernel of the width `widest`, px.
///
/// No two pixels of the plane are further apart than its longer side, so a tile of twice that side holds all that a
/// kernel can do.
fn tile_side(size: (usize, usize), widest: f64, purpose: Purpose) -> usize {
    let enough = MAX_SIDE.min(2 * size.0.max(size.1));
    let (mut side, kernels) = purpose.least_side();
    while side < enough && (side as f64) < kernels * widest {
        side *= 2;
    }
    side
}

/// Returns the largest relative change of the kernel size over the plane of `scene`, in 1/px, between points half the plane apart: of
/// all channels, so that the planes of a plate have the same tiles.
fn change_per_px(scene: &Scene) -> Result<f64> {
    let channels = scene.lens.channel_count();
    let mut most = 0.0_f64;
    for channel in 0..channels {
        let mut weights = vec![0.0; channels];
        weights[channel] = 1.0;
        most = most.max(change_of_kernels(
            scene,
            &LocalKernels::new(scene, &weights)?,
        )?);
    }
    Ok(most)
}

fn change_of_kernels(scene: &Scene, kernels: &LocalKernels) -> Result<f64> {
    let along = |size: usize| [0.0, 0.5, 1.0].map(|share| share * size as f64);
    let mut sizes = [[0.0_f64; 3]; 3];
    for (row, y) in sizes.iter_mut().zip(along(scene.height)) {
        for (size, x) in row.iter_mut().zip(along(scene.width)) {
            *size = 0.5 * (kernels.at((x, y))?.variance_px2() + SHARP_VARIANCE_PX2).ln();
        }
    }
    let transposed = [0, 1, 2].map(|k| sizes.map(|row| row[k]));
    let change = |lines: [[f64; 3]; 3], length: usize| {
        let steps = lines.into_iter().flat_map(|[a, b, c]| [b - a, c - b]);
        steps.fold(0.0_f64, |most, step| most.max(step.abs())) / (0.5 * length as f64)
    };
    Ok(change(sizes, scene.width).max(change(transposed, scene.height)))
}

/// The frequencies of a tile whose power is looked at.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stopband {
    /// Those with |h|² below this power.
    Below(f32),
    /// As few as count, those with the least |h|².
    Quietest,
}

/// Returns the power that just over `count` transfer functions are below.
fn nth_power(transfer: &[Complex<f32>], count: usize) -> f32 {
    let mut powers: Vec<f32> = transfer.iter().map(|h| h.norm_sqr()).collect();
    let rank = (count + 1).min(powers.len().saturating_sub(1));
    *powers.select_nth_unstable_by(rank, f32::total_cmp).1
}

/// Median powers of a plane in the stopband of a tile. White noise of unit variance has a mean power of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopbandPower {
    /// Over all of the stopband.
    pub(super) all: f64,
    /// Over its lowest frequencies, next to those that the lens passes.
    pub(super) lowest: f64,
    /// |D|² of the median of those.
    pub(super) lowest_gradient_power: f32,
}

impl TransferFunctions {
    /// Computes the transfer functions of `scene`, at one vergence, for a plane with these channel `weights`.
    ///
    /// # Errors
    /// A lens that cannot be drawn, and a vergence that varies.
    pub(super) fn new(scene: &Scene, weights: &[f64], purpose: Purpose) -> Result<Self> {
        let kernels = LocalKernels::new(scene, weights)?;
        let reach = kernel_reach(scene, RenderWindow::whole(scene), kernels.vergence_per_m());
        let widest = (reach.left_px + reach.right_px).max(reach.up_px + reach.down_px);
        let size = (scene.width, scene.height);
        let [wide, local] =
            [purpose, Purpose::Local].map(|purpose| tile_side(size, widest, purpose));
        // The change costs 27 kernels to know.
        let is_alike = wide == local || wide as f64 * change_per_px(scene)? <= MAX_CHANGE;
        let side = if is_alike { wide } else { local };
        let fft = TileFft::new(side);
        let tiles = OverlappingTiles::new(size, side);
        let spectra = (tiles.tiles)
            .par_iter()
            .map(|tile| Ok(fft.transfer_function(&kernels.at(tiles.centre(*tile))?, size)))
            .collect::<Result<_>>()?;
        let frequency = |k: usize| k as f64 / side as f64;
        let gradient_power = (0..fft.column_count())
            .flat_map(|x| (0..side).map(move |y| power_response(frequency(x), frequency(y)) as f32))
            .collect();
        Ok(Self {
            tiles,
            spectra,
            gradient_power,
            fft,
        })
    }

    /// Returns the transfer function at the point (`x`, `y`) of the plane, interpolated between tiles, for tiles `divisor`
    /// times smaller: at every `divisor`-th frequency.
    pub(super) fn at(&self, x: f64, y: f64, divisor: usize) -> Vec<Complex<f32>> {
        let side = self.tiles.side;
        let around = self.tiles.around(x, y);
        let small_side = side / divisor;
        let columns = (0..small_side / 2 + 1).map(|x| x * divisor);
        let rows = |x: usize| (0..small_side).map(move |y| x * side + y * divisor);
        columns
            .flat_map(rows)
            .map(|frequency| {
                let terms = around.iter();
                terms
                    .map(|tile| self.spectra[tile.index][frequency] * tile.weight)
                    .sum()
            })
            .collect()
    }

    /// Filters `plane`, black beyond its edges: the spectrum of each tile is multiplied by `gain(h, |D|²)`. Tiles without
    /// `coverage` give zero. The filter is a symmetric operator if `gain` is real.
    pub(super) fn filter(
        &self,
        plane: &[f32],
        coverage: Option<&[f32]>,
        gain: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        self.filter_tiles(plane, coverage, |tile, frequency| {
            let h = self.spectra[tile][frequency];
            gain(h, self.gradient_power[frequency])
        })
    }

    /// Filters `plane` like [`Self::filter`], by `gain(h, r, |D|²)` with the transfer functions r of another lens on the
    /// same plane.
    pub(super) fn convert(
        &self,
        to: &Self,
        plane: &[f32],
        coverage: Option<&[f32]>,
        gain: impl Fn(Complex<f32>, Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        self.filter_tiles(plane, coverage, |tile, frequency| {
            let (h, r) = (self.spectra[tile][frequency], to.spectra[tile][frequency]);
            gain(h, r, self.gradient_power[frequency])
        })
    }

    /// Multiplies the spectrum of each tile of `plane` by `gain(tile, frequency)`, both indices.
    fn filter_tiles(
        &self,
        plane: &[f32],
        coverage: Option<&[f32]>,
        gain: impl Fn(usize, usize) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let tiles = self.tiles.tiles.par_iter().enumerate();
        let filtered: Vec<Option<Vec<f32>>> = tiles
            .map_init(FftBuffers::default, |buffers, (index, tile)| {
                if coverage.is_some_and(|coverage| self.tiles.is_uncovered(coverage, *tile)) {
                    return None;
                }
                let mut samples = self.tiles.cut(plane, *tile);
                self.fft.forward(&mut samples, buffers);
                for (frequency, value) in buffers.spectrum.iter_mut().enumerate() {
                    *value *= gain(index, frequency);
                }
                self.fft.inverse(buffers, &mut samples);
                Some(samples)
            })
            .collect();
        self.tiles.overlap_add(&filtered)
    }

    /// Returns the mean of `value(h, |D|²)` over all frequencies of each tile, interpolated by the tiles' windows.
    pub(super) fn mean_over_frequencies(
        &self,
        value: impl Fn(Complex<f32>, f32) -> f32 + Sync,
    ) -> Vec<f32> {
        let means: Vec<Option<Vec<f32>>> = self
            .spectra
            .par_iter()
            .map(|transfer| {
                let frequencies = transfer.iter().zip(&self.gradient_power);
                let values = frequencies.step_by(FREQUENCY_STEP);
                let sum: f64 = values
                    .map(|(h, gradient_power)| f64::from(value(*h, *gradient_power)))
                    .sum();
                let count = transfer.len().div_ceil(FREQUENCY_STEP) as f64;
                Some(self.tiles.constant((sum / count) as f32))
            })
            .collect();
        self.tiles.overlap_add(&means)
    }

    /// Returns the powers of `plane` in the stopband of each tile, the frequencies of `band`.
    ///
    /// Tiles count that lie wholly on the plane, with `coverage` everywhere, and have at least `min_frequencies` in the
    /// stopband.
    pub(super) fn stopband_powers(
        &self,
        plane: &[f32],
        coverage: Option<&[f32]>,
        band: Stopband,
        min_frequencies: usize,
    ) -> Vec<StopbandPower> {
        let side = self.fft.side;
        // A Hann window: its side lobes are low, so that strong low frequencies do not leak into the stopband.
        let hann: Vec<f32> = (0..side)
            .map(|k| (PI * (k as f64 + 0.5) / side as f64).sin().powi(2) as f32)
            .collect();
        let energy = hann.iter().map(|w| w * w).sum::<f32>().powi(2);
        let is_usable = |tile| {
            self.tiles.is_inside(tile)
                && coverage.is_none_or(|coverage| self.tiles.is_covered(coverage, tile))
        };
        let tiles = self.tiles.tiles.par_iter();
        tiles
            .zip(&self.spectra)
            .map_init(FftBuffers::default, |buffers, (tile, transfer)| {
                if !is_usable(*tile) {
                    return None;
                }
                let mut samples = Vec::with_capacity(side * side);
                for (row, wy) in self.tiles.row_spans(*tile).zip(&hann) {
                    let row = plane[row.in_plane..][..side].iter().zip(&hann);
                    samples.extend(row.map(|(sample, wx)| wy * wx * sample));
                }
                self.fft.forward(&mut samples, buffers);
                let spectrum = buffers.spectrum.iter().zip(&self.gradient_power);
                let limit = match band {
                    Stopband::Below(power) => power,
                    Stopband::Quietest => nth_power(transfer, min_frequencies),
                };
                let mut powers: Vec<(f32, f32)> = (spectrum.zip(transfer))
                    .filter(|(_, h)| h.norm_sqr() < limit)
                    .map(|((value, gradient), _)| (*gradient, value.norm_sqr() / energy))
                    .collect();
                (powers.len() >= min_frequencies).then(|| {
                    powers.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
                    let median = |powers: &[(f32, f32)]| {
                        let mut powers: Vec<f32> = powers.iter().map(|(_, power)| *power).collect();
                        let middle = powers.len() / 2;
                        let (_, median, _) = powers.select_nth_unstable_by(middle, f32::total_cmp);
                        f64::from(*median)
                    };
                    let lowest = &powers[..min_frequencies];
                    StopbandPower {
                        all: median(&powers),
                        lowest: median(lowest),
                        lowest_gradient_power: lowest[min_frequencies / 2].0,
                    }
                })
            })
            .flatten()
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_wider_than_the_kernel_but_no_wider_than_a_small_plane_needs() {
        let whole = |size, widest| tile_side(size, widest, Purpose::Filter);
        assert_eq!(whole((1920, 1080), 10.0), 96);
        assert_eq!(whole((1920, 1080), 40.0), 192);
        assert_eq!(whole((1920, 1080), 5000.0), 768);
        assert_eq!(whole((48, 40), 5000.0), 96);
        assert_eq!(whole((40, 50), 5000.0), 192);
        assert_eq!(whole((1, 1), 5000.0), 96);
        assert_eq!(tile_side((1920, 1080), 40.0, Purpose::LayerFilter), 96);
        assert_eq!(tile_side((1920, 1080), 40.0, Purpose::Local), 48);
    }
}

//! Estimates of the noise of a plate from frequencies that its lens blocks.
//!
//! In the stopband of the lens the plate has noise alone. The power of white noise at a frequency is exponentially
//! distributed, so its variance is the median power / ln 2.

use super::canvas::{Canvas, window_scene};
use super::layer_cut::{LayerCut, covered_window};
use super::transfer_functions::{Purpose, Stopband, StopbandPower, TransferFunctions};
use super::winsorised::WinsorisedStatistics;
use crate::{Plane, RenderWindow, Scene, VergencePass};
use seidel_optics::error::Result;
use std::f64::consts::LN_2;

/// Median of the absolute value of a standard normal deviate.
const MEDIAN_ABS_NORMAL: f64 = 0.674_489_75;
/// Frequencies of which the lens passes less than this share of the power are its stopband.
const STOPBAND_POWER: f32 = 1e-6;
/// Share of the tiles that are quieter than the one from which the noise of a lens without a stopband is estimated.
const QUIET_TILES: f64 = 0.25;
/// Least number of stopband frequencies in a tile that is used.
const MIN_FREQUENCIES: usize = 64;
/// Ratio of the noise at the lowest frequencies of the stopband to that at all from which neighbouring pixels share it: about
/// 1.1 for white noise, 10 for film grain of a few pixels, and as much where there is no noise but a little of the picture.
const SHARED_NOISE_GROWTH: f64 = 2.0;
/// Share of the tiles that may show less than that: grain is everywhere, while what a wrong lens leaves of the picture in the
/// stopband is beside its edges.
const WHITE_TILES_SHARE: f64 = 0.1;
/// Least number of tiles that can tell the two apart.
const MIN_SHARED_TILES: usize = 2;
/// Least noise in the stopband that can be shared, as a share of the brightest light: less is the picture.
const LEAST_SHARED_NOISE: f64 = 2e-5;
/// Noise that neighbouring pixels share at frequencies that the lens passes, over that at the lowest ones it blocks.
const PASSBAND_GROWTH: f64 = 2.2;
/// Noise that the lens blocks, as a share of the noise that the user states, below which the statement covers other errors of
/// the plate as well.
const LEAST_STATED_SHARE: f64 = 0.3;
/// Margin about the plate, as a share of the reach of kernels.
const MARGIN_SHARE: f64 = 0.6;
/// Largest number of samples from which the quantisation step is estimated.
const MAX_SAMPLES: usize = 8192;
/// Least number of distinct levels: planes with fewer are masks, which say nothing about quantisation.
const MIN_LEVELS: usize = 16;

/// The noise of a plane, as the standard deviation of white noise of the same power.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoiseEstimate {
    /// At the frequencies that the lens passes.
    pub(super) deviation: f64,
    /// At those that it blocks: less for film grain and other noise that neighbouring pixels share.
    pub(super) blocked: f64,
}

impl NoiseEstimate {
    /// Returns the least noise of a plate whose `noise` was stated or estimated: that at the frequencies that the lens blocks,
    /// where the residual is noise alone.
    pub(super) fn least(&self, noise: f64) -> f64 {
        let is_shared = self.blocked < self.deviation;
        if is_shared || self.blocked >= LEAST_STATED_SHARE * noise {
            noise.min(self.blocked)
        } else {
            noise
        }
    }
}

/// Estimates the noise of `plane`, a plane of the plate of `scene`.
///
/// It is estimated from the stopband of the lens, in the median tile. If the lens has no stopband, it is estimated from the
/// frequencies that the lens passes least, in a quiet tile, and by [`haar_noise`] where no tile lies on the plate. It is at least the
/// [`quantisation_noise`].
///
/// # Errors
/// A lens that cannot be drawn.
pub(super) fn estimate_noise(scene: &Scene, plane: &Plane) -> Result<NoiseEstimate> {
    let bands = Bands::new(scene, plane)?;
    let plane = plane.samples;
    let found = bands.stopband_noise().unwrap_or_else(|| {
        let deviation = bands
            .quietest_noise()
            .unwrap_or_else(|| haar_noise(plane, scene.width));
        NoiseEstimate {
            deviation,
            blocked: deviation,
        }
    });
    let least = quantisation_noise(plane);
    Ok(NoiseEstimate {
        deviation: found.deviation.max(least),
        blocked: found.blocked.max(least),
    })
}

/// The spectra of a plane, for estimates of its noise.
struct Bands {
    samples: Vec<f32>,
    width: usize,
    layers: Vec<BandLayer>,
}

/// A part of the plane at one vergence.
struct BandLayer {
    transfer: TransferFunctions,
    window: RenderWindow,
    /// Share of each pixel of the window that is in the layer; `None` if all of the plane is.
    coverage: Option<Vec<f32>>,
}

impl Bands {
    /// Extends the plane by mirroring it, so that tiles beside its edges count.
    fn new(plate: &Scene, plane: &Plane) -> Result<Self> {
        let canvas = Canvas::of_share(plate, MARGIN_SHARE);
        let pass = match plate.vergence {
            VergencePass::PerPixel(pass) => Some(canvas.extend_by_replication(pass)),
            VergencePass::Constant(_) => None,
        };
        let scene = &canvas.scene(plate, pass.as_deref());
        let transfer = |scene: &Scene| TransferFunctions::new(scene, plane.weights, Purpose::Local);
        let layers = match scene.vergence {
            VergencePass::Constant(_) => vec![BandLayer {
                transfer: transfer(scene)?,
                window: RenderWindow::whole(scene),
                coverage: None,
            }],
            VergencePass::PerPixel(pass) => LayerCut::new(scene, pass)
                .coverages()
                .filter_map(|(vergence, coverage)| {
                    let window = covered_window(&coverage, scene.width)?;
                    let part = Scene {
                        vergence: VergencePass::Constant(vergence),
                        ..window_scene(scene, window)
                    };
                    Some(transfer(&part).map(|transfer| BandLayer {
                        transfer,
                        window,
                        coverage: Some(window.cut(scene.width, &coverage)),
                    }))
                })
                .collect::<Result<_>>()?,
        };
        Ok(Self {
            samples: canvas.extend_by_mirroring(plane.samples),
            width: scene.width,
            layers,
        })
    }

    /// Returns the powers in a band of each usable tile ([`TransferFunctions::stopband_powers`]).
    fn powers(&self, band: Stopband) -> Vec<StopbandPower> {
        let powers = self.layers.iter().flat_map(|layer| {
            let samples = layer.window.cut(self.width, &self.samples);
            let coverage = layer.coverage.as_deref();
            (layer.transfer).stopband_powers(&samples, coverage, band, MIN_FREQUENCIES)
        });
        powers.collect()
    }

    /// Returns the noise in the stopband of the lens, or nothing if no tile has enough of a stopband.
    ///
    /// Noise that neighbouring pixels share is weaker the higher the frequency. Where that is seen within the stopband, the noise
    /// beside it is extrapolated from the tiles in which the stopband reaches the lowest frequencies.
    fn stopband_noise(&self) -> Option<NoiseEstimate> {
        let mut powers = self.powers(Stopband::Below(STOPBAND_POWER));
        let deviation = |median_power: f64| (median_power / LN_2).sqrt();
        let blocked = deviation(median(powers.iter().map(|power| power.all))?);
        let growth = powers.iter().map(|power| (power.lowest / power.all).sqrt());
        let grows = growth.filter(|growth| *growth >= SHARED_NOISE_GROWTH);
        let others = powers.len() - grows.count();
        let is_shared = powers.len() >= MIN_SHARED_TILES
            && others as f64 <= WHITE_TILES_SHARE * powers.len() as f64;
        let light = WinsorisedStatistics::of_absolute(&self.samples).percentile_99;
        if !is_shared || blocked < LEAST_SHARED_NOISE * light {
            return Some(NoiseEstimate {
                deviation: blocked,
                blocked,
            });
        }
        powers.sort_by(|a, b| (a.lowest_gradient_power).total_cmp(&b.lowest_gradient_power));
        let lowest = powers[..powers.len().div_ceil(4)].iter();
        Some(NoiseEstimate {
            deviation: PASSBAND_GROWTH * deviation(median(lowest.map(|power| power.lowest))?),
            blocked,
        })
    }

    /// Returns the noise at the frequencies of each tile that the lens passes least, in a quiet tile: texture adds to it.
    fn quietest_noise(&self) -> Option<f64> {
        let powers = self.powers(Stopband::Quietest);
        let mut powers: Vec<f64> = powers.iter().map(|power| power.all).collect();
        let rank = (QUIET_TILES * powers.len() as f64) as usize;
        (!powers.is_empty()).then(|| {
            let (_, quiet, _) = powers.select_nth_unstable_by(rank, f64::total_cmp);
            (*quiet / LN_2).sqrt()
        })
    }
}

/// Returns the standard deviation of rounding to the levels that occur in `plane`: 1 / sqrt(12) of the median step
/// between them. It is next to nothing for samples of many bits.
fn quantisation_noise(plane: &[f32]) -> f64 {
    let step = plane.len().div_ceil(MAX_SAMPLES).max(1);
    let mut levels: Vec<f32> = plane.iter().step_by(step).copied().collect();
    levels.sort_unstable_by(f32::total_cmp);
    levels.dedup();
    if levels.len() < MIN_LEVELS {
        return 0.0;
    }
    let mut steps: Vec<f32> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / 12.0_f64.sqrt()
}

/// Returns the median of some numbers, if there are any.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Returns the standard deviation of white noise in a plane `width` samples wide, from the median absolute diagonal Haar
/// detail of the finest scale (Donoho and Johnstone 1994). Fine detail of the image counts as noise.
pub(super) fn haar_noise(plane: &[f32], width: usize) -> f64 {
    let mut details = Vec::with_capacity(plane.len() / 4);
    for rows in plane.chunks_exact(2 * width.max(1)) {
        let (upper, lower) = rows.split_at(width);
        let blocks = upper.chunks_exact(2).zip(lower.chunks_exact(2));
        details.extend(blocks.map(|(up, low)| ((up[0] - up[1] - low[0] + low[1]) / 2.0).abs()));
    }
    if details.is_empty() {
        return 0.0;
    }
    let middle = details.len() / 2;
    let (_, median, _) = details.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / MEDIAN_ABS_NORMAL
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::{WEIGHTS, lens, plate, scene};
    use super::*;

    #[test]
    fn noise_of_a_plate_is_estimated_within_6_percent() {
        let lens = lens(1.0);
        let scene = scene(&lens);
        for noise in [0.001, 0.01, 0.03] {
            let samples = plate(noise);
            let plane = Plane {
                samples: &samples,
                weights: &WEIGHTS,
            };
            let estimate = estimate_noise(&scene, &plane).expect("a valid lens");
            let estimate = estimate.deviation;
            assert!((estimate / noise - 1.0).abs() < 0.06, "{noise}: {estimate}");
        }
    }

    #[test]
    fn stated_noise_is_lowered_to_noise_that_is_seen() {
        let white = |blocked| NoiseEstimate {
            deviation: blocked,
            blocked,
        };
        assert_eq!(white(0.01).least(0.02), 0.01);
        assert_eq!(white(0.01).least(0.005), 0.005);
        assert_eq!(white(1e-5).least(0.003), 0.003);
        let grain = NoiseEstimate {
            deviation: 0.01,
            blocked: 0.0005,
        };
        assert_eq!(grain.least(0.01), 0.0005);
    }

    #[test]
    fn quantisation_is_found_in_planes_of_few_levels_only() {
        let smooth: Vec<f32> = (0..20_000)
            .map(|k| 0.5 + 0.4 * (0.013 * k as f32).sin())
            .collect();
        let rounded = |levels: f32| -> Vec<f32> {
            smooth
                .iter()
                .map(|v| (v * levels).round() / levels)
                .collect()
        };
        let eight = quantisation_noise(&rounded(255.0));
        assert!(
            (eight * 255.0 * 12.0_f64.sqrt() - 1.0).abs() < 1e-3,
            "{eight}"
        );
        assert!(quantisation_noise(&rounded(65_535.0)) < 5e-5);
        assert!(quantisation_noise(&smooth) < 5e-5);
        // A mask has two levels.
        assert_eq!(quantisation_noise(&rounded(1.0)), 0.0);
    }
}

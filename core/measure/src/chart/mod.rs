//! PSFs of a photograph of a known chart, block by block.
//!
//! 1. The chart is found by its corner marks or its texture (`finding`), and registered on binned images from coarse to
//!    fine: a homography, then a polynomial of third order.
//! 2. Each block of the photograph is compared with the chart as it would appear without blur: a non-negative PSF and the
//!    slope of the light follow by least squares on raw pixels of one colour (`block`).
//! 3. The centroids of these PSFs show where the map is wrong. The polynomial absorbs what is smooth of them, and the
//!    second step is repeated: registration and PSFs are estimated together.

mod alignment;
mod block;
mod block_estimate;
mod block_grid;
mod coarse;
mod finding;
mod judgement;
mod kernel;
mod map;
mod marks;
mod picture;
mod quadrilateral;
mod set;
mod sharp;
#[cfg(test)]
mod tests;
mod variation;

pub use map::ChartMap;
pub use picture::{ChartPicture, Content};
pub use set::ChartSet;
pub use sharp::sharp_plane;

use rayon::prelude::*;
use seidel_optics::Progress;
use seidel_optics::error::{Error, ErrorKind, Result};

use crate::checks::Concern;
use crate::photograph::Photograph;
use crate::rejection::Reason;
use block::{BlockTask, Failure, SharpView};
use block_estimate::BlockEstimate;
use kernel::{Filters, Integration, centroid};
use map::Displacement;
use picture::{Aperture, Grid, Region};
use seidel_optics::numeric::{median, quantile};
use variation::Variation;

/// Settings of [`measure_chart`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ChartSettings {
    /// Odd width and height of the tiles, px; chosen from the blur if `None`.
    pub tile: Option<usize>,
    /// Corners of the chart in the photograph, from the chart's top left clockwise; found if `None`.
    pub corners: Option<[[f64; 2]; 4]>,
    /// Whether the chart is a photograph from the same place, so that pixels correspond but for small motions.
    pub same_view: bool,
    /// Standard deviation of a blur to add to the tiles: that of a chart which is not sharp, px.
    pub added_sigma_px: f64,
}

/// A block that was measured.
#[derive(Debug, Clone)]
pub struct MeasuredBlock {
    /// Column and row of the tile's central pixel, at the centre of the block.
    pub centre: [usize; 2],
    /// Width and height of the block, px.
    pub size: [usize; 2],
    /// Tiles by channel: light of unit sum in area-integrated pixels.
    pub tiles: Vec<Vec<f64>>,
    /// Standard deviation of a sample of the tile by channel.
    pub sigma: Vec<f64>,
    /// Mean squared residual over the variance of photon noise, by channel.
    pub chi_square: Vec<f64>,
}

/// A block that was not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOutBlock {
    /// Photograph position of its centre.
    pub at: [f64; 2],
    /// The reason.
    pub why: Reason,
    /// The value that led to it, as [`Reason::quantity`] says.
    pub value: f64,
    /// The limit that it crossed.
    pub limit: f64,
}

/// The blocks of one photograph.
#[derive(Debug, Clone)]
pub struct ChartMeasurement {
    /// Blocks that were kept, from top to bottom.
    pub blocks: Vec<MeasuredBlock>,
    /// Blocks that were left out.
    pub left_out: Vec<LeftOutBlock>,
    /// Photograph positions to chart positions.
    pub map: ChartMap,
    /// Width and height of the chart's picture, px.
    pub chart_size: [usize; 2],
    /// Median distance of the blocks' centroids from the smooth map, px.
    pub registration_px: f64,
    /// Odd width and height of the tiles, px.
    pub side: usize,
    /// Whether the paper around the chart is as white as the chart, so that blocks reach its border.
    pub has_white_surround: bool,
    /// Faults of the photograph.
    pub concerns: Vec<Concern>,
}

/// First tile, and the largest, px.
const FIRST_SIDE: usize = 13;
const LARGEST_SIDE: usize = 41;
const SIDE_STEP: usize = 4;
/// Blocks that a photograph needs.
const MIN_KEPT: usize = 3;
/// Largest distance of a block's centroid from the smooth map, px, and largest misfit over the typical one.
const MAX_DEPARTURE_PX: f64 = 0.6;
const MAX_CHI_RATIO: f64 = 12.0;
/// Least fine detail of a block's chart over the largest of all blocks.
const MIN_DETAIL: f64 = 0.75;
/// Pixels around a chart that say how bright its surround is; how much its level may depart from white, and vary.
const MIN_SURROUND: usize = 200;
const SURROUND_LEVEL: f64 = 0.15;
const SURROUND_SPREAD: f64 = 0.1;
/// Light in the outer two rings of the median tile from which on tiles are enlarged.
const OUTER_LIGHT: f64 = 0.03;
/// Alternations between tile and slope of the light, while registering and at the end.
const REGISTRATION_LIGHT_STEPS: usize = 2;
const LIGHT_STEPS: usize = 3;
/// Estimates of the PSFs with the change over each block that the former ones show.
const VARIATION_ROUNDS: usize = 2;
/// Rounds of registration.
const ROUNDS: usize = 4;
/// Largest ratio of the displacements of blocks to their residuals after a fit of the map at which registration has converged.
const CONVERGED_RATIO: f64 = 1.1;
/// Read noise of a typical sensor, electrons. The weights of bright pixels hardly depend on it.
const READ_NOISE_E: f64 = 5.0;

/// Measures `photo` of a chart: one picture for all channels, or one for each.
///
/// # Errors
/// The reasons of [`finding`](self): no chart, another one, several, turned, mirrored or clipped; fewer than three blocks
/// that could be measured.
pub fn measure_chart(
    photo: &Photograph,
    charts: &[ChartPicture],
    settings: &ChartSettings,
    progress: &Progress,
) -> Result<ChartMeasurement> {
    photo.check()?;
    let reference = photo.reference_channel();
    let chart = charts.get(reference).or(charts.first());
    let Some(chart) = chart.filter(|_| charts.len() == 1 || charts.len() == photo.channels.len())
    else {
        return Err(Error::new(
            "charts",
            "are neither one nor one for each channel",
            "give the picture that was photographed",
        ));
    };
    let aligned = finding::find(photo, chart, settings)?;
    let gain = photo.assumed_gain();
    let integration = Integration {
        soft: chart.content() == Content::Cells,
        // A sharp photograph's own blur.
        added_sigma_px: settings.added_sigma_px,
    };
    let mut measurement = Measurement {
        photo,
        charts,
        map: aligned.map,
        side: settings.tile.unwrap_or(FIRST_SIDE),
        // A quarter of a step is the least noise of whole counts.
        dark_variance: (READ_NOISE_E * gain)
            .powi(2)
            .max(0.25 * photo.errors.quantum.powi(2)),
        gain,
        has_white_surround: false,
        filters: integration.filters(),
    };
    let registration_px = measurement.register(reference, settings.tile.is_none(), progress)?;
    let blocks = measurement.blocks();
    let mut by_channel = Vec::new();
    for channel in 0..photo.channels.len() {
        by_channel.push(measurement.estimate_changing(&blocks, channel));
        report(
            progress,
            0.5 + 0.5 * (channel + 1) as f64 / photo.channels.len() as f64,
        )?;
    }
    let (mut kept, mut left_out) = (Vec::new(), Vec::new());
    let typical = Typical::of(&by_channel[reference]);
    for (k, block) in blocks.iter().enumerate() {
        let estimates: std::result::Result<Vec<&BlockEstimate>, Failure> = by_channel
            .iter()
            .map(|c| c[k].as_ref().map_err(|f| *f))
            .collect();
        match estimates.and_then(|e| measurement.checked(e, reference, &typical)) {
            Ok(estimates) => kept.push(measured(block, &estimates, &measurement)),
            Err(failure) => left_out.push(LeftOutBlock {
                at: centre(block),
                why: failure.why,
                value: failure.value,
                limit: failure.limit,
            }),
        }
    }
    if kept.len() < MIN_KEPT {
        return Err(too_few(photo, kept.len()));
    }
    let of_reference: Vec<&BlockEstimate> = by_channel[reference].iter().flatten().collect();
    let concerns = judgement::of_photograph(photo, &of_reference, &kept, measurement.side);
    Ok(ChartMeasurement {
        concerns,
        blocks: kept,
        left_out,
        map: measurement.map,
        chart_size: chart.size(),
        registration_px,
        side: measurement.side,
        has_white_surround: measurement.has_white_surround,
    })
}

fn report(progress: &Progress, share: f64) -> Result<()> {
    if progress(share) {
        Ok(())
    } else {
        Err(Error::cancelled("measurement of the chart"))
    }
}

/// Median misfit and largest detail of the blocks, with which each is compared.
struct Typical {
    chi_square: f64,
    detail: f64,
}

impl Typical {
    fn of(estimates: &[Estimated]) -> Self {
        let mut chi_squares: Vec<f64> = estimates.iter().flatten().map(|e| e.chi_square).collect();
        Self {
            chi_square: median(&mut chi_squares),
            detail: estimates
                .iter()
                .flatten()
                .map(|e| e.detail)
                .fold(0.0, f64::max),
        }
    }
}

/// The estimate of a block, or the reason why there is none.
type Estimated = std::result::Result<BlockEstimate, Failure>;

/// The state of a measurement.
struct Measurement<'a> {
    photo: &'a Photograph,
    charts: &'a [ChartPicture],
    map: ChartMap,
    side: usize,
    dark_variance: f64,
    gain: f64,
    has_white_surround: bool,
    /// The step from kernels to tiles.
    filters: Filters,
}

impl Measurement<'_> {
    /// Estimates map and PSFs in turn, and returns the median distance of centroids from the smooth map, px.
    fn register(
        &mut self,
        reference: usize,
        choose_side: bool,
        progress: &Progress,
    ) -> Result<f64> {
        let mut remaining = f64::INFINITY;
        for round in 0..ROUNDS {
            let mut blocks = self.blocks();
            let mut estimates = self.estimate(&blocks, reference, REGISTRATION_LIGHT_STEPS);
            // Values that are no light need tiles of any size.
            let sound: Vec<&BlockEstimate> = estimates.iter().flatten().collect();
            let is_light = judgement::bend(&sound).is_none();
            let choose_side = choose_side && is_light;
            while choose_side && self.needs_larger_tiles(&estimates) && self.side < LARGEST_SIDE {
                self.side = (self.side + SIDE_STEP).min(LARGEST_SIDE);
                blocks = self.blocks();
                estimates = self.estimate(&blocks, reference, REGISTRATION_LIGHT_STEPS);
            }
            let displacements: Vec<Displacement> = (blocks.iter().zip(&estimates))
                .filter_map(|(block, estimate)| {
                    Some(Displacement {
                        at: centre(block),
                        shift: centroid(&estimate.as_ref().ok()?.kernel, self.side),
                    })
                })
                .collect();
            if displacements.len() < MIN_KEPT {
                return Err(none_kept(self.photo, &blocks, &estimates));
            }
            let lengths = displacements.iter().map(|d| d.shift[0].hypot(d.shift[1]));
            let moved = median(&mut lengths.collect::<Vec<f64>>());
            remaining = self.map.correct(&displacements);
            if round == 0 {
                self.has_white_surround = self.surround_is_white(&estimates);
            }
            report(progress, 0.5 * (round + 1) as f64 / ROUNDS as f64)?;
            if moved < CONVERGED_RATIO * remaining {
                break;
            }
        }
        Ok(remaining)
    }

    fn chart(&self, channel: usize) -> &ChartPicture {
        &self.charts[channel.min(self.charts.len() - 1)]
    }

    /// Returns whether the photograph around the chart is even and as bright as its white.
    fn surround_is_white(&self, estimates: &[Estimated]) -> bool {
        let channel = self.photo.reference_channel();
        if self.chart(channel).content() == Content::Photograph {
            return false;
        }
        let whites = estimates.iter().flatten().map(|e| e.white);
        let white = median(&mut whites.collect::<Vec<f64>>());
        let plane = &self.photo.planes[self.photo.plane_of(channel)];
        let [width, height] = self.chart(channel).size().map(|v| v as f64);
        let (near, far) = (self.side as f64 / 2.0, 1.5 * self.side as f64);
        let mut values = Vec::new();
        for y in 0..self.photo.height {
            for x in (0..self.photo.width).filter(|x| self.photo.covers(channel, *x, y)) {
                let at = [x as f64 + 0.5, y as f64 + 0.5];
                let [u, v] = self.map.chart_of(at);
                let outside = |at: f64, most: f64| (-at).max(at - most).max(0.0);
                let off = outside(u, width).max(outside(v, height));
                if off <= 0.0 {
                    continue;
                }
                // The scale of the map: chart pixels over photograph pixels.
                let [u1, v1] = self.map.chart_of([at[0] + 1.0, at[1]]);
                let distance = off / (u1 - u).hypot(v1 - v).max(1e-9);
                if (near..far).contains(&distance) {
                    values.push(f64::from(plane[y * self.photo.width + x]));
                }
            }
        }
        if values.len() < MIN_SURROUND {
            return false;
        }
        let level = median(&mut values.clone());
        let spread = seidel_optics::numeric::scatter(&values);
        (level / white - 1.0).abs() < SURROUND_LEVEL && spread < SURROUND_SPREAD * level
    }

    /// Returns the estimates of a block, or the reason to leave it out.
    fn checked<'e>(
        &self,
        estimates: Vec<&'e BlockEstimate>,
        reference: usize,
        typical: &Typical,
    ) -> std::result::Result<Vec<&'e BlockEstimate>, Failure> {
        let estimate = estimates[reference];
        let [x, y] = centroid(&estimate.kernel, self.side);
        if x.hypot(y) > MAX_DEPARTURE_PX {
            return Err(Failure {
                why: Reason::Registration,
                value: x.hypot(y),
                limit: MAX_DEPARTURE_PX,
            });
        }
        // Marks are too coarse to determine a PSF.
        let detail = estimate.detail / typical.detail.max(1e-30);
        if self.chart(reference).content() == Content::Cells && detail < MIN_DETAIL {
            return Err(Failure {
                why: Reason::LowContrast,
                value: detail,
                limit: MIN_DETAIL,
            });
        }
        let ratio = estimate.chi_square / typical.chi_square.max(1.0);
        if ratio > MAX_CHI_RATIO {
            return Err(Failure {
                why: Reason::UnlikeNeighbours,
                value: ratio,
                limit: MAX_CHI_RATIO,
            });
        }
        Ok(estimates)
    }

    fn estimate(&self, blocks: &[Region], channel: usize, light_steps: usize) -> Vec<Estimated> {
        let unknown = vec![None; blocks.len()];
        self.estimate_with(blocks, &unknown, channel, light_steps)
    }

    /// Estimates the PSF at the centre of each block, where it changes over the block as it does from block to block.
    fn estimate_changing(&self, blocks: &[Region], channel: usize) -> Vec<Estimated> {
        let mut estimates = self.estimate(blocks, channel, LIGHT_STEPS);
        for _ in 0..VARIATION_ROUNDS {
            let found = blocks.iter().zip(&estimates);
            let found: Vec<([f64; 2], &BlockEstimate)> = found
                .filter_map(|(block, e)| Some((centre(block), e.as_ref().ok()?)))
                .collect();
            let variations: Vec<Option<Variation>> = (blocks.iter())
                .map(|block| Variation::around(centre(block), &found))
                .collect();
            estimates = self.estimate_with(blocks, &variations, channel, LIGHT_STEPS);
        }
        estimates
    }

    fn estimate_with(
        &self,
        blocks: &[Region],
        variations: &[Option<Variation>],
        channel: usize,
        light_steps: usize,
    ) -> Vec<Estimated> {
        (blocks.par_iter().zip(variations))
            .map(|(block, variation)| {
                let half = (self.side / 2) as i64;
                let region = Region {
                    left: block.left - half,
                    top: block.top - half,
                    width: block.width + 2 * half as usize,
                    height: block.height + 2 * half as usize,
                };
                let sharp = SharpView {
                    region,
                    values: self.chart(channel).rendered(
                        &self.map,
                        &Grid::of(region),
                        Aperture::Soft,
                    ),
                };
                let task = BlockTask {
                    photo: self.photo,
                    channel,
                    sharp: &sharp,
                    block: *block,
                    side: self.side,
                    variation: variation.as_ref(),
                    light_steps,
                    dark_variance: self.dark_variance,
                    gain: self.gain,
                    integration: &self.filters,
                };
                task.estimate()
            })
            .collect()
    }

    /// Returns whether the outer rings of a typical tile hold light.
    fn needs_larger_tiles(&self, estimates: &[Estimated]) -> bool {
        let side = self.side;
        let mut outer: Vec<f64> = (estimates.iter().flatten())
            .map(|e| {
                let ring = |k: usize| {
                    let (x, y) = (k % side, k / side);
                    x.min(y).min(side - 1 - x).min(side - 1 - y) < 2
                };
                e.kernel
                    .iter()
                    .enumerate()
                    .filter(|(k, _)| ring(*k))
                    .map(|(_, v)| v)
                    .sum()
            })
            .collect();
        quantile(&mut outer, 0.75) > OUTER_LIGHT
    }
}

fn centre(block: &Region) -> [f64; 2] {
    [
        block.left as f64 + block.width as f64 / 2.0,
        block.top as f64 + block.height as f64 / 2.0,
    ]
}

/// Sample of a tile over its largest whose relative error is stated for all. With it the stated errors of green tiles of an 8-bit
/// development of a simulated chart are those found; without it they were four times too small.
const TYPICAL_SAMPLE: f64 = 2.0 / 3.0;
/// Error of a sample by registration and by the change of the PSF within a block, over the peak of its tile. With it 93 to 96 % of the
/// samples of a simulated raw chart lie within 1.96 standard deviations; without it 86 to 94 %.
const MODEL_ERROR: f64 = 0.005;

fn measured(
    block: &Region,
    estimates: &[&BlockEstimate],
    measurement: &Measurement<'_>,
) -> MeasuredBlock {
    let [x, y] = centre(block);
    let tiles: Vec<Vec<f64>> = (estimates.iter())
        .map(|e| measurement.filters.of(&e.kernel, measurement.side))
        .collect();
    // Errors of developed samples follow the signal, and no noise shows them.
    let relative = MODEL_ERROR.hypot(TYPICAL_SAMPLE * measurement.photo.errors.relative);
    let sigma = estimates.iter().zip(&tiles).map(|(estimate, tile)| {
        let largest = tile.iter().copied().fold(0.0, f64::max);
        estimate.sigma.hypot(relative * largest)
    });
    MeasuredBlock {
        centre: [x as usize, y as usize],
        size: [block.width, block.height],
        sigma: sigma.collect(),
        tiles,
        chi_square: estimates.iter().map(|e| e.chi_square).collect(),
    }
}

fn none_kept(photo: &Photograph, blocks: &[Region], estimates: &[Estimated]) -> Error {
    let clipped = |e: &&Estimated| matches!(e, Err(f) if f.why == Reason::Clipped);
    let clipped = estimates.iter().filter(clipped).count();
    if clipped > 0 && 2 * clipped >= blocks.len() {
        return Error::new(
            format!("photograph {}", photo.name),
            format!("clips in {clipped} of {} blocks of the chart", blocks.len()),
            "expose less: the white of the chart at half to two thirds of clipping",
        )
        .with_kind(ErrorKind::InsufficientData);
    }
    too_few(photo, estimates.iter().flatten().count())
}

fn too_few(photo: &Photograph, count: usize) -> Error {
    Error::new(
        format!("photograph {}", photo.name),
        format!("has {count} blocks of the chart that could be measured"),
        "photograph the chart larger, evenly lit and without clipping",
    )
    .with_kind(ErrorKind::InsufficientData)
}

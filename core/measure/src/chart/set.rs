//! The observation set of photographs of a chart.

use seidel_optics::error::Result;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::observations::{ChannelMeasurement, Measurement, Observation, ObservationSet};
use seidel_optics::tile::Tile;

use super::{ChartMeasurement, MeasuredBlock, judgement};
use crate::checks::{self, Concern};
use crate::photograph::Photograph;
use crate::rejection::LeftOut;

/// Photographs of a chart, and the blocks of each.
#[derive(Debug, Clone)]
pub struct ChartSet {
    /// The photographs, after dark and flat frames.
    pub photographs: Vec<Photograph>,
    /// The measurement of each.
    pub measurements: Vec<ChartMeasurement>,
}

impl MeasuredBlock {
    /// Returns the centroid of the tile of `channel` in frame pixels.
    pub fn centroid(&self, channel: usize) -> [f64; 2] {
        let tile = &self.tiles[channel];
        let side = tile.len().isqrt();
        let [x, y] = super::centroid(tile, side);
        [
            self.centre[0] as f64 + 0.5 + x,
            self.centre[1] as f64 + 0.5 + y,
        ]
    }

    /// Returns the covariance xx, xy, yy of the tile of `channel`, px².
    pub fn covariance(&self, channel: usize) -> [f64; 3] {
        let tile = &self.tiles[channel];
        let side = tile.len().isqrt();
        let [cx, cy] = super::centroid(tile, side);
        let half = (side / 2) as f64;
        let mut sum = [0.0; 3];
        for (k, value) in tile.iter().enumerate() {
            let (x, y) = ((k % side) as f64 - half - cx, (k / side) as f64 - half - cy);
            sum[0] += value * x * x;
            sum[1] += value * x * y;
            sum[2] += value * y * y;
        }
        sum
    }
}

impl ChartSet {
    /// Returns the number of blocks that were kept.
    pub fn kept(&self) -> usize {
        self.measurements.iter().map(|m| m.blocks.len()).sum()
    }

    /// Returns the faults of the photographs.
    pub fn concerns(&self) -> Vec<Concern> {
        let own = self.measurements.iter().flat_map(|m| m.concerns.clone());
        own.chain(judgement::of_pairs(&self.photographs, &self.measurements))
            .collect()
    }

    /// Returns the blocks that were left out.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let of = |(photograph, m): (usize, &ChartMeasurement)| {
            let blocks = m.left_out.iter().map(move |b| LeftOut {
                photograph,
                number: None,
                x: b.at[0],
                y: b.at[1],
                why: b.why,
                value: b.value,
                limit: b.limit,
            });
            blocks.collect::<Vec<_>>()
        };
        self.measurements.iter().enumerate().flat_map(of).collect()
    }

    /// Returns the observation set, whose files are named in order, for a frame whose axis is `axis`.
    ///
    /// # Errors
    /// An axis that is not finite.
    pub fn observations(&self, axis: Option<ImagePoint>) -> Result<ObservationSet> {
        let first = &self.photographs[0];
        let size = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
        let frame = Frame::new(size(first.width), size(first.height), axis)?;
        let added = checks::added_error(&self.concerns());
        let mut observations = Vec::new();
        for (photo, measurement) in self.photographs.iter().zip(&self.measurements) {
            for block in &measurement.blocks {
                observations.push(observation(photo, block, observations.len(), added)?);
            }
        }
        Ok(ObservationSet {
            axis_stated: axis.is_some(),
            ..ObservationSet::new(frame, first.channels.clone(), observations)
        })
    }
}

/// Returns the observation of `block`, whose error grows by `added` of the peak of its tile.
fn observation(
    photo: &Photograph,
    block: &MeasuredBlock,
    index: usize,
    added: f64,
) -> Result<Observation> {
    let sigma_of = |channel: usize| {
        let peak = block.tiles[channel].iter().copied().fold(0.0, f64::max);
        block.sigma[channel].hypot(added * peak)
    };
    let tiles = (block.tiles.iter())
        .map(|tile| {
            let side = tile.len().isqrt();
            Tile::new(side, side, tile.iter().map(|v| *v as f32).collect())
        })
        .collect::<Result<_>>()?;
    let centre = ImagePoint::new(block.centre[0] as f64 + 0.5, block.centre[1] as f64 + 0.5);
    let channels = (0..block.tiles.len())
        .map(|channel| {
            let [x, y] = block.centroid(channel);
            let [xx, _, yy] = block.covariance(channel);
            let sigma = sigma_of(channel);
            // Independent noise of all samples within the tile.
            let side = block.tiles[channel].len() as f64;
            Some(ChannelMeasurement {
                centroid: ImagePoint::new(x, y),
                centroid_sigma_px: sigma * side.sqrt() * ((xx + yy) / 2.0).sqrt(),
                flux: 1.0,
                snr: 1.0 / (sigma * side.sqrt()).max(f64::MIN_POSITIVE),
            })
        })
        .collect();
    Ok(Observation {
        noise_sigma: (0..block.tiles.len()).map(|c| Some(sigma_of(c))).collect(),
        measurement: Some(Measurement {
            source: photo.name.clone(),
            channels,
        }),
        ..Observation::new(format!("psf/{index:04}.tif"), centre, photo.distance, tiles)
    })
}

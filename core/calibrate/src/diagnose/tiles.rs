//! Observed tiles prepared for a diagnosis: unit sum, noise, and the lens's local pupil.

use std::sync::Arc;

use super::pair::TileResponse;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::ScenePoint;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::LocalPupil;
use seidel_optics::moments::support::{self, Support};
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{LensProfile, PupilChannel};

/// Number of cross-validation folds over the field.
pub(super) const FOLDS: usize = 4;

/// Rings and sectors of the field; a fold consists of zones that do not touch.
const RINGS: usize = 3;
const SECTORS: usize = 8;

/// One observed tile in one channel.
#[derive(Debug, Clone)]
pub(super) struct TileData {
    pub(super) observation: usize,
    /// Index of the channel in the lens.
    pub(super) of_lens: usize,
    pub(super) distance: ObjectDistance,
    pub(super) centre: ImagePoint,
    /// Scene point, for effects.
    pub(super) point: ScenePoint,
    /// Local pupil of the given lens.
    pub(super) pupil: LocalPupil,
    pub(super) size: (usize, usize),
    /// Top-left outer corner of the tile relative to the given lens's chief ray, px. Without an ideal
    /// position it is relative to the observed centroid, and predictions are aligned by centroid.
    pub(super) corner: (f64, f64),
    /// Whether the ideal position is known.
    pub(super) has_ideal: bool,
    /// Samples with unit sum over the valid pixels.
    pub(super) light: Vec<f64>,
    /// Valid pixels; all if empty.
    pub(super) counts: Vec<bool>,
    /// Squared norm of `light`.
    pub(super) norm: f64,
    /// Expected contribution of noise to the gap.
    pub(super) noise: f64,
    /// Standard deviation of pixel noise in units of `light`.
    pub(super) sigma: f64,
    /// Sum of the stored samples without background.
    pub(super) exposure: f64,
    /// Index of the cross-validation fold.
    pub(super) fold: usize,
    /// Response of the estimator, where the tile was estimated from pictures.
    pub(super) response: Option<Arc<TileResponse>>,
}

impl TileData {
    /// Returns the effective number of independent samples in the noise of the tile.
    pub(super) fn noise_freedom(&self) -> f64 {
        match &self.response {
            Some(response) => response.noise_freedom(),
            None => self.light.len() as f64,
        }
    }
}

/// All tiles of a set that can be compared with a lens, with remarks on excluded ones.
#[derive(Debug)]
pub(super) struct TileSet {
    pub(super) tiles: Vec<TileData>,
    pub(super) remarks: Vec<String>,
}

impl TileSet {
    /// Prepares the tiles of `set` for `lens`. `responses` are those of an estimator, by observation and channel; none for
    /// measured tiles.
    pub(super) fn new(
        lens: &LensProfile,
        channels: &[PupilChannel],
        set: &ObservationSet,
        responses: &[Vec<TileResponse>],
    ) -> Result<Self> {
        let (frame, predictor) = (lens.frame, Predictor::new(lens)?);
        let names = set.channels.iter();
        let of_lens: Vec<usize> = names
            .map(|name| predictor.channel_index(name))
            .collect::<Result<_>>()?;
        set.check_frame(frame)?;
        let places: Vec<FieldPoint> = set
            .observations
            .iter()
            .map(|o| frame.field_point(o.ideal.unwrap_or(o.centre)))
            .collect();
        let folds = folds(&places);
        let mut tally = Tally::default();
        let mut tiles = Vec::new();
        for (index, observation) in set.observations.iter().enumerate() {
            let vergence = predictor
                .vergence(observation.distance)
                .map_err(|e| e.within(&format!("observation {index} ({})", observation.file)))?;
            for (channel, &of_lens) in of_lens.iter().enumerate() {
                let lens_channel = &channels[of_lens];
                let tile = prepare_tile(
                    observation,
                    channel,
                    lens_channel,
                    frame,
                    vergence,
                    &mut tally,
                );
                if let Some(tile) = tile {
                    tiles.push(TileData {
                        observation: index,
                        of_lens,
                        fold: folds[index],
                        response: response(responses, index, channel),
                        ..tile
                    });
                }
            }
        }
        if tiles.len() < MIN_TILES {
            return Err(Error::new(
                "observations",
                format!("hold {} usable tiles", tiles.len()),
                format!("give at least {MIN_TILES}, spread over the frame"),
            ));
        }
        Ok(Self {
            tiles,
            remarks: tally.remarks(),
        })
    }
}

/// Returns the response of the estimator of a tile.
fn response(
    responses: &[Vec<TileResponse>],
    observation: usize,
    channel: usize,
) -> Option<Arc<TileResponse>> {
    let own = responses.get(observation)?.get(channel)?;
    Some(Arc::new(own.clone()))
}

/// Minimum number of tiles for a diagnosis.
const MIN_TILES: usize = 6;

#[derive(Default)]
struct Tally {
    dark: usize,
    clipped: usize,
    estimated: usize,
    without_ideal: usize,
}

impl Tally {
    fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut say = |count: usize, text: &str| {
            if count > 0 {
                remarks.push(format!("{count} {text}"));
            }
        };
        say(self.dark, "tiles hold no light and were left out");
        say(
            self.clipped,
            "tiles are saturated: their clipped pixels were left out",
        );
        say(
            self.estimated,
            "tiles have no noise_sigma: their noise was estimated at their rims",
        );
        say(
            self.without_ideal,
            "tiles have no ideal position: effects that only move PSFs cannot be seen in them",
        );
        remarks
    }
}

fn prepare_tile(
    observation: &Observation,
    channel: usize,
    lens: &PupilChannel,
    frame: Frame,
    vergence: f64,
    tally: &mut Tally,
) -> Option<TileData> {
    let light = observation.light(channel);
    let size = (light.width(), light.height());
    let mut samples: Vec<f64> = light.samples().iter().map(|v| f64::from(*v)).collect();
    let counts = if observation.saturated {
        tally.clipped += 1;
        let peak = samples.iter().copied().fold(f64::MIN, f64::max);
        samples.iter().map(|v| *v < CLIPPED * peak).collect()
    } else {
        Vec::new()
    };
    for (index, value) in samples.iter_mut().enumerate() {
        if counts.get(index) == Some(&false) {
            *value = 0.0;
        }
    }
    let exposure: f64 = samples.iter().sum();
    if exposure <= 0.0 || !exposure.is_finite() {
        tally.dark += 1;
        return None;
    }
    let stated = observation.noise_sigma[channel];
    let sigma = stated.unwrap_or_else(|| {
        tally.estimated += 1;
        light.rim_noise()
    }) / exposure;
    samples.iter_mut().for_each(|v| *v /= exposure);
    let norm: f64 = samples.iter().map(|v| v * v).sum();
    let used = samples.len() - counts.iter().filter(|c| !**c).count();
    let (at, corner, has_ideal) = if let Some(ideal) = observation.ideal {
        let at = frame.field_point(ideal);
        let (dx, dy) = lens.displacement_at(at, vergence, frame.half_width_px());
        let of_rays = lens.pupil_at(at, vergence).centroid();
        // Chief ray: predicted centroid less the centroid of the ray bundle.
        let chief = (ideal.x_px + dx - of_rays[0], ideal.y_px + dy - of_rays[1]);
        let (x, y) = observation.tile_point(ImagePoint::new(chief.0, chief.1));
        (at, (-x, -y), true)
    } else {
        tally.without_ideal += 1;
        let noise = Some(sigma * exposure).filter(|s| *s > 0.0);
        let (m, _) = support::moments(&light, noise, Support::Auto)?;
        let centroid = observation.frame_point(m.centroid_x, m.centroid_y);
        (
            frame.field_point(centroid),
            (-m.centroid_x, -m.centroid_y),
            false,
        )
    };
    Some(TileData {
        observation: 0,
        of_lens: 0,
        distance: observation.distance,
        centre: observation.centre,
        point: lens.scene_point(at, vergence),
        pupil: lens.pupil_at(at, vergence),
        size,
        corner,
        has_ideal,
        norm,
        noise: used as f64 * sigma * sigma / norm,
        sigma,
        light: samples,
        counts,
        exposure,
        fold: 0,
        response: None,
    })
}

/// Share of the peak from which on pixels of a saturated tile count as clipped.
const CLIPPED: f64 = 0.97;

/// Returns the fold of every place. Zones are rings of equal count times sectors, assigned so that no two
/// neighbours share a fold.
fn folds(places: &[FieldPoint]) -> Vec<usize> {
    let mut radii: Vec<f64> = places.iter().map(|p| p.radius()).collect();
    radii.sort_by(f64::total_cmp);
    places
        .iter()
        .map(|place| {
            let below = radii.partition_point(|r| *r < place.radius());
            let ring = (below * RINGS / radii.len().max(1)).min(RINGS - 1);
            let turn = place.y.atan2(place.x) / std::f64::consts::TAU + 0.5;
            let sector = ((turn * SECTORS as f64) as usize).min(SECTORS - 1);
            (sector + 2 * ring) % FOLDS
        })
        .collect()
}

//! Observed tiles prepared for a diagnosis: unit sum, noise, and the lens's local pupil.

use std::sync::Arc;

use super::coverage::{Coverage, distinct_folds};
use super::pair::TileResponse;
use super::registration::{ReferencePupil, Registration};
use super::tile_noise::TileNoise;
use crate::reference_channel::reference_channel;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::ScenePoint;
use seidel_optics::error::Result;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::{LocalPupil, VergenceSeries};
use seidel_optics::moments::support::{Support, TilePixels};
use seidel_optics::numeric::dot;
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
    /// Top-left outer corner of the tile relative to the given lens's chief ray, px. If the tile is placed by its own
    /// centroid, it is relative to that.
    pub(super) corner: (f64, f64),
    pub(super) registration: Registration,
    /// Observed centroid relative to the given lens's chief ray, px, if the registration shows its place.
    pub(super) centroid: Option<[f64; 2]>,
    /// Samples with unit sum over the valid pixels, zero at the others.
    pub(super) light: Vec<f64>,
    /// Valid pixels: those of the channel's colour in a mosaic, neither clipped nor masked; all if empty.
    pub(super) counts: Vec<bool>,
    /// Squared norm of `light` without noise.
    pub(super) norm: f64,
    /// Expected contribution of noise to the gap.
    pub(super) noise: f64,
    /// Standard deviation of pixel noise in units of `light`.
    pub(super) sigma: f64,
    /// Sum of the stored samples without background.
    pub(super) exposure: f64,
    /// Index of the cross-validation fold.
    pub(super) fold: usize,
    /// Share of the flux error that is removed from residuals, 0 to 1: where noise makes the sum of the tile uncertain, its
    /// flux is fitted to the prediction.
    pub(super) free_flux: f64,
    /// Part of `noise` by the error of the sum of the tile.
    pub(super) noise_of_sum: f64,
    /// Response of the estimator, where the tile was estimated from pictures.
    pub(super) response: Option<Arc<TileResponse>>,
}

impl TileData {
    /// Returns the effective number of independent samples in the noise of the tile.
    pub(super) fn noise_freedom(&self) -> f64 {
        match &self.response {
            Some(response) => response.noise_freedom(),
            None => self.valid_pixels() as f64,
        }
    }

    /// Returns the number of valid pixels.
    pub(super) fn valid_pixels(&self) -> usize {
        self.light.len() - self.counts.iter().filter(|c| !**c).count()
    }

    /// Sets the pixels that are not valid to zero.
    pub(super) fn mask(&self, pixels: &mut [f64]) {
        for (pixel, counts) in pixels.iter_mut().zip(&self.counts) {
            if !counts {
                *pixel = 0.0;
            }
        }
    }

    /// Sets the response of the estimator. Its errors do not change the sum of the tile.
    fn set_response(&mut self, response: Arc<TileResponse>) {
        self.response = Some(response);
        self.free_flux = 0.0;
        self.noise_of_sum = 0.0;
        self.norm = self.light.iter().map(|v| v * v).sum();
        self.noise = self.light.len() as f64 * self.sigma * self.sigma / self.norm;
    }

    /// Returns observed minus `predicted` at valid pixels, without the free part of the flux error; zero at the others.
    pub(super) fn residual(&self, predicted: &[f64]) -> Vec<f64> {
        let pixels = self.light.iter().zip(predicted);
        let mut residual: Vec<f64> = pixels.map(|(o, p)| o - p).collect();
        self.mask(&mut residual);
        self.remove_flux(&mut residual, predicted);
        residual
    }

    /// Removes the free part of the component along `predicted` from `values`, which are zero where pixels are not valid.
    pub(super) fn remove_flux(&self, values: &mut [f64], predicted: &[f64]) {
        if self.free_flux == 0.0 {
            return;
        }
        let mut predicted = predicted.to_vec();
        self.mask(&mut predicted);
        let share =
            self.free_flux * dot(values, &predicted) / dot(&predicted, &predicted).max(1e-300);
        for (value, p) in values.iter_mut().zip(&predicted) {
            *value -= share * p;
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
        let folds = distinct_folds(folds(&places));
        let mut tally = Tally::default();
        let mut tiles = Vec::new();
        let comparison = LensComparison::new(lens, channels);
        for (index, observation) in set.observations.iter().enumerate() {
            let vergence = predictor
                .vergence(observation.distance)
                .map_err(|e| e.within(&format!("observation {index} ({})", observation.file)))?;
            let pixels = ObservedPixels { set, observation };
            let place = comparison.place(&pixels, &of_lens, vergence);
            for (channel, &of_lens) in of_lens.iter().enumerate() {
                let tile = comparison.tile(&pixels, channel, of_lens, vergence, &place, &mut tally);
                if let Some(mut tile) = tile {
                    if let Some(response) = response(responses, index, channel) {
                        tile.set_response(response);
                    }
                    tiles.push(TileData {
                        observation: index,
                        fold: folds[index],
                        ..tile
                    });
                }
            }
        }
        Coverage::of(&tiles).check()?;
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

/// The tiles of an observation with what its set says of their pixels.
struct ObservedPixels<'a> {
    set: &'a ObservationSet,
    observation: &'a Observation,
}

impl ObservedPixels<'_> {
    /// Returns the centroid in channel `channel`, px from the tile's corner: that of the measurement, or of the pixels. `None`
    /// without light.
    fn centroid(&self, channel: usize) -> Option<[f64; 2]> {
        let measured = self.observation.measurement.as_ref();
        if let Some(measured) = measured.and_then(|m| m.channels.get(channel)?.as_ref()) {
            let (x, y) = self.observation.tile_point(measured.centroid);
            return Some([x, y]);
        }
        let counted = self.set.counted(self.observation, channel);
        let pixels = TilePixels {
            tile: &self.observation.light(channel),
            counted: counted.as_deref(),
            noise_sigma: self.observation.noise_sigma[channel].filter(|s| *s > 0.0),
        };
        let (m, _) = pixels.moments(Support::Auto)?;
        Some([m.centroid_x, m.centroid_y])
    }
}

#[derive(Default)]
struct Tally {
    dark: usize,
    clipped: usize,
    estimated: usize,
    by_reference: usize,
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
            self.by_reference,
            "tiles have no ideal position: of effects that move PSFs, only differences between channels can be seen in them",
        );
        say(
            self.without_ideal,
            "tiles have no ideal position: effects that only move PSFs cannot be seen in them",
        );
        remarks
    }
}

/// The place of an observation in the image.
enum Place {
    /// The stated or estimated ideal image point.
    Known {
        ideal: ImagePoint,
        registration: Registration,
    },
    /// Unknown: every tile is placed by its own centroid.
    Unknown,
}

/// The lens that observations are compared with.
struct LensComparison<'a> {
    channels: &'a [PupilChannel],
    frame: Frame,
    /// Index of the reference channel, if the lens knows the displacement between channels.
    reference: Option<usize>,
}

impl<'a> LensComparison<'a> {
    fn new(lens: &LensProfile, channels: &'a [PupilChannel]) -> Self {
        let names = channels.iter().map(|c| c.name.as_str());
        let reference = reference_channel(&lens.camera, names);
        Self {
            channels,
            frame: lens.frame,
            reference: (channels.len() > 1 && knows_displacement(lens, channels))
                .then_some(reference),
        }
    }

    /// Returns the displacement of the centroid of channel `of_lens`, px.
    fn displacement(&self, of_lens: usize, at: FieldPoint, vergence: f64) -> (f64, f64) {
        self.channels[of_lens].displacement_at(at, vergence, self.frame.half_width_px())
    }

    /// Returns the place of `observation`, whose channels are those `of_lens`.
    fn place(&self, pixels: &ObservedPixels, of_lens: &[usize], vergence: f64) -> Place {
        let observation = pixels.observation;
        if let Some(ideal) = observation.ideal {
            return Place::Known {
                ideal,
                registration: Registration::Ideal,
            };
        }
        let reference = self.reference.and_then(|reference| {
            let channel = of_lens.iter().position(|c| *c == reference)?;
            let [x, y] = pixels.centroid(channel)?;
            let centroid = observation.frame_point(x, y);
            let (dx, dy) = self.displacement(reference, self.frame.field_point(centroid), vergence);
            let ideal = ImagePoint::new(centroid.x_px - dx, centroid.y_px - dy);
            let at = self.frame.field_point(ideal);
            let pupil = self.channels[reference].pupil_at(at, vergence);
            Some(Place::Known {
                ideal,
                registration: Registration::Reference(Box::new(ReferencePupil {
                    point: self.channels[reference].scene_point(at, vergence),
                    centroid: pupil.centroid(),
                    pupil,
                })),
            })
        });
        reference.unwrap_or(Place::Unknown)
    }

    /// Returns the tile of `channel` of an observation, the channel `of_lens` of the lens; `None` without light.
    fn tile(
        &self,
        pixels: &ObservedPixels,
        channel: usize,
        of_lens: usize,
        vergence: f64,
        place: &Place,
        tally: &mut Tally,
    ) -> Option<TileData> {
        let lens = &self.channels[of_lens];
        let observation = pixels.observation;
        let light = observation.light(channel);
        let size = (light.width(), light.height());
        let mut samples: Vec<f64> = light.samples().iter().map(|v| f64::from(*v)).collect();
        let mut counts = pixels.set.counted(observation, channel).unwrap_or_default();
        if observation.saturated {
            tally.clipped += 1;
            let peak = samples.iter().copied().fold(f64::MIN, f64::max);
            counts.resize(samples.len(), true);
            for (counts, value) in counts.iter_mut().zip(&samples) {
                *counts &= *value < CLIPPED * peak;
            }
        }
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
        let noise_sigma = stated.unwrap_or_else(|| {
            tally.estimated += 1;
            light.rim_noise()
        });
        samples.iter_mut().for_each(|v| *v /= exposure);
        let norm: f64 = samples.iter().map(|v| v * v).sum();
        let used = samples.len() - counts.iter().filter(|c| !**c).count();
        // Photon noise is spread evenly over the tile: the sum of its variance is that of all its light.
        let photons = observation.gain.unwrap_or(0.0) * exposure / used.max(1) as f64;
        let sigma = noise_sigma.hypot(photons.sqrt()) / exposure;
        let noise = if pixels.set.mosaic.is_some() {
            // The sum over the few pixels of a colour depends on where the light lies, and on the background.
            TileNoise::with_free_flux(norm, used as f64, sigma, 1.0)
        } else {
            TileNoise::new(norm, used as f64, sigma)
        };
        let measured = || pixels.centroid(channel);
        let (at, corner, registration, centroid) = match place {
            Place::Known {
                ideal,
                registration,
            } => {
                let at = self.frame.field_point(*ideal);
                let (dx, dy) = self.displacement(of_lens, at, vergence);
                let of_rays = lens.pupil_at(at, vergence).centroid();
                // Chief ray: predicted centroid less the centroid of the ray bundle.
                let chief = (ideal.x_px + dx - of_rays[0], ideal.y_px + dy - of_rays[1]);
                let (x, y) = observation.tile_point(ImagePoint::new(chief.0, chief.1));
                match registration {
                    Registration::Ideal => {}
                    _ => tally.by_reference += 1,
                }
                let centroid = measured().map(|[cx, cy]| [cx - x, cy - y]);
                (at, (-x, -y), registration.clone(), centroid)
            }
            Place::Unknown => {
                tally.without_ideal += 1;
                let [x, y] = measured()?;
                let at = self.frame.field_point(observation.frame_point(x, y));
                (at, (-x, -y), Registration::Centroid, None)
            }
        };
        Some(TileData {
            observation: 0,
            of_lens,
            distance: observation.distance,
            centre: observation.centre,
            point: lens.scene_point(at, vergence),
            pupil: lens.pupil_at(at, vergence),
            size,
            corner,
            registration,
            centroid,
            norm: noise.norm,
            noise: noise.noise,
            sigma,
            light: samples,
            counts,
            exposure,
            fold: 0,
            free_flux: noise.free_flux,
            noise_of_sum: noise.of_sum,
            response: None,
        })
    }
}

/// Returns whether `lens` states the displacement between its channels: it was designed, or fitted to sets that show it.
fn knows_displacement(lens: &LensProfile, channels: &[PupilChannel]) -> bool {
    let is_zero = |series: &VergenceSeries| {
        series.coefficients.iter().all(|c| *c == 0.0) && series.remainders.is_empty()
    };
    let fitted = lens.held_out.is_some() || lens.provenance.held_nothing_out();
    let shifted = (channels.iter()).any(|c| !is_zero(&c.magnification) || !is_zero(&c.distortion));
    shifted || !fitted
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

//! Observed tiles made ready: unit sums, noise, and what the lens as given says about their points.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::ScenePoint;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::LocalPupil;
use seidel_optics::moments::support::{self, Support};
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{LensProfile, PupilChannel};

/// Folds of the field: each is scored by fits to the others.
pub(super) const FOLDS: usize = 4;

/// Rings and sectors of the field; a fold is made of zones that do not touch.
const RINGS: usize = 3;
const SECTORS: usize = 8;

/// One tile in one channel.
#[derive(Debug, Clone)]
pub(super) struct Seen {
    pub(super) observation: usize,
    /// Channel of the lens.
    pub(super) of_lens: usize,
    pub(super) distance: ObjectDistance,
    pub(super) centre: ImagePoint,
    /// Where the point is, for effects.
    pub(super) point: ScenePoint,
    /// What the lens as given does there.
    pub(super) pupil: LocalPupil,
    pub(super) size: (usize, usize),
    /// Top-left outer corner of the tile from the chief ray of the lens as given, px. Where the ideal
    /// position is not known: from the observed centroid, and the prediction's own is laid on it.
    pub(super) corner: (f64, f64),
    pub(super) placed: bool,
    /// Unit sum over the pixels that count.
    pub(super) light: Vec<f64>,
    /// Which pixels count; all if empty.
    pub(super) counts: Vec<bool>,
    /// Squared norm of `light`.
    pub(super) norm: f64,
    /// What noise alone adds to the gap.
    pub(super) noise: f64,
    /// Standard deviation of a pixel's noise in units of `light`.
    pub(super) sigma: f64,
    /// Sum of the tile as stored, background taken off.
    pub(super) exposure: f64,
    /// Which fold of the field it lies in.
    pub(super) fold: usize,
}

/// All tiles of a set that can be compared with a lens, and what had to be left out.
#[derive(Debug)]
pub(super) struct SeenSet {
    pub(super) tiles: Vec<Seen>,
    pub(super) remarks: Vec<String>,
}

impl SeenSet {
    /// Reads `set` against `lens`.
    pub(super) fn new(
        lens: &LensProfile,
        channels: &[PupilChannel],
        set: &ObservationSet,
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
        let mut counts = Counts::default();
        let mut tiles = Vec::new();
        for (index, observation) in set.observations.iter().enumerate() {
            let vergence = predictor
                .vergence(observation.distance)
                .map_err(|e| e.within(&format!("observation {index} ({})", observation.file)))?;
            for (channel, &of_lens) in of_lens.iter().enumerate() {
                let lens_channel = &channels[of_lens];
                let tile = seen(
                    observation,
                    channel,
                    lens_channel,
                    frame,
                    vergence,
                    &mut counts,
                );
                if let Some(tile) = tile {
                    tiles.push(Seen {
                        observation: index,
                        of_lens,
                        fold: folds[index],
                        ..tile
                    });
                }
            }
        }
        if tiles.len() < LEAST_TILES {
            return Err(Error::new(
                "observations",
                format!("hold {} usable tiles", tiles.len()),
                format!("give at least {LEAST_TILES}, spread over the frame"),
            ));
        }
        Ok(Self {
            tiles,
            remarks: counts.remarks(),
        })
    }
}

/// Fewest tiles that say anything of a cause.
const LEAST_TILES: usize = 6;

#[derive(Default)]
struct Counts {
    dark: usize,
    clipped: usize,
    estimated: usize,
    unplaced: usize,
}

impl Counts {
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
            self.unplaced,
            "tiles have no ideal position: effects that only move PSFs cannot be seen in them",
        );
        remarks
    }
}

fn seen(
    observation: &Observation,
    channel: usize,
    lens: &PupilChannel,
    frame: Frame,
    vergence: f64,
    told: &mut Counts,
) -> Option<Seen> {
    let light = observation.light(channel);
    let size = (light.width(), light.height());
    let mut samples: Vec<f64> = light.samples().iter().map(|v| f64::from(*v)).collect();
    let counts = if observation.saturated {
        told.clipped += 1;
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
        told.dark += 1;
        return None;
    }
    let stated = observation.noise_sigma[channel];
    let sigma = stated.unwrap_or_else(|| {
        told.estimated += 1;
        rim_noise(&samples, size)
    }) / exposure;
    samples.iter_mut().for_each(|v| *v /= exposure);
    let norm: f64 = samples.iter().map(|v| v * v).sum();
    let used = samples.len() - counts.iter().filter(|c| !**c).count();
    let (at, corner, placed) = if let Some(ideal) = observation.ideal {
        let at = frame.field_point(ideal);
        let (dx, dy) = lens.displacement_at(at, vergence, frame.half_width_px());
        let of_rays = lens.pupil_at(at, vergence).centroid();
        // The chief ray lies where the centroid does, less what the rays are off it.
        let chief = (ideal.x_px + dx - of_rays[0], ideal.y_px + dy - of_rays[1]);
        let (x, y) = observation.tile_point(ImagePoint::new(chief.0, chief.1));
        (at, (-x, -y), true)
    } else {
        told.unplaced += 1;
        let noise = Some(sigma * exposure).filter(|s| *s > 0.0);
        let (m, _) = support::moments(&light, noise, Support::Auto)?;
        let centroid = observation.frame_point(m.centroid_x, m.centroid_y);
        (
            frame.field_point(centroid),
            (-m.centroid_x, -m.centroid_y),
            false,
        )
    };
    Some(Seen {
        observation: 0,
        of_lens: 0,
        distance: observation.distance,
        centre: observation.centre,
        point: lens.scene_point(at, vergence),
        pupil: lens.pupil_at(at, vergence),
        size,
        corner,
        placed,
        norm,
        noise: used as f64 * sigma * sigma / norm,
        sigma,
        light: samples,
        counts,
        exposure,
        fold: 0,
    })
}

/// Pixels of a saturated tile from this share of its peak on are taken as clipped.
const CLIPPED: f64 = 0.97;

/// Standard deviation of a pixel's noise from differences between neighbours along the tile's rim, where
/// there is least light; robust against what light there is.
fn rim_noise(samples: &[f64], (width, height): (usize, usize)) -> f64 {
    let mut differences = Vec::new();
    for ring in 0..3.min(width.min(height) / 2) {
        for row in [ring, height - 1 - ring] {
            for column in 0..width - 1 {
                let index = row * width + column;
                differences.push((samples[index + 1] - samples[index]).abs());
            }
        }
        for column in [ring, width - 1 - ring] {
            for row in 0..height - 1 {
                let index = row * width + column;
                differences.push((samples[index + width] - samples[index]).abs());
            }
        }
    }
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    // Of a normal distribution the median of |x| is 0.6745; a difference has twice the variance.
    *median / (0.674_49 * std::f64::consts::SQRT_2)
}

/// The fold of every place: rings of equal count and sectors about the axis, dealt out so that no two
/// neighbouring zones fall into one fold.
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

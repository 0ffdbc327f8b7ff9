//! Observation sets: measured or simulated PSFs at known positions of a frame.

use std::collections::HashSet;

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, Fault, Result};
use crate::field::{Frame, ImagePoint};
use crate::mosaic::Mosaic;
use crate::tile::Tile;

/// Largest coordinate of an observation, px. Powers of larger ones overflow.
const MAX_POSITION_PX: f64 = 1e7;

/// An observed point of light: one tile a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// The tile's file as the manifest names it. Used as a label only.
    pub file: String,
    /// Frame position of the tile's centre, which is the tile coordinate (width / 2, height / 2).
    pub centre: ImagePoint,
    /// Distance of the object.
    pub distance: ObjectDistance,
    /// Image position of the point through an undistorted lens, if known.
    pub ideal: Option<ImagePoint>,
    /// One tile a channel, in the channel order of the set, all of one size.
    pub tiles: Vec<Tile>,
    /// Standard deviation of the pixel noise by channel, in the tile's units, if known.
    pub noise_sigma: Vec<Option<f64>>,
    /// Constant background by channel, not yet subtracted from the tile; zero if none was given.
    pub background: Vec<f64>,
    /// True if a pixel of the tile is saturated.
    pub saturated: bool,
    /// Counts per photo-electron, if known. The noise variance of a pixel is then `noise_sigma`² + `gain` x signal.
    pub gain: Option<f64>,
    /// Pixels to use (true) and to leave out (false), row-major; all are used if `None`.
    pub weight_mask: Option<Vec<bool>>,
    /// Figures of the measurement, if the tile was cut from a photograph.
    pub measurement: Option<Measurement>,
}

/// Figures of the measurement of a light in a photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// File of the photograph.
    pub source: String,
    /// One entry a channel, in the channel order of the set; `None` where the light is too faint in the channel.
    pub channels: Vec<Option<ChannelMeasurement>>,
}

/// Figures of the measurement of a light in one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelMeasurement {
    /// Frame position of the centroid.
    pub centroid: ImagePoint,
    /// Standard deviation of the centroid along x and along y, px.
    pub centroid_sigma_px: f64,
    /// Total light, counts.
    pub flux: f64,
    /// Flux over its standard deviation.
    pub snr: f64,
}

impl Observation {
    /// Creates an observation of `tiles`, one a channel, about frame position `centre`, of an object at `distance`.
    ///
    /// `file` is a label. The ideal position and the noise are unknown, the background is zero and no pixel is saturated.
    pub fn new(
        file: impl Into<String>,
        centre: ImagePoint,
        distance: ObjectDistance,
        tiles: Vec<Tile>,
    ) -> Self {
        Self {
            file: file.into(),
            centre,
            distance,
            ideal: None,
            noise_sigma: vec![None; tiles.len()],
            background: vec![0.0; tiles.len()],
            tiles,
            saturated: false,
            gain: None,
            weight_mask: None,
            measurement: None,
        }
    }

    /// Returns the frame column and row of the tile's top-left pixel; `None` if the tile's pixels are not those of the
    /// frame's grid.
    pub fn frame_corner(&self) -> Option<(usize, usize)> {
        let corner = self.frame_point(0.0, 0.0);
        let whole = |v: f64| (v >= 0.0 && v.fract() == 0.0 && v < 1e9).then_some(v as usize);
        Some((whole(corner.x_px)?, whole(corner.y_px)?))
    }

    /// Returns the tile of `channel` with its background subtracted.
    pub fn light(&self, channel: usize) -> Tile {
        let tile = &self.tiles[channel];
        match self.background[channel] {
            0.0 => tile.clone(),
            constant => tile.minus_background(constant),
        }
    }

    /// Converts tile coordinates to a frame position.
    pub fn frame_point(&self, tile_x: f64, tile_y: f64) -> ImagePoint {
        let tile = &self.tiles[0];
        ImagePoint::new(
            self.centre.x_px - tile.width() as f64 / 2.0 + tile_x,
            self.centre.y_px - tile.height() as f64 / 2.0 + tile_y,
        )
    }

    /// Converts a frame position to tile coordinates (x, y); the inverse of [`Observation::frame_point`].
    pub fn tile_point(&self, at: ImagePoint) -> (f64, f64) {
        let tile = &self.tiles[0];
        (
            at.x_px - self.centre.x_px + tile.width() as f64 / 2.0,
            at.y_px - self.centre.y_px + tile.height() as f64 / 2.0,
        )
    }
}

/// A set of PSFs observed with one camera at one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservationSet {
    /// The full frame and its optical axis.
    pub frame: Frame,
    /// True if the manifest states the axis; otherwise the centre of the frame is assumed.
    pub axis_stated: bool,
    /// Sensor pixel pitch, micrometres, if known.
    pub pixel_pitch_um: Option<f64>,
    /// Channel names, in the order of the tiles of every observation.
    pub channels: Vec<String>,
    /// Known settings of the camera.
    pub camera: Camera,
    /// The colour filter mosaic, if tiles are raw pixels of a sensor. All channels of an observation then have the same
    /// tile, and the pixels of a channel are those of its colour ([`ObservationSet::counted`]).
    pub mosaic: Option<Mosaic>,
    /// The observations.
    pub observations: Vec<Observation>,
}

impl ObservationSet {
    /// Creates a set of `observations` whose tiles are those of `channels`, of an unknown camera.
    pub fn new(frame: Frame, channels: Vec<String>, observations: Vec<Observation>) -> Self {
        Self {
            frame,
            axis_stated: false,
            pixel_pitch_um: None,
            channels,
            camera: Camera::default(),
            mosaic: None,
            observations,
        }
    }

    /// Returns which pixels of the tile of `channel` count, row-major: those of its colour in the mosaic that the weight
    /// mask does not leave out. `None` if all do.
    pub fn counted(&self, observation: &Observation, channel: usize) -> Option<Vec<bool>> {
        let mask = observation.weight_mask.as_deref();
        let Some(mosaic) = &self.mosaic else {
            return mask.map(<[bool]>::to_vec);
        };
        let tile = &observation.tiles[channel];
        let (left, top) = observation.frame_corner().unwrap_or_default();
        let name = &self.channels[channel];
        let of_channel = |k: usize| {
            mosaic.is_of(name, left + k % tile.width(), top + k / tile.width())
                && mask.is_none_or(|m| m[k])
        };
        Some((0..tile.samples().len()).map(of_channel).collect())
    }

    /// Returns every fault of the set that would fail or mislead a fit; empty if the set is valid.
    pub fn faults(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let set_fault = |field: &str, problem: String, remedy: &str| Fault {
            observation: None,
            file: String::new(),
            field: field.into(),
            problem,
            remedy: remedy.into(),
        };
        if self.channels.is_empty() {
            faults.push(set_fault(
                "channels",
                "is empty".into(),
                "name at least one channel, such as Y",
            ));
        }
        for (index, name) in self.channels.iter().enumerate() {
            if self.channels[..index].contains(name) {
                faults.push(set_fault(
                    "channels",
                    format!("names `{name}` twice"),
                    "name every channel once",
                ));
            }
        }
        if self.observations.is_empty() {
            faults.push(set_fault(
                "observations",
                "is empty".into(),
                "list at least one tile",
            ));
        }
        if let Some(pitch) = self.pixel_pitch_um
            && !(pitch.is_finite() && pitch > 0.0)
        {
            faults.push(set_fault(
                "pixel_pitch_um",
                format!("is {pitch}"),
                "give a positive number of micrometres, or leave it out",
            ));
        }
        if let Some(mosaic) = &self.mosaic {
            for name in (self.channels.iter()).filter(|name| mosaic.share_of(name) == 0.0) {
                faults.push(set_fault(
                    "channels",
                    format!("names `{name}`, which the mosaic {mosaic} does not have"),
                    "name colours of the mosaic: R, G or B",
                ));
            }
        }
        let channels: Vec<&str> = self.channels.iter().map(String::as_str).collect();
        if let Err(error) = self.camera.check_wavelengths(&channels) {
            faults.push(set_fault(&error.place, error.problem, &error.remedy));
        }
        let mut earlier = HashSet::new();
        for (index, observation) in self.observations.iter().enumerate() {
            self.check_observation(index, &mut faults);
            if !observation.file.is_empty() && !earlier.insert(observation.identity()) {
                faults.push(Fault {
                    observation: Some(index),
                    file: observation.file.clone(),
                    field: "file".into(),
                    problem: "is listed before with the same position and distance".into(),
                    remedy: "list every observation once; a second one would count twice".into(),
                });
            }
        }
        faults
    }

    /// Returns the distinct object distances of the set: nearest first, then infinity, then unknown.
    pub fn distances(&self) -> Vec<ObjectDistance> {
        let mut all: Vec<ObjectDistance> = Vec::new();
        for observation in &self.observations {
            if !all.contains(&observation.distance) {
                all.push(observation.distance);
            }
        }
        all.sort_by(|a, b| distance_rank(*a).total_cmp(&distance_rank(*b)));
        all
    }

    /// Checks that the set has the frame size of a lens, `frame`.
    ///
    /// # Errors
    /// Rejects a set of another frame size.
    pub fn check_frame(&self, frame: Frame) -> Result<()> {
        let (ours, theirs) = (frame, self.frame);
        if (ours.width_px(), ours.height_px()) == (theirs.width_px(), theirs.height_px()) {
            return Ok(());
        }
        Err(Error::new(
            "image_size",
            format!(
                "is {} x {}, the lens's is {} x {}",
                theirs.width_px(),
                theirs.height_px(),
                ours.width_px(),
                ours.height_px()
            ),
            "use a lens fitted at that frame size",
        ))
    }

    /// Returns the wavelength of the channel called `name` over the pixel pitch, if both are known.
    pub fn wavelength_px(&self, name: &str) -> Option<f64> {
        let nanometres = self.camera.wavelength_nm.get(name)?;
        Some(nanometres * 1e-3 / self.pixel_pitch_um?)
    }

    /// Returns the index of the channel called `name`.
    ///
    /// # Errors
    /// Rejects a name that is not in the set; the message lists those that are.
    pub fn channel_index(&self, name: &str) -> Result<usize> {
        self.channels.iter().position(|c| c == name).ok_or_else(|| {
            Error::new(
                format!("channel `{name}`"),
                "is not in the observation set",
                format!("use one of: {}", self.channels.join(", ")),
            )
        })
    }
}

fn distance_rank(distance: ObjectDistance) -> f64 {
    match distance {
        ObjectDistance::Metres(m) => m,
        ObjectDistance::Infinity => f64::MAX,
        ObjectDistance::Unknown => f64::INFINITY,
    }
}

impl Observation {
    /// Returns what two observations have in common only if they are the same: file, position and distance.
    fn identity(&self) -> (&str, [u64; 3]) {
        let distance = distance_rank(self.distance);
        let numbers = [self.centre.x_px, self.centre.y_px, distance];
        (&self.file, numbers.map(f64::to_bits))
    }
}

impl ObservationSet {
    fn check_observation(&self, index: usize, faults: &mut Vec<Fault>) {
        let (observation, channels) = (&self.observations[index], &self.channels);
        let mut push = |field: String, problem: String, remedy: &str| {
            faults.push(Fault {
                observation: Some(index),
                file: observation.file.clone(),
                field,
                problem,
                remedy: remedy.into(),
            });
        };
        let points = [
            ("x, y", Some(observation.centre)),
            ("ideal_x, ideal_y", observation.ideal),
        ];
        for (field, point) in points {
            if let Some(p) = point
                && !(p.x_px.abs() <= MAX_POSITION_PX && p.y_px.abs() <= MAX_POSITION_PX)
            {
                push(
                    field.into(),
                    format!("is ({}, {})", p.x_px, p.y_px),
                    "give frame pixels, up to 10 million",
                );
            }
        }
        let count = channels.len();
        if observation.tiles.len() != count
            || observation.noise_sigma.len() != count
            || observation.background.len() != count
        {
            push(
                "channels".into(),
                format!("{} tiles for {count} channels", observation.tiles.len()),
                "give one tile a channel",
            );
            return;
        }
        if self.mosaic.is_some() && observation.frame_corner().is_none() {
            push(
                "x, y".into(),
                format!(
                    "is ({}, {}), which does not put the tile's pixels on the frame's grid",
                    observation.centre.x_px, observation.centre.y_px
                ),
                "give the centre of a tile of whole frame pixels, such as 20.5 for an odd width",
            );
            return;
        }
        let pixels = observation.tiles.first().map(|tile| tile.samples().len());
        if let Some(mask) = &observation.weight_mask
            && pixels.is_some_and(|pixels| mask.len() != pixels)
        {
            push(
                "weight_mask".into(),
                format!(
                    "has {} pixels for a tile of {}",
                    mask.len(),
                    pixels.unwrap_or(0)
                ),
                "store the mask at the size of the tile",
            );
            return;
        }
        if let Some(gain) = observation.gain
            && !(gain.is_finite() && gain > 0.0)
        {
            push(
                "gain".into(),
                format!("is {gain}"),
                "give a positive number of counts per electron, or leave it out",
            );
        }
        for (channel, name) in channels.iter().enumerate() {
            let field = format!("channel {name}");
            let tile = &observation.tiles[channel];
            if (tile.width(), tile.height())
                != (observation.tiles[0].width(), observation.tiles[0].height())
            {
                push(
                    field.clone(),
                    "its tile differs in size from the first channel's".into(),
                    "store all channels of an observation at one size",
                );
            }
            let background = observation.background[channel];
            if !background.is_finite() {
                push(
                    "background".into(),
                    format!("is {background}"),
                    "give a finite number",
                );
                continue;
            }
            if let Some(sigma) = observation.noise_sigma[channel]
                && !(sigma.is_finite() && sigma >= 0.0)
            {
                push(
                    "noise_sigma".into(),
                    format!("is {sigma}"),
                    "give a number that is not negative, or leave it out",
                );
                continue;
            }
            let counted = self.counted(observation, channel);
            observation.check_light(channel, counted.as_deref(), &field, &mut push);
        }
    }
}

impl Observation {
    fn check_light(
        &self,
        channel: usize,
        counted: Option<&[bool]>,
        field: &str,
        push: &mut impl FnMut(String, String, &str),
    ) {
        let light = self.light(channel);
        let samples = || {
            let pixels = light.samples().iter().enumerate();
            pixels.filter_map(|(k, v)| counted.is_none_or(|c| c[k]).then_some(*v))
        };
        let peak = samples().fold(f32::MIN, f32::max);
        let lowest = samples().fold(f32::MAX, f32::min);
        let sum: f64 = samples().map(f64::from).sum();
        if peak <= 0.0 || sum <= 0.0 {
            push(
                field.into(),
                format!("holds no light (sum {sum}, peak {peak})"),
                "check the background, or leave the observation out",
            );
            return;
        }
        let noise = self.noise_sigma[channel].unwrap_or_else(|| light.rim_noise());
        let allowed = (NEGATIVE_SIGMAS * noise).max(NEGATIVE_SHARE * f64::from(peak));
        if f64::from(lowest) < -allowed {
            push(
                field.into(),
                format!(
                    "holds {lowest}, which is negative beyond its noise ({allowed:.3e} allowed)"
                ),
                "check background and noise_sigma, or leave the observation out",
            );
        }
    }
}

/// Negative pixels beyond this many standard deviations of the noise are faults. Real skies reach eight: their
/// noise is not quite Gaussian and their background not quite constant.
const NEGATIVE_SIGMAS: f64 = 12.0;
/// Negative pixels beyond this share of the tile's peak are faults, if that is more than [`NEGATIVE_SIGMAS`].
/// Resampling and black levels reach one per cent.
const NEGATIVE_SHARE: f64 = 0.01;

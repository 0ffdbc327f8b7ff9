//! Observation sets: measured or simulated PSFs at known positions of a frame.

use std::collections::HashSet;

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, Fault, Result};
use crate::field::{Frame, ImagePoint};
use crate::tile::Tile;

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
        }
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
            observations,
        }
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
        let channels: Vec<&str> = self.channels.iter().map(String::as_str).collect();
        if let Err(error) = self.camera.check_wavelengths(&channels) {
            faults.push(set_fault(&error.place, error.problem, &error.remedy));
        }
        let mut earlier = HashSet::new();
        for (index, observation) in self.observations.iter().enumerate() {
            observation.check(index, &self.channels, &mut faults);
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

    fn check(&self, index: usize, channels: &[String], faults: &mut Vec<Fault>) {
        let mut push = |field: String, problem: String, remedy: &str| {
            faults.push(Fault {
                observation: Some(index),
                file: self.file.clone(),
                field,
                problem,
                remedy: remedy.into(),
            });
        };
        let points = [
            ("x, y", Some(self.centre)),
            ("ideal_x, ideal_y", self.ideal),
        ];
        for (field, point) in points {
            if let Some(p) = point
                && !(p.x_px.is_finite() && p.y_px.is_finite())
            {
                push(
                    field.into(),
                    format!("is ({}, {})", p.x_px, p.y_px),
                    "give finite frame pixels",
                );
            }
        }
        let count = channels.len();
        if self.tiles.len() != count
            || self.noise_sigma.len() != count
            || self.background.len() != count
        {
            push(
                "channels".into(),
                format!("{} tiles for {count} channels", self.tiles.len()),
                "give one tile a channel",
            );
            return;
        }
        for (channel, name) in channels.iter().enumerate() {
            let field = format!("channel {name}");
            let tile = &self.tiles[channel];
            if (tile.width(), tile.height()) != (self.tiles[0].width(), self.tiles[0].height()) {
                push(
                    field.clone(),
                    "its tile differs in size from the first channel's".into(),
                    "store all channels of an observation at one size",
                );
            }
            let background = self.background[channel];
            if !background.is_finite() {
                push(
                    "background".into(),
                    format!("is {background}"),
                    "give a finite number",
                );
                continue;
            }
            if let Some(sigma) = self.noise_sigma[channel]
                && !(sigma.is_finite() && sigma >= 0.0)
            {
                push(
                    "noise_sigma".into(),
                    format!("is {sigma}"),
                    "give a number that is not negative, or leave it out",
                );
                continue;
            }
            self.check_light(channel, &field, &mut push);
        }
    }

    fn check_light(
        &self,
        channel: usize,
        field: &str,
        push: &mut impl FnMut(String, String, &str),
    ) {
        let light = self.light(channel);
        let peak = light.samples().iter().copied().fold(f32::MIN, f32::max);
        let lowest = light.samples().iter().copied().fold(f32::MAX, f32::min);
        let sum = light.sum();
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

//! Lens profiles: what a fit learned of a lens, as values and as versioned JSON.

mod check;
mod controls;
mod json;
mod moments;
mod pupil;

pub use controls::Controls;
pub use json::schema;
pub use moments::{MomentsChannel, MomentsPlane, RadialDisplacement};
pub use pupil::{ProfileEffect, PupilChannel};

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::Result;
use crate::field::Frame;
use crate::lens::DepthLaw;

/// A lens: its frame and camera, and by what it is described.
#[derive(Debug, Clone, PartialEq)]
pub struct LensProfile {
    /// The full frame in whose pixels PSFs are given, and its optical axis.
    pub frame: Frame,
    /// Sensor pixel pitch, micrometres, where known.
    pub pixel_pitch_um: Option<f64>,
    /// What is known of the camera.
    pub camera: Camera,
    /// By what the lens is described.
    pub description: LensDescription,
    /// How well it drew PSFs that were kept out of the fit, where some were.
    pub held_out: Option<HeldOut>,
    /// Where the profile came from.
    pub provenance: Provenance,
}

/// By what a lens is described: one entry a colour channel.
#[derive(Debug, Clone, PartialEq)]
pub enum LensDescription {
    /// S1..S10 per channel and object distance (`"kind": "moments"` in files).
    Moments(Vec<MomentsChannel>),
    /// Ray by ray, by numbers that are series in vergence (`"kind": "pupil"` in files).
    Pupil(Vec<PupilChannel>),
}

/// How well a lens drew PSFs that took no part in its fit.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// Tiles kept out, over all channels and distances.
    pub tiles: usize,
    /// How they were chosen, in words.
    pub rule: String,
    /// Mean over tiles of the forward-blur signal to noise, dB.
    pub snr_db: f64,
    /// Mean over tiles of the squared difference of pixels over the tile's squared norm.
    pub pixel_gap: f64,
    /// The same by channel and distance.
    pub groups: Vec<HeldOutGroup>,
}

/// One channel at one object distance of [`HeldOut`].
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutGroup {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Tiles kept out.
    pub tiles: usize,
    /// As [`HeldOut::snr_db`].
    pub snr_db: f64,
    /// As [`HeldOut::pixel_gap`].
    pub pixel_gap: f64,
}

/// Where a profile came from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// Program and version that made it.
    pub program: String,
    /// The observation sets it was fitted to, by name.
    pub sources: Vec<String>,
    /// The settings of the fit, in words.
    pub settings: String,
}

impl LensProfile {
    /// Reads a profile from its JSON text.
    ///
    /// # Errors
    /// Text that is not JSON (with line and column), another format, version or kind, unknown or
    /// missing keys, and values that cannot be.
    pub fn from_json(text: &str) -> Result<Self> {
        json::read(text)
    }

    /// The profile as JSON text, keys in a fixed order. Numbers come back to the last bit.
    pub fn to_json(&self) -> String {
        json::write(self)
    }

    /// Names of the channels.
    pub fn channel_names(&self) -> Vec<&str> {
        match &self.description {
            LensDescription::Moments(channels) => {
                channels.iter().map(|c| c.name.as_str()).collect()
            }
            LensDescription::Pupil(channels) => channels.iter().map(|c| c.name.as_str()).collect(),
        }
    }

    /// The channels of a lens described by S1..S10; none of a lens known ray by ray.
    pub fn moments_channels(&self) -> &[MomentsChannel] {
        match &self.description {
            LensDescription::Moments(channels) => channels,
            LensDescription::Pupil(_) => &[],
        }
    }

    /// The channels of a lens known ray by ray; none of a lens described by S1..S10.
    pub fn pupil_channels(&self) -> &[PupilChannel] {
        match &self.description {
            LensDescription::Pupil(channels) => channels,
            LensDescription::Moments(_) => &[],
        }
    }

    /// Nearest and farthest distance at which the lens was measured, metres; the farthest may be infinite. `None` where
    /// it was measured at no finite distance.
    pub fn measured_range_m(&self) -> Option<(f64, f64)> {
        let vergences: Vec<f64> = match &self.description {
            LensDescription::Moments(channels) => (channels.iter())
                .flat_map(|channel| &channel.planes)
                .filter_map(|plane| plane.distance.vergence_per_m())
                .collect(),
            LensDescription::Pupil(channels) => (channels.iter())
                .flat_map(|channel| [channel.measured_vergence.0, channel.measured_vergence.1])
                .collect(),
        };
        let near = vergences.iter().copied().fold(0.0, f64::max);
        let far = vergences.iter().copied().fold(f64::INFINITY, f64::min);
        (near > 0.0).then(|| (1.0 / near, 1.0 / far.max(0.0)))
    }

    /// The depth law of every channel described by S1..S10; `None` for one whose only plane is at an
    /// unknown distance.
    ///
    /// # Errors
    /// Planes at the same distance.
    pub fn depth_laws(&self) -> Result<Vec<Option<DepthLaw>>> {
        let defocus = self.defocus_px_per_dioptre();
        let channels = self.moments_channels().iter();
        channels.map(|channel| channel.depth_law(defocus)).collect()
    }

    /// Z2 R / M in frame pixels per 1/m for the camera taken as a thin lens with its pupil in the
    /// lens; `None` where the camera is not fully known. Fixes the v² term of S1 where only two
    /// planes were measured; real pupils change it by a few per cent.
    pub fn defocus_px_per_dioptre(&self) -> Option<f64> {
        let f_m = self.camera.focal_length_mm? * 1e-3;
        let radius_m = f_m / (2.0 * self.camera.f_number?);
        let pitch_m = self.pixel_pitch_um? * 1e-6;
        let focus = self.camera.focus_distance.vergence_per_m()?;
        let image_m = f_m / (1.0 - f_m * focus);
        Some(image_m * radius_m / pitch_m)
    }
}

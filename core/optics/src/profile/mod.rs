//! Lens profiles: fitted lenses as values and as versioned JSON.
//!
//! ```
//! use seidel_optics::BlurField;
//! use seidel_optics::distance::ObjectDistance;
//! use seidel_optics::field::FieldPoint;
//! use seidel_optics::predict::Predictor;
//! use seidel_optics::profile::LensProfile;
//!
//! let text = r#"{
//!   "format": "seidel-lens", "version": 1, "kind": "moments",
//!   "image_size": [1920, 1080], "optical_axis": [960, 540],
//!   "channels": [{ "name": "Y", "planes": [{
//!     "depth_m": null, "s": [4, 1, 0.5, 0, 0, 0, 0, 0, 0, 0], "s_sigma": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
//!     "tiles_used": 25, "tiles_rejected": 0 }] }],
//!   "provenance": { "program": "by hand", "sources": [], "settings": "" }
//! }"#;
//! let lens = Predictor::new(&LensProfile::from_json(text)?)?;
//! let vergence = lens.vergence(ObjectDistance::Infinity)?;
//! let right_edge = lens.blur_at(0, FieldPoint::new(1.0, 0.0), vergence);
//! assert_eq!(right_edge.blur.moments.mu20, 5.5); // meridional variance, px²
//! # Ok::<(), seidel_optics::Error>(())
//! ```

mod adequacy;
mod check;
mod controls;
mod coverage;
mod json;
mod look;
mod moments;
mod pupil;
mod scale;

pub use adequacy::{
    Adequacy, FieldPattern, FieldZone, MAX_EXCESS_DESCRIBED, MAX_EXCESS_IN_PART, ResidualPattern,
    Verdict, WorstPlace,
};
pub use controls::Controls;
pub use coverage::{TileCoverage, bare_distances, bare_sides, distance_gap};
pub use json::schema;
pub use look::{Blades, Look, LookRange};
pub use moments::{MomentsChannel, MomentsPlane, RadialDisplacement};
pub use pupil::{ProfileEffect, PupilChannel};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::Result;
use crate::field::Frame;
use crate::lens::DepthLaw;

/// A fitted lens: frame, camera and the description of its blur.
#[derive(Debug, Clone, PartialEq)]
pub struct LensProfile {
    /// The full frame, whose pixels are the unit of PSFs, and its optical axis.
    pub frame: Frame,
    /// Sensor pixel pitch, micrometres, if known.
    pub pixel_pitch_um: Option<f64>,
    /// Known settings of the camera.
    pub camera: Camera,
    /// The description of the blur.
    pub description: LensDescription,
    /// The score on held-out PSFs, if the fit held some out.
    pub held_out: Option<HeldOut>,
    /// The origin of the profile.
    pub provenance: Provenance,
}

/// The description of the blur of a lens, one entry a colour channel.
#[derive(Debug, Clone, PartialEq)]
pub enum LensDescription {
    /// S1..S10 per channel and object distance (`"kind": "moments"` in files).
    Moments(Vec<MomentsChannel>),
    /// Wavefront and pupil, with parameters that are series in vergence (`"kind": "pupil"` in files).
    Pupil(Vec<PupilChannel>),
}

/// The score of a lens on PSFs that its fit held out.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// Number of held-out tiles, over all channels and distances.
    pub tiles: usize,
    /// The rule that selected them, in words.
    pub rule: String,
    /// Mean over tiles of the forward-blur signal-to-noise ratio, dB.
    pub snr_db: f64,
    /// Mean over tiles of the squared error of the pixels over the squared norm of the tile.
    pub pixel_gap: f64,
    /// Mean over tiles of the share of a tile's light that the model puts into the wrong pixels, half the sum of absolute
    /// differences: the error of a highlight's shape. `None` in profiles of versions that did not measure it.
    pub misplaced_light: Option<f64>,
    /// Mean over tiles of the signal-to-noise ratio of the nearest fitted tiles in place of the model, dB; `None` where they were
    /// not compared.
    pub neighbours_snr_db: Option<f64>,
    /// The scores by channel and distance.
    pub groups: Vec<HeldOutGroup>,
    /// The adequacy of the model for the lens; `None` in profiles of versions that did not state it.
    pub adequacy: Option<Adequacy>,
}

/// The score of one channel at one object distance in [`HeldOut`].
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutGroup {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Number of held-out tiles.
    pub tiles: usize,
    /// Mean over these tiles of the quantity of [`HeldOut::snr_db`].
    pub snr_db: f64,
    /// Mean over these tiles of the quantity of [`HeldOut::pixel_gap`].
    pub pixel_gap: f64,
    /// Mean over these tiles of the quantity of [`HeldOut::misplaced_light`].
    pub misplaced_light: Option<f64>,
}

/// The origin of the profile.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename = "ProvenanceFile")]
pub struct Provenance {
    /// Program and version that made the profile.
    pub program: String,
    /// Names of the observation sets of the fit.
    pub sources: Vec<String>,
    /// Settings of the fit, in words.
    pub settings: String,
    /// The tiles of the fit by distance, from the farthest; empty where it had none, and in profiles of versions that did not state
    /// them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tiles: Vec<TileCoverage>,
}

impl Provenance {
    /// The words in [`Provenance::settings`] of fits that held no PSFs out.
    pub const NONE_HELD_OUT: &str = "none held out";

    /// Returns whether the lens was fitted to all PSFs.
    pub fn held_nothing_out(&self) -> bool {
        self.settings.contains(Self::NONE_HELD_OUT)
    }
}

impl LensProfile {
    /// Reads a profile from its JSON text.
    ///
    /// # Errors
    /// Rejects text that is not JSON (with line and column), other formats, versions and kinds, unknown and missing
    /// keys, and invalid values.
    pub fn from_json(text: &str) -> Result<Self> {
        json::read(text)
    }

    /// Returns the profile as JSON text with keys in a fixed order. Numbers round-trip exactly. A profile that
    /// [`Self::check_storable`] refuses is not read back.
    pub fn to_json(&self) -> String {
        json::write(self)
    }

    /// Returns how well the model describes the lens; `None` where the fit held nothing out, and in old profiles.
    pub fn adequacy(&self) -> Option<&Adequacy> {
        self.held_out.as_ref()?.adequacy.as_ref()
    }

    /// Returns the names of the channels.
    pub fn channel_names(&self) -> Vec<&str> {
        match &self.description {
            LensDescription::Moments(channels) => {
                channels.iter().map(|c| c.name.as_str()).collect()
            }
            LensDescription::Pupil(channels) => channels.iter().map(|c| c.name.as_str()).collect(),
        }
    }

    /// Returns the channels of a profile of the kind `moments`; empty for other kinds.
    pub fn moments_channels(&self) -> &[MomentsChannel] {
        match &self.description {
            LensDescription::Moments(channels) => channels,
            LensDescription::Pupil(_) => &[],
        }
    }

    /// Returns the channels of a profile of the kind `pupil`; empty for other kinds.
    pub fn pupil_channels(&self) -> &[PupilChannel] {
        match &self.description {
            LensDescription::Pupil(channels) => channels,
            LensDescription::Moments(_) => &[],
        }
    }

    /// Returns the nearest and the farthest distance at which the lens was measured, metres; the farthest may be
    /// infinite. `None` if it was measured at no finite distance.
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

    /// Returns the depth law of every channel of a profile of the kind `moments`; `None` for a channel whose only plane
    /// has an unknown distance.
    ///
    /// # Errors
    /// Rejects two planes at the same distance.
    pub fn depth_laws(&self) -> Result<Vec<Option<DepthLaw>>> {
        let defocus = self.defocus_px_per_dioptre();
        let channels = self.moments_channels().iter();
        channels.map(|channel| channel.depth_law(defocus)).collect()
    }

    /// Returns Z2 R / M in frame pixels per 1/m, for a thin lens with its pupil in the lens; `None` if the camera is not
    /// fully known.
    ///
    /// It determines the v² term of S1 if only two planes were measured. Real pupils change it by a few per cent.
    pub fn defocus_px_per_dioptre(&self) -> Option<f64> {
        let f_m = self.camera.focal_length_mm? * 1e-3;
        let radius_m = f_m / (2.0 * self.camera.f_number?);
        let pitch_m = self.pixel_pitch_um? * 1e-6;
        let focus = self.camera.focus_distance.vergence_per_m()?;
        let image_m = f_m / (1.0 - f_m * focus);
        Some(image_m * radius_m / pitch_m)
    }
}

//! Lens profiles: what a fit learned of a lens, as values and as versioned JSON.

mod json;
mod pupil;

pub use json::schema;
pub use pupil::{CarriedEffect, PupilChannel};

use crate::camera::Camera;
use crate::distance::ObjectDistance;
use crate::error::{Error, Result};
use crate::field::Frame;
use crate::lens::{DepthLaw, DepthPlane, MomentCoefficients};

/// A lens known by S1..S10 per channel and object distance (`"kind": "moments"` in files).
#[derive(Debug, Clone, PartialEq)]
pub struct LensProfile {
    /// The full frame in whose pixels moments are given, and its optical axis.
    pub frame: Frame,
    /// Sensor pixel pitch, micrometres, where known.
    pub pixel_pitch_um: Option<f64>,
    /// What is known of the camera.
    pub camera: Camera,
    /// One entry a colour channel.
    pub channels: Vec<MomentsChannel>,
    /// Where the profile came from.
    pub provenance: Provenance,
}

/// One colour channel of a lens.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentsChannel {
    /// Channel name, such as `R` or `Y`.
    pub name: String,
    /// The object distances at which it was measured, from infinity inwards.
    pub planes: Vec<MomentsPlane>,
}

/// One channel at one object distance.
#[derive(Debug, Clone, PartialEq)]
pub struct MomentsPlane {
    /// Object distance.
    pub distance: ObjectDistance,
    /// S1..S10 of the light before it is integrated over pixels: PSF in frame pixels, field in half
    /// frame widths.
    pub s: MomentCoefficients,
    /// Standard errors of S1..S10.
    pub s_sigma: [f64; 10],
    /// Where PSFs land, where the observations knew their ideal positions.
    pub displacement: Option<Displacement>,
    /// Tiles that took part in the fit.
    pub tiles_used: usize,
    /// Tiles that were rejected.
    pub tiles_rejected: usize,
}

/// Centroid less ideal position: X (magnification + distortion |X|²), in field units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Displacement {
    /// Relative change of scale, coma's share of the centroid included.
    pub magnification: f64,
    /// Distortion per squared half frame width.
    pub distortion: f64,
    /// Standard error of `magnification`.
    pub magnification_sigma: f64,
    /// Standard error of `distortion`.
    pub distortion_sigma: f64,
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

    /// The profile as JSON text, keys in a fixed order.
    pub fn to_json(&self) -> String {
        json::write(self)
    }

    /// Names of the channels.
    pub fn channel_names(&self) -> Vec<&str> {
        self.channels.iter().map(|c| c.name.as_str()).collect()
    }

    /// The depth law of every channel; `None` for one whose only plane is at an unknown distance.
    ///
    /// # Errors
    /// Planes at the same distance.
    pub fn depth_laws(&self) -> Result<Vec<Option<DepthLaw>>> {
        self.channels
            .iter()
            .map(|channel| {
                let planes: Vec<_> = channel
                    .planes
                    .iter()
                    .filter_map(|plane| {
                        Some(DepthPlane {
                            vergence_per_m: plane.distance.vergence_per_m()?,
                            s: plane.s,
                            s_sigma: plane.s_sigma,
                        })
                    })
                    .collect();
                if planes.is_empty() {
                    return Ok(None);
                }
                DepthLaw::fit(&planes, self.defocus_px_per_dioptre())
                    .map(Some)
                    .map_err(|error| error.within(&format!("channel {}", channel.name)))
            })
            .collect()
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

    /// Checks what a reader cannot see key by key.
    fn check(&self) -> Result<()> {
        let bad =
            |place: String, problem: String, remedy: &str| Err(Error::new(place, problem, remedy));
        if self.channels.is_empty() {
            return bad(
                "channels".into(),
                "is empty".into(),
                "a lens has at least one channel",
            );
        }
        for (index, channel) in self.channels.iter().enumerate() {
            let place = format!("channels[{index}] ({})", channel.name);
            if self.channels[..index]
                .iter()
                .any(|c| c.name == channel.name)
            {
                return bad(place, "occurs twice".into(), "name every channel once");
            }
            if channel.planes.is_empty() {
                return bad(
                    place,
                    "has no planes".into(),
                    "a channel has at least one object distance",
                );
            }
            let unknown = channel
                .planes
                .iter()
                .filter(|p| p.distance == ObjectDistance::Unknown)
                .count();
            if unknown > 0 && channel.planes.len() > 1 {
                return bad(
                    place,
                    "mixes known and unknown object distances".into(),
                    "give depth_m for every plane, or keep one plane without it",
                );
            }
            for (number, plane) in channel.planes.iter().enumerate() {
                let place = format!("channels[{index}] ({}) planes[{number}]", channel.name);
                let finite = plane
                    .s
                    .0
                    .iter()
                    .chain(&plane.s_sigma)
                    .all(|x| x.is_finite())
                    && plane
                        .displacement
                        .is_none_or(|d| d.magnification.is_finite() && d.distortion.is_finite());
                if !finite {
                    return bad(
                        place,
                        "holds a number that is not finite".into(),
                        "fit the lens again",
                    );
                }
            }
        }
        self.depth_laws().map(|_| ())
    }
}

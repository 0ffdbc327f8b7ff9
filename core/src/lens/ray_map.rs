//! The ray map: where the ray through each point of the pupil meets the sensor (Eqs 5-6).

use super::{ReducedNumbers, Wavefront};
use crate::field::FieldPoint;

/// The region of the entrance pupil that light passes, in units of its radius.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pupil {
    /// The whole unit disc, evenly lit.
    #[default]
    UniformDisc,
}

impl Pupil {
    /// Transmission at pupil point `u`: 1 where light passes, 0 where it is stopped.
    pub fn transmission(self, u: [f64; 2]) -> f64 {
        match self {
            Self::UniformDisc => f64::from(u8::from(u[0] * u[0] + u[1] * u[1] <= 1.0)),
        }
    }
}

/// A lens ray by ray at one depth and channel: wavefront, pupil and distortion.
pub struct RayMap {
    /// What bends the rays.
    pub wavefront: Wavefront,
    /// What lets them pass.
    pub pupil: Pupil,
    /// Radial displacement of the chief ray: it lands at X (1 + distortion |X|²).
    pub distortion: f64,
}

impl RayMap {
    /// The map of a third-order lens with an even round pupil. `distortion` is -E M² / Z2², per
    /// field².
    pub fn third_order(numbers: ReducedNumbers, distortion: f64) -> Self {
        Self {
            wavefront: Wavefront::third_order(numbers),
            pupil: Pupil::UniformDisc,
            distortion,
        }
    }

    /// Where the chief ray of ideal position `at` lands, in field units.
    pub fn chief_ray(&self, at: FieldPoint) -> FieldPoint {
        let scale = 1.0 + self.distortion * (at.x * at.x + at.y * at.y);
        FieldPoint::new(at.x * scale, at.y * scale)
    }

    /// Offset from the chief ray of the ray through pupil point `u`, in PSF length.
    pub fn ray_offset(&self, at: FieldPoint, u: [f64; 2]) -> [f64; 2] {
        self.wavefront.slope(at, u)
    }
}

//! Effects: what a real lens does beyond third order, each one part of the forward model.
//!
//! An effect changes the [`LocalPupil`] of a point: it adds terms to the wavefront, clips or dims the
//! pupil, or changes what the sensor does to the picture; and it may move the chief ray.
//! A lens profile carries any of them by identifier. One effect a file; all of them are in [`ALL`].

mod anamorphic;
mod aperture_polygon;
mod apodisation;
mod axial_colour;
mod decentre;
mod defocus_offset;
mod depth_scale;
mod diffraction;
mod distortion;
mod higher_order;
mod lateral_colour;
mod motion;
mod pixel_footprint;
mod sensor_tilt;
mod tone_curve;
mod veiling_glare;
mod vignetting;

pub use anamorphic::Anamorphic;
pub use aperture_polygon::AperturePolygon;
pub use apodisation::Apodisation;
pub use axial_colour::AxialColour;
pub use decentre::Decentre;
pub use defocus_offset::DefocusOffset;
pub use depth_scale::DepthScale;
pub use diffraction::Diffraction;
pub use distortion::Distortion;
pub use higher_order::HigherOrder;
pub use lateral_colour::LateralColour;
pub use motion::Motion;
pub use pixel_footprint::PixelFootprint;
pub use sensor_tilt::SensorTilt;
pub use tone_curve::ToneCurve;
pub use veiling_glare::VeilingGlare;
pub use vignetting::Vignetting;

use crate::error::{Error, Result};
use crate::field::FieldPoint;
use crate::lens::{LocalPupil, VergenceSeries};

/// A number that says how strong an effect is, or of what shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Stable name, as profiles write it.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Value at which it does nothing.
    pub neutral: f64,
    /// Least value that makes sense.
    pub least: f64,
    /// Largest value that makes sense.
    pub most: f64,
    /// A change that can be seen, no more: the step of searches, in `unit`.
    pub step: f64,
    /// Whether colour channels share its value.
    pub scope: Scope,
}

impl Parameter {
    /// One that is shared by all channels and does nothing at zero, lengths in px in mind.
    const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self {
            name,
            unit,
            meaning,
            neutral: 0.0,
            least: 0.0,
            most: 0.0,
            step: 0.05,
            scope: Scope::Lens,
        }
    }

    const fn at_rest(self, neutral: f64) -> Self {
        Self { neutral, ..self }
    }

    const fn within(self, least: f64, most: f64) -> Self {
        Self {
            least,
            most,
            ..self
        }
    }

    const fn step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    const fn scope(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }
}

/// Whether colour channels share the value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One value for all.
    Lens,
    /// One value a channel.
    Channel,
    /// One value a channel but for the one of middle wavelength, which stays neutral: what counts is
    /// the difference between channels.
    Difference,
}

/// Where a search for the values of an effect starts.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchStart {
    /// One value a parameter, the same in every channel.
    pub values: Vec<f64>,
    /// Whether the search may change it: kinds that are counted, such as blades, are tried one by one.
    pub free: Vec<bool>,
}

impl SearchStart {
    /// A search from `values` that may change all of them.
    pub fn all_free(values: &[f64]) -> Self {
        Self {
            values: values.to_vec(),
            free: vec![true; values.len()],
        }
    }
}

/// Where in the scene a point of light is: what the strength of an effect may depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScenePoint {
    /// Field position.
    pub at: FieldPoint,
    /// 1 / distance, 1/m.
    pub vergence_per_m: f64,
    /// Pupil radius over the slope of the chief ray of a point half a frame width off the axis, m:
    /// what turns the shift of a stop into its distance from the pupil. Zero where the camera is not
    /// known; then stops stay where they are at every object distance.
    pub stop_lever_m: f64,
    /// How fast defocus grows with vergence here, px m; zero where depth is not known.
    pub defocus_px_m: f64,
    /// Vergence of an object in focus on the axis, 1/m.
    pub focus_vergence_per_m: f64,
    /// Wavelength of the channel over the pixel pitch; zero where not known.
    pub wavelength_px: f64,
}

/// How a lens is set otherwise than it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlRatios {
    /// New radius of the pupil over the measured one.
    pub pupil: f64,
    /// New distance of the sensor from the pupil over the measured one.
    pub image_distance: f64,
}

/// A part of the forward model beyond the base lens.
pub trait Effect: Send + Sync {
    /// Stable identifier, as profiles and reports name it.
    fn id(&self) -> &'static str;

    /// What it is and looks like, in a line.
    fn summary(&self) -> &'static str;

    /// What [`Effect::apply`] takes, in order.
    fn parameters(&self) -> &'static [Parameter];

    /// Does to `pupil` what the effect does at `point`; `values` are the parameters', in order.
    ///
    /// # Panics
    /// If there are not as many values as parameters.
    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil);

    /// How far it moves the chief ray, px of the frame; `values` as in [`Effect::apply`]. What it does to the
    /// centroid by way of the rays is not part of it.
    fn chief_ray(&self, _values: &[f64], _point: ScenePoint) -> [f64; 2] {
        [0.0; 2]
    }

    /// Where to start a search for its values, the likeliest first; none of them neutral in all that
    /// counts.
    fn starts(&self) -> Vec<SearchStart>;

    /// The parameters' `values`, in order, of the same glass with its pupil and sensor reset `to`.
    fn rescale(&self, values: &[VergenceSeries], to: ControlRatios) -> Vec<VergenceSeries>;
}

/// Every effect, in the order in which they act.
pub static ALL: &[&dyn Effect] = &[
    &DefocusOffset,
    &DepthScale,
    &SensorTilt,
    &Decentre,
    &HigherOrder,
    &AxialColour,
    &LateralColour,
    &Distortion,
    &Anamorphic,
    &AperturePolygon,
    &Vignetting,
    &Apodisation,
    &Diffraction,
    &Motion,
    &PixelFootprint,
    &VeilingGlare,
    &ToneCurve,
];

/// The effect called `id`.
///
/// # Errors
/// A name that no effect has; the message lists those that exist.
pub fn by_id(id: &str) -> Result<&'static dyn Effect> {
    ALL.iter()
        .copied()
        .find(|effect| effect.id() == id)
        .ok_or_else(|| {
            let names: Vec<_> = ALL.iter().map(|effect| effect.id()).collect();
            Error::new(
                format!("effect `{id}`"),
                "is not known",
                format!("use one of: {}", names.join(", ")),
            )
        })
}

/// The values at which `effect` does nothing.
pub fn neutral(effect: &dyn Effect) -> Vec<f64> {
    effect.parameters().iter().map(|p| p.neutral).collect()
}

#[cfg(test)]
pub(crate) mod tests;

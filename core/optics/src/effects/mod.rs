//! Effects: properties of real lenses beyond the third-order model.
//!
//! An [`Effect`] changes the [`LocalPupil`] of a point: it adds wavefront terms, adds stops, changes the transmission or
//! the sensor. It may also shift the chief ray. Each effect has a file, which holds everything that is known of it, its words in
//! reports among that; all of them are listed in [`ALL`]. Lens profiles name effects by identifier; code elsewhere asks
//! the trait.

pub(crate) mod amount;
mod anamorphic;
mod aperture_polygon;
mod apodisation;
mod axial_colour;
mod decentre;
mod defocus_offset;
mod depth_scale;
mod description;
mod diffraction;
mod distortion;
mod double_plane;
mod focus_error;
mod higher_order;
mod lateral_colour;
mod lens_scale;
mod meridional_terms;
mod monomials;
mod motion;
mod obstruction;
mod pixel_footprint;
mod pupil_scale;
mod sensor_tilt;
mod seventh_order;
mod tone_curve;
mod veiling_glare;
mod vignetting;

pub use amount::{Fitted, FittedValue};
pub use anamorphic::Anamorphic;
pub use aperture_polygon::AperturePolygon;
pub use apodisation::Apodisation;
pub use axial_colour::AxialColour;
pub use decentre::Decentre;
pub use defocus_offset::DefocusOffset;
pub use depth_scale::DepthScale;
pub use description::{Description, FieldNeed, FitPart, OneDistanceTwin, Symmetry};
pub use diffraction::Diffraction;
pub use distortion::Distortion;
pub use double_plane::DoublePlane;
pub use focus_error::FocusError;
pub use higher_order::HigherOrder;
pub use lateral_colour::LateralColour;
pub use lens_scale::LensScale;
pub use motion::Motion;
pub use obstruction::Obstruction;
pub use pixel_footprint::PixelFootprint;
pub use pupil_scale::PupilScale;
pub use sensor_tilt::SensorTilt;
pub use seventh_order::SeventhOrder;
pub use tone_curve::ToneCurve;
pub use veiling_glare::VeilingGlare;
pub use vignetting::Vignetting;

use crate::error::{Error, Result};
use crate::field::FieldPoint;
use crate::lens::{LocalPupil, VergenceSeries};

/// A parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// The stable name used in profiles.
    pub name: &'static str,
    /// The unit of the values.
    pub unit: &'static str,
    /// A description in a few words.
    pub meaning: &'static str,
    /// The value without effect.
    pub neutral: f64,
    /// The smallest valid value.
    pub least: f64,
    /// The largest valid value.
    pub most: f64,
    /// A just visible change, in `unit`: the step of searches.
    pub step: f64,
    /// The relation between the values in different colour channels.
    pub scope: Scope,
}

impl Parameter {
    /// Creates a parameter that all channels share, with neutral value zero and a step suited to px.
    pub(crate) const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
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

    pub(crate) const fn neutral_at(self, neutral: f64) -> Self {
        Self { neutral, ..self }
    }

    pub(crate) const fn within(self, least: f64, most: f64) -> Self {
        Self {
            least,
            most,
            ..self
        }
    }

    pub(crate) const fn step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    pub(crate) const fn scope(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }
}

/// The relation between the values of a parameter in different colour channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One value for all channels.
    Lens,
    /// One value for each channel.
    Channel,
    /// One value for each channel except that of middle wavelength, which stays neutral: only differences between
    /// channels matter.
    Difference,
}

/// A start of a search for the parameter values of an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchStart {
    /// One value a parameter, the same in every channel.
    pub values: Vec<f64>,
    /// True for each value that the search may change. Counts, such as blades, are fixed; each has its own start.
    pub free: Vec<bool>,
    /// Whether the values are likely ones. A search tries weaker and opposite ones too otherwise.
    pub is_likely: bool,
}

impl SearchStart {
    /// Creates a start at `values` that may change those marked in `free`.
    pub fn new(values: &[f64], free: &[bool]) -> Self {
        Self {
            values: values.to_vec(),
            free: free.to_vec(),
            is_likely: false,
        }
    }

    /// Creates a start at `values` that may change all of them.
    pub fn all_free(values: &[f64]) -> Self {
        Self::new(values, &vec![true; values.len()])
    }

    /// Returns the start with values that are likely.
    #[must_use]
    pub fn likely(self) -> Self {
        Self {
            is_likely: true,
            ..self
        }
    }
}

/// A point of light in the scene and the properties of the lens there: the input of effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScenePoint {
    /// Field position.
    pub at: FieldPoint,
    /// Vergence 1 / distance, 1/m.
    pub vergence_per_m: f64,
    /// Pupil radius over the slope of the chief ray half a frame width off the axis, m. It converts the shift of a stop
    /// to its distance from the pupil. Zero if the camera is unknown; stops then do not change with object distance.
    pub stop_lever_m: f64,
    /// Derivative of defocus by vergence, px m; zero if depth is unknown.
    pub defocus_px_m: f64,
    /// Vergence of an object in focus on the axis, 1/m.
    pub focus_vergence_per_m: f64,
    /// Wavelength of the channel over the pixel pitch; zero if unknown.
    pub wavelength_px: f64,
}

/// The ratios of new to measured lens controls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlRatios {
    /// New over measured radius of the pupil.
    pub pupil: f64,
    /// New over measured distance from the pupil to the sensor.
    pub image_distance: f64,
}

impl ControlRatios {
    /// Returns the factor of the slope at the rim of a wavefront term with pupil power `pupil` and field power `field`: the
    /// slope has pupil power one less, the field angle X / Z2 has power `field`, and lengths scale with Z2.
    fn of_wave_term(self, pupil: usize, field: i32) -> f64 {
        self.pupil.powi(pupil as i32 - 1) * self.image_distance.powi(1 - field)
    }
}

/// An effect beyond the third-order lens model.
pub trait Effect: Send + Sync {
    /// Returns the fixed facts of the effect: its words, and how fits, diagnoses and pages treat it.
    fn description(&self) -> &'static Description;

    /// Returns the stable identifier used in profiles and reports.
    fn id(&self) -> &'static str {
        self.description().id
    }

    /// Returns the parameters, in the order of the values of [`Effect::apply`].
    fn parameters(&self) -> &'static [Parameter] {
        self.description().parameters
    }

    /// Applies the effect at `point` to `pupil`, with one of `values` for each parameter. Effects that shift the chief ray alone
    /// leave the pupil as it is.
    ///
    /// # Panics
    /// If the number of values is not that of the parameters.
    fn apply(&self, _values: &[f64], _point: ScenePoint, _pupil: &mut LocalPupil) {}

    /// Returns the shift of the chief ray (x, y), frame px, with `values` as in [`Effect::apply`].
    ///
    /// The shift of the centroid relative to the chief ray is not included.
    fn chief_ray(&self, _values: &[f64], _point: ScenePoint) -> [f64; 2] {
        [0.0; 2]
    }

    /// Returns what `values` amount to, in words, for effects of which one number says much.
    fn amount(&self, _values: &[f64]) -> Option<String> {
        None
    }

    /// Returns what the values of a diagnosis amount to in the units of the camera, with standard errors, in words; `None` where
    /// few words do not describe them.
    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        fitted.largest()
    }

    /// Returns the symmetry over the field of the effect with `values`.
    fn symmetry(&self, _values: &[VergenceSeries]) -> Symmetry {
        self.description().symmetry
    }

    /// Returns starts for a search of the values, the likeliest first. None of them is neutral.
    fn starts(&self) -> Vec<SearchStart>;

    /// Returns starts for a search against observations at `vergences`, 1/m and rising: none where they cannot show the effect.
    fn starts_at(&self, _vergences: &[f64]) -> Vec<SearchStart> {
        self.starts()
    }

    /// Returns the values of `simpler`, an effect that this one contains, that `values` imitate; `None` where they do not show them.
    fn contained_values(&self, _simpler: &dyn Effect, _values: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Returns `values` for the same lens with pupil and sensor distance changed by `ratios`: as they are, for effects that are
    /// not of the lens.
    fn rescale(&self, values: &[VergenceSeries], _ratios: ControlRatios) -> Vec<VergenceSeries> {
        values.to_vec()
    }
}

/// All effects, in the order in which they act.
pub static ALL: &[&dyn Effect] = &[
    &PupilScale,
    &DefocusOffset,
    &DepthScale,
    &FocusError,
    &SensorTilt,
    &Decentre,
    &HigherOrder,
    &SeventhOrder,
    &DoublePlane,
    &AxialColour,
    &LateralColour,
    &Distortion,
    &Anamorphic,
    &AperturePolygon,
    &Vignetting,
    &Obstruction,
    &Apodisation,
    &Diffraction,
    &Motion,
    &PixelFootprint,
    &VeilingGlare,
    &ToneCurve,
];

/// Returns the effects that a diagnosis tries as causes of a gap.
pub fn causes() -> impl Iterator<Item = &'static dyn Effect> {
    ALL.iter()
        .copied()
        .filter(|effect| effect.description().is_cause)
}

/// Returns the position of `effect` in [`ALL`].
pub fn acting_position(effect: &dyn Effect) -> usize {
    let known = ALL.iter().position(|known| known.id() == effect.id());
    known.unwrap_or(ALL.len())
}

/// Returns the effect called `id`.
///
/// # Errors
/// Rejects an unknown name; the message lists the known ones.
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

/// Returns the neutral values of `effect`.
pub fn neutral(effect: &dyn Effect) -> Vec<f64> {
    effect.parameters().iter().map(|p| p.neutral).collect()
}

#[cfg(test)]
pub(crate) mod tests;

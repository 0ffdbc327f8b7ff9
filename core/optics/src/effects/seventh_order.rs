//! Seventh-order aberrations: the thirteen wave terms of eighth degree in pupil and field.

use super::meridional_terms::{MeridionalTerm, apply, coefficient, rescaled};
use super::{ControlRatios, Description, Effect, FitPart, Parameter, ScenePoint, SearchStart};
use crate::lens::{LocalPupil, VergenceSeries};

/// `seventh_order`: spherical aberration of the eighth degree, and oblique aberrations that grow faster still with field.
///
/// # Appearance
/// Corners of fast or strongly vignetted lenses, such as Petzval lenses, where fifth order is not enough.
///
/// # Similar effects
/// `higher_order`; vignetting.
///
/// # Model
/// Hopkins's terms `W_klm`, h^k |u|^l cos^m with k + l = 8, without distortion. Values are the slope at the rim of the pupil
/// in px, per half frame width to the power k.
#[derive(Debug, Clone, Copy, Default)]
pub struct SeventhOrder;

static TERMS: [MeridionalTerm; 13] = [
    MeridionalTerm::w(0, 8, 0),
    MeridionalTerm::w(1, 7, 1),
    MeridionalTerm::w(2, 6, 2),
    MeridionalTerm::w(2, 6, 0),
    MeridionalTerm::w(3, 5, 3),
    MeridionalTerm::w(3, 5, 1),
    MeridionalTerm::w(4, 4, 4),
    MeridionalTerm::w(4, 4, 2),
    MeridionalTerm::w(4, 4, 0),
    MeridionalTerm::w(5, 3, 3),
    MeridionalTerm::w(5, 3, 1),
    MeridionalTerm::w(6, 2, 2),
    MeridionalTerm::w(6, 2, 0),
];

const PARAMETERS: [Parameter; 13] = [
    coefficient("w080", "px", "spherical aberration, eighth degree"),
    coefficient("w171", "px/h", "coma, linear in field"),
    coefficient("w262", "px/h²", "oblique spherical aberration, meridional"),
    coefficient("w260", "px/h²", "oblique spherical aberration, isotropic"),
    coefficient("w353", "px/h³", "elliptical coma"),
    coefficient("w351", "px/h³", "coma, cubic in field"),
    coefficient("w444", "px/h⁴", "four-fold oblique aberration"),
    coefficient("w442", "px/h⁴", "oblique spherical aberration, meridional"),
    coefficient("w440", "px/h⁴", "oblique spherical aberration, isotropic"),
    coefficient("w533", "px/h⁵", "elliptical coma"),
    coefficient("w531", "px/h⁵", "coma, fifth power of field"),
    coefficient("w622", "px/h⁶", "astigmatism"),
    coefficient("w620", "px/h⁶", "field curvature"),
];

impl Effect for SeventhOrder {
    fn description(&self) -> &'static Description {
        &Description {
            id: "seventh_order",
            summary: "seventh-order aberrations: corners that differ from fifth order",
            title: "seventh-order aberrations",
            meaning: "The lens has aberrations of seventh order, which show in the corners of fast and wide lenses.",
            action: "Fit the lens again with the extended model and PSFs up to the corners.",
            parameters: &PARAMETERS,
            // A lens is designed so.
            is_cause: false,
            fit: FitPart {
                used: 13,
                starts: || vec![vec![0.0; 13]],
                worth: 0.1,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        apply(&TERMS, values, point, pupil);
    }

    fn starts(&self) -> Vec<SearchStart> {
        let mut values = [0.0; TERMS.len()];
        values[0] = 0.1;
        vec![SearchStart::all_free(&values)]
    }

    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        rescaled(&TERMS, values, ratios)
    }
}

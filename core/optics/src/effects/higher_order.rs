//! Fifth-order aberrations: the eight wave terms of sixth degree in pupil and field.

use super::meridional_terms::{MeridionalTerm, apply, coefficient, rescaled};
use super::{
    ControlRatios, Description, Effect, FieldNeed, FitPart, Parameter, ScenePoint, SearchStart,
};
use crate::lens::{LocalPupil, VergenceSeries};

/// `higher_order`: higher-order spherical aberration, oblique spherical aberration, and coma, astigmatism and field
/// curvature that grow faster with field.
///
/// # Appearance
/// Rings and flares in discs that are even to third order; corners that third-order fits of the centre do not predict.
///
/// # Similar effects
/// Defocus that changes with field; vignetting.
///
/// # Model
/// Hopkins's terms `W_klm`, h^k |u|^l cos^m, without distortion. Values are the slope at the rim of the pupil in px, per
/// half frame width to the power k.
#[derive(Debug, Clone, Copy, Default)]
pub struct HigherOrder;

static TERMS: [MeridionalTerm; 8] = [
    MeridionalTerm::w(0, 6, 0),
    MeridionalTerm::w(1, 5, 1),
    MeridionalTerm::w(2, 4, 2),
    MeridionalTerm::w(2, 4, 0),
    MeridionalTerm::w(3, 3, 3),
    MeridionalTerm::w(3, 3, 1),
    MeridionalTerm::w(4, 2, 2),
    MeridionalTerm::w(4, 2, 0),
];

const PARAMETERS: [Parameter; 8] = [
    coefficient("w060", "px", "spherical aberration, sixth order"),
    coefficient("w151", "px/h", "coma, linear in field"),
    coefficient("w242", "px/h²", "oblique spherical aberration, meridional"),
    coefficient("w240", "px/h²", "oblique spherical aberration, isotropic"),
    coefficient("w333", "px/h³", "elliptical coma"),
    coefficient("w331", "px/h³", "coma, cubic in field"),
    coefficient("w422", "px/h⁴", "astigmatism"),
    coefficient("w420", "px/h⁴", "field curvature"),
];

impl Effect for HigherOrder {
    fn description(&self) -> &'static Description {
        &Description {
            id: "higher_order",
            summary: "fifth-order aberrations: rings and flares in discs, corners that grow worse faster",
            title: "fifth-order aberrations",
            meaning: "The lens has stronger fifth-order aberrations than its profile: rings and flares in its discs, corners that worsen faster.",
            action: "Fit the lens again with the extended model and PSFs up to the corners. If an extended profile was right before, have the spacing of the elements checked.",
            parameters: &PARAMETERS,
            field_need: FieldNeed::Radii,
            far_out_of_focus: Some("the discs have rings and flares"),
            two_stops_down: "rings and flares vanish first",
            other_side_of_focus: "bright rims turn into soft ones",
            fit: FitPart {
                used: 8,
                starts: || vec![vec![0.0; 8]],
                from_edges: true,
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

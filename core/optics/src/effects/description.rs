//! An effect in words, and the facts by which fits, diagnoses and pages treat it.

use serde::Serialize;

use super::{Effect, Parameter};

/// The fixed facts of an effect.
pub struct Description {
    /// The stable identifier used in profiles and reports.
    pub id: &'static str,
    /// Cause and appearance, in a line.
    pub summary: &'static str,
    /// Name in plain words: a noun phrase that starts in lower case.
    pub title: &'static str,
    /// Meaning for the lens or the camera, in one sentence.
    pub meaning: &'static str,
    /// Advice on what to do about it.
    pub action: &'static str,
    /// The parameters, in the order of their values.
    pub parameters: &'static [Parameter],
    /// Whether a lens can gain the effect after its design: a diagnosis then tries it as a cause of a gap. Other effects only
    /// describe lenses.
    pub is_cause: bool,
    /// Whether a diagnosis from pictures tries the effect.
    pub in_pictures: bool,
    /// Whether a lens can have the effect only once, fitted and added effects together.
    pub is_unique: bool,
    /// Places in the field that show the effect.
    pub field_need: FieldNeed,
    /// Whether a fit of the effect includes the shift of the chief ray. That of other fitted effects is part of the magnification and
    /// distortion of the lens.
    pub fits_chief_ray: bool,
    /// Symmetry over the field, of effects for which it does not depend on their values.
    pub symmetry: Symmetry,
    /// Change of the effect in a capture with a quarter of the exposure time.
    pub shorter_exposure: &'static str,
    /// Change so far out of focus that discs show the pupil; `None` if they do not show the effect.
    pub far_out_of_focus: Option<&'static str>,
    /// Change two stops down.
    pub two_stops_down: &'static str,
    /// Change as far on the other side of focus.
    pub other_side_of_focus: &'static str,
    /// Change at another, much nearer distance.
    pub second_distance: &'static str,
    /// Change of the picture of a lamp on a wide dark surround.
    pub dark_surround: &'static str,
    /// Simpler effects that this one can imitate.
    pub contains: &'static [&'static dyn Effect],
    /// The effect that this one equals where all objects have one distance.
    pub one_distance_twin: Option<OneDistanceTwin>,
    /// The effect as a part of fits.
    pub fit: FitPart,
}

impl Description {
    /// Change of an effect that a capture leaves alone.
    pub const UNCHANGED: &'static str = "nothing changes";
    /// Change of defocus with the pupil.
    pub(super) const SHRINKS: &'static str = "the blur shrinks with the pupil";
    /// Change of extra defocus with the side of focus.
    pub(super) const ADDS: &'static str = "discs grow on one side of focus and shrink on the other";

    /// A cause that is alike over the field and that no capture changes, without words and parameters.
    pub(crate) const DEFAULT: Self = Self {
        id: "",
        summary: "",
        title: "",
        meaning: "",
        action: "",
        parameters: &[],
        is_cause: true,
        in_pictures: true,
        is_unique: false,
        field_need: FieldNeed::AnyPlace,
        fits_chief_ray: false,
        symmetry: Symmetry::Round,
        shorter_exposure: Self::UNCHANGED,
        far_out_of_focus: None,
        two_stops_down: Self::UNCHANGED,
        other_side_of_focus: Self::UNCHANGED,
        second_distance: Self::UNCHANGED,
        dark_surround: Self::UNCHANGED,
        contains: &[],
        one_distance_twin: None,
        fit: FitPart::NONE,
    };
}

/// Places in the field that an effect needs to be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldNeed {
    /// Any place: the effect is alike over the field.
    AnyPlace,
    /// Several distances from the axis.
    Radii,
    /// Places on all sides.
    Sides,
}

/// The symmetry of a lens over the field, from the highest to none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Alike at every azimuth, as third-order aberrations are.
    Round,
    /// Mirrored at both axes of the frame.
    TwoPlanes,
    /// None.
    None,
}

/// The effect that looks like another one at a single object distance.
pub struct OneDistanceTwin {
    /// The twin, which acts there on any lens.
    pub effect: &'static dyn Effect,
    /// Index of its parameter that stays neutral.
    pub without: usize,
}

/// An effect as a part of the extended model that fits can add.
pub struct FitPart {
    /// Number of the effect's parameters, from the first, that take part; the others stay neutral. Zero if fits do not use the
    /// effect.
    pub used: usize,
    /// Those of them that stay at their start.
    pub fixed: &'static [usize],
    /// Those of them that another effect describes too: they stay neutral where the lens has that effect.
    pub described_by: &'static [(usize, &'static dyn Effect)],
    /// Whether all channels share them.
    pub shared: bool,
    /// Number of parameters that are at least linear in vergence, the first ones.
    pub linear: usize,
    /// Returns values of the used parameters at which fits start.
    pub starts: fn() -> Vec<Vec<f64>>,
    /// Decrease of the mean log misfit of held-out zones that the part must reach.
    pub worth: f64,
    /// Whether fits to profiles of edges can add the part too.
    pub from_edges: bool,
}

impl FitPart {
    /// No part. Those of fits set their fields on it.
    pub(super) const NONE: Self = Self {
        used: 0,
        fixed: &[],
        described_by: &[],
        shared: false,
        linear: 0,
        starts: Vec::new,
        worth: 0.0,
        from_edges: false,
    };
}

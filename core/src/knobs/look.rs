//! Artistic changes of the lens, and bloom. The number of blades and the picture of the aperture are no knobs of this table:
//! each surface takes them in its own form.

use seidel_optics::profile::{Blades, Look, LookRange};
use seidel_render::Bloom;

use super::kind::{
    HostGroup, HostKnob, Knob, KnobKind, KnobScope, KnobUse, Number, Relation, Unit,
};
use crate::settings::Settings;

const fn host(name: &'static str, label: &'static str) -> Option<HostKnob> {
    Some(HostKnob {
        name,
        label,
        group: HostGroup::Look,
    })
}

/// A number of the look, whose slider spans its range.
const fn number(
    unit: Unit,
    range: LookRange,
    digits: u8,
    get: fn(&Settings) -> Option<f64>,
    set: fn(&mut Settings, Option<f64>),
) -> KnobKind {
    KnobKind::Number(Number {
        unit,
        range: (range.least, range.most),
        default: Some(range.neutral),
        absent: "",
        slider: (range.least, range.most),
        digits,
        get,
        set,
    })
}

fn has_blades(case: &KnobUse) -> bool {
    let blades = case.settings.look.blades;
    case.has_look_of_rays() && blades.is_some_and(|blades| blades.count > 0)
}

pub(super) static KNOBS: &[Knob] = &[
    Knob {
        name: "roundness",
        host: host("roundness", "Roundness"),
        scope: KnobScope::NewBlur,
        help: "Curvature of the iris blades: 0 straight, 1 one circle",
        details: "",
        relation: Relation::Needs("blades"),
        kind: number(
            Unit::Factor,
            Blades::ROUNDNESS,
            2,
            |settings| settings.look.blades.map(|blades| blades.roundness),
            |settings, value| {
                if let Some(blades) = &mut settings.look.blades {
                    blades.roundness = value.unwrap_or(Blades::ROUNDNESS.neutral);
                }
            },
        ),
        has_effect: has_blades,
    },
    Knob {
        name: "rotation",
        host: host("rotation", "Rotation"),
        scope: KnobScope::NewBlur,
        help: "Direction of one corner of discs before the focus, from right towards down",
        details: "Discs behind the focus are turned by 180 degrees.",
        relation: Relation::Needs("blades"),
        kind: number(
            Unit::Degrees,
            Blades::ROTATION_DEG,
            1,
            |settings| settings.look.blades.map(|blades| blades.rotation_deg),
            |settings, value| {
                if let Some(blades) = &mut settings.look.blades {
                    blades.rotation_deg = value.unwrap_or(Blades::ROTATION_DEG.neutral);
                }
            },
        ),
        has_effect: has_blades,
    },
    Knob {
        name: "squeeze",
        host: host("squeeze", "Squeeze"),
        scope: KnobScope::NewBlur,
        help: "Height of discs over their width, times that of the lens: 2 for the ovals of a 2x anamorphic lens",
        details: "",
        relation: Relation::None,
        kind: number(
            Unit::Factor,
            Look::SQUEEZE,
            3,
            |settings| Some(settings.look.squeeze),
            |settings, value| settings.look.squeeze = value.unwrap_or(Look::SQUEEZE.neutral),
        ),
        has_effect: |case| case.has_look_of_rays(),
    },
    Knob {
        name: "obstruction",
        host: host("obstruction", "Obstruction"),
        scope: KnobScope::NewBlur,
        help: "Radius of the dark middle of discs over theirs, as of a mirror lens; 0 as the lens",
        details: "",
        relation: Relation::None,
        kind: number(
            Unit::Factor,
            Look::OBSTRUCTION,
            2,
            |settings| Some(settings.look.obstruction),
            |settings, value| {
                settings.look.obstruction = value.unwrap_or(Look::OBSTRUCTION.neutral)
            },
        ),
        has_effect: |case| case.has_look_of_rays(),
    },
    Knob {
        name: "cats-eye",
        host: host("catsEye", "Cat's Eye"),
        scope: KnobScope::NewBlur,
        help: "Cat's eyes towards the corners: -1 round discs, 0 as the lens, 1 strong ones",
        details: "",
        relation: Relation::None,
        kind: number(
            Unit::Factor,
            Look::CATS_EYE,
            2,
            |settings| Some(settings.look.cats_eye),
            |settings, value| settings.look.cats_eye = value.unwrap_or(Look::CATS_EYE.neutral),
        ),
        has_effect: |case| case.has_look_of_rays(),
    },
    Knob {
        name: "spherical",
        host: host("spherical", "Soft or Bubble"),
        scope: KnobScope::NewBlur,
        help: "Spherical aberration added: -1 soft discs behind the focus, 1 bubbles with bright rims",
        details: "Before the focus it is the other way round.",
        relation: Relation::None,
        kind: number(
            Unit::Factor,
            Look::SPHERICAL,
            2,
            |settings| Some(settings.look.spherical),
            |settings, value| settings.look.spherical = value.unwrap_or(Look::SPHERICAL.neutral),
        ),
        has_effect: |case| case.has_look_of_rays(),
    },
    Knob {
        name: "axial-colour",
        host: host("axialColour", "Axial Colour"),
        scope: KnobScope::NewBlur,
        help: "Factor on the difference of focus between channels: 0 none, 1 as the lens",
        details: "",
        relation: Relation::None,
        kind: number(
            Unit::Factor,
            Look::COLOUR,
            2,
            |settings| Some(settings.look.axial_colour),
            |settings, value| settings.look.axial_colour = value.unwrap_or(Look::COLOUR.neutral),
        ),
        has_effect: |case| case.has_look_of_rays(),
    },
    Knob {
        name: "lateral-colour",
        host: host("lateralColour", "Lateral Colour"),
        scope: KnobScope::NewBlur,
        help: "Factor on the difference of magnification between channels: 0 none, 1 as the lens",
        details: "Without lateral colour in the geometry it has no effect.",
        relation: Relation::None,
        kind: number(
            Unit::Factor,
            Look::COLOUR,
            2,
            |settings| Some(settings.look.lateral_colour),
            |settings, value| settings.look.lateral_colour = value.unwrap_or(Look::COLOUR.neutral),
        ),
        has_effect: |case| case.has_look_of_rays(),
    },
    Knob {
        name: "bloom",
        host: host("bloom", "Bloom"),
        scope: KnobScope::NewBlur,
        help: "Share of the light above the bloom level that spreads around highlights; any lens",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Number(Number {
            unit: Unit::Factor,
            range: (0.0, 1.0),
            default: Some(0.0),
            absent: "",
            slider: (0.0, 1.0),
            digits: 3,
            get: |settings| settings.bloom.map(|bloom| bloom.share),
            set: |settings, value| {
                let share = value.filter(|share| *share != 0.0);
                settings.bloom = share.map(|share| Bloom {
                    share,
                    ..settings.bloom.unwrap_or_default()
                });
            },
        }),
        has_effect: |case| case.has_look(),
    },
    Knob {
        name: "bloom-level",
        host: host("bloomLevel", "Bloom Level"),
        scope: KnobScope::NewBlur,
        help: "Value above which light spreads",
        details: "",
        relation: Relation::Needs("bloom"),
        kind: KnobKind::Number(Number {
            unit: Unit::SceneLinear,
            range: (0.0, f64::MAX),
            default: Some(1.0),
            absent: "",
            slider: (0.0, 10.0),
            digits: 3,
            get: |settings| settings.bloom.map(|bloom| bloom.level),
            set: |settings, value| {
                if let Some(bloom) = &mut settings.bloom {
                    bloom.level = value.unwrap_or(1.0);
                }
            },
        }),
        has_effect: |case| case.has_look() && case.settings.bloom.is_some(),
    },
    Knob {
        name: "bloom-radius",
        host: host("bloomRadius", "Bloom Radius"),
        scope: KnobScope::NewBlur,
        help: "Radius that holds half of the spread light",
        details: "",
        relation: Relation::Needs("bloom"),
        kind: KnobKind::Number(Number {
            unit: Unit::PercentOfFrame,
            range: (100.0 * Bloom::RADII.0, 100.0 * Bloom::RADII.1),
            default: Some(1.0),
            absent: "",
            slider: (100.0 * Bloom::RADII.0, 5.0),
            digits: 2,
            get: |settings| settings.bloom.map(|bloom| 100.0 * bloom.radius),
            set: |settings, value| {
                if let Some(bloom) = &mut settings.bloom {
                    bloom.radius = value.unwrap_or(1.0) / 100.0;
                }
            },
        }),
        has_effect: |case| case.has_look() && case.settings.bloom.is_some(),
    },
];

//! Artistic changes of the lens, and bloom. The number of blades and the picture of the aperture are no knobs of this table:
//! each surface takes them in its own form.

use seidel_optics::profile::{Blades, Look, LookRange};
use seidel_render::Bloom;

use super::kind::{HostGroup, Knob, KnobKind, KnobScope, KnobUse, Number, Relation, Unit};
use crate::settings::Settings;

/// A knob of new blur whose name in hosts and label are `host`.
const fn look(
    name: &'static str,
    host: [&'static str; 2],
    help: &'static str,
    kind: KnobKind,
) -> Knob {
    Knob {
        has_effect: |case| case.has_look_of_rays(),
        ..Knob::new(name, KnobScope::NewBlur, help, kind).in_hosts(HostGroup::Look, host)
    }
}

/// A number whose slider spans its range.
const fn number(
    unit: Unit,
    range: LookRange,
    digits: u8,
    get: fn(&Settings) -> Option<f64>,
    set: fn(&mut Settings, f64),
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

fn has_bloom(case: &KnobUse) -> bool {
    case.has_look() && case.settings.bloom.is_some()
}

pub(super) static KNOBS: &[Knob] = &[
    Knob {
        relation: Relation::Needs("blades"),
        has_effect: has_blades,
        ..look(
            "roundness",
            ["roundness", "Roundness"],
            "Curvature of the iris blades: 0 straight, 1 one circle",
            number(
                Unit::Factor,
                Blades::ROUNDNESS,
                2,
                |settings| settings.look.blades.map(|blades| blades.roundness),
                |settings, value| {
                    if let Some(blades) = &mut settings.look.blades {
                        blades.roundness = value;
                    }
                },
            ),
        )
    },
    Knob {
        details: "Discs behind the focus are turned by 180 degrees.",
        relation: Relation::Needs("blades"),
        has_effect: has_blades,
        ..look(
            "rotation",
            ["rotation", "Rotation"],
            "Direction of one corner of discs before the focus, from right towards down",
            number(
                Unit::Degrees,
                Blades::ROTATION_DEG,
                1,
                |settings| settings.look.blades.map(|blades| blades.rotation_deg),
                |settings, value| {
                    if let Some(blades) = &mut settings.look.blades {
                        blades.rotation_deg = value;
                    }
                },
            ),
        )
    },
    look(
        "squeeze",
        ["squeeze", "Squeeze"],
        "Height of discs over their width, times that of the lens: 2 for the ovals of a 2x anamorphic lens",
        number(
            Unit::Factor,
            Look::SQUEEZE,
            3,
            |settings| Some(settings.look.squeeze),
            |settings, value| settings.look.squeeze = value,
        ),
    ),
    look(
        "obstruction",
        ["obstruction", "Obstruction"],
        "Radius of the dark middle of discs over theirs, as of a mirror lens; 0 as the lens",
        number(
            Unit::Factor,
            Look::OBSTRUCTION,
            2,
            |settings| Some(settings.look.obstruction),
            |settings, value| settings.look.obstruction = value,
        ),
    ),
    look(
        "cats-eye",
        ["catsEye", "Cat's Eye"],
        "Cat's eyes towards the corners: -1 round discs, 0 as the lens, 1 strong ones",
        number(
            Unit::Factor,
            Look::CATS_EYE,
            2,
            |settings| Some(settings.look.cats_eye),
            |settings, value| settings.look.cats_eye = value,
        ),
    ),
    Knob {
        details: "Before the focus it is the other way round.",
        ..look(
            "spherical",
            ["spherical", "Soft or Bubble"],
            "Spherical aberration added: -1 soft discs behind the focus, 1 bubbles with bright rims",
            number(
                Unit::Factor,
                Look::SPHERICAL,
                2,
                |settings| Some(settings.look.spherical),
                |settings, value| settings.look.spherical = value,
            ),
        )
    },
    look(
        "axial-colour",
        ["axialColour", "Axial Colour"],
        "Factor on the difference of focus between channels: 0 none, 1 as the lens",
        number(
            Unit::Factor,
            Look::COLOUR,
            2,
            |settings| Some(settings.look.axial_colour),
            |settings, value| settings.look.axial_colour = value,
        ),
    ),
    Knob {
        details: "Without lateral colour in the geometry it has no effect.",
        ..look(
            "lateral-colour",
            ["lateralColour", "Lateral Colour"],
            "Factor on the difference of magnification between channels: 0 none, 1 as the lens",
            number(
                Unit::Factor,
                Look::COLOUR,
                2,
                |settings| Some(settings.look.lateral_colour),
                |settings, value| settings.look.lateral_colour = value,
            ),
        )
    },
    Knob {
        details: "Needs a lens of known focal length and f-number.",
        ..look(
            "tilt",
            ["tilt", "Tilt"],
            "Tilt of the lens, as of a tilt-shift lens: the plane of focus turns by Scheimpflug's rule",
            number(
                Unit::Degrees,
                Look::TILT_DEG,
                2,
                |settings| Some(settings.look.tilt_deg),
                |settings, value| settings.look.tilt_deg = value,
            ),
        )
    },
    Knob {
        details: "At -90 one strip of the ground is sharp, as in photographs of small models.",
        has_effect: |case| case.has_look_of_rays() && case.settings.look.tilt_deg != 0.0,
        ..look(
            "tilt-direction",
            ["tiltDirection", "Tilt Direction"],
            "Direction in the picture along which the tilted plane of focus comes nearer, from right towards down: 90 lays it along the ground",
            number(
                Unit::Degrees,
                Look::TILT_DIRECTION_DEG,
                1,
                |settings| Some(settings.look.tilt_direction_deg),
                |settings, value| settings.look.tilt_direction_deg = value,
            ),
        )
    },
    Knob {
        has_effect: |case| case.has_look(),
        ..look(
            "bloom",
            ["bloom", "Bloom"],
            "Share of the light above the bloom level that spreads around highlights; any lens",
            KnobKind::Number(Number {
                unit: Unit::Factor,
                range: (0.0, 1.0),
                default: Some(0.0),
                absent: "",
                slider: (0.0, 1.0),
                digits: 3,
                get: |settings| settings.bloom.map(|bloom| bloom.share),
                set: |settings, share| {
                    let bloom = settings.bloom.unwrap_or_default();
                    settings.bloom = (share != 0.0).then_some(Bloom { share, ..bloom });
                },
            }),
        )
    },
    Knob {
        relation: Relation::Needs("bloom"),
        has_effect: has_bloom,
        ..look(
            "bloom-level",
            ["bloomLevel", "Bloom Level"],
            "Value above which light spreads",
            KnobKind::Number(Number {
                unit: Unit::SceneLinear,
                range: (0.0, f64::MAX),
                default: Some(1.0),
                absent: "",
                slider: (0.0, 10.0),
                digits: 3,
                get: |settings| settings.bloom.map(|bloom| bloom.level),
                set: |settings, value| {
                    if let Some(bloom) = &mut settings.bloom {
                        bloom.level = value;
                    }
                },
            }),
        )
    },
    Knob {
        relation: Relation::Needs("bloom"),
        has_effect: has_bloom,
        ..look(
            "bloom-radius",
            ["bloomRadius", "Bloom Radius"],
            "Radius that holds half of the spread light",
            KnobKind::Number(Number {
                unit: Unit::PercentOfFrame,
                range: (100.0 * Bloom::RADII.0, 100.0 * Bloom::RADII.1),
                default: Some(1.0),
                absent: "",
                slider: (100.0 * Bloom::RADII.0, 5.0),
                digits: 2,
                get: |settings| settings.bloom.map(|bloom| 100.0 * bloom.radius),
                set: |settings, value| {
                    if let Some(bloom) = &mut settings.bloom {
                        bloom.radius = value / 100.0;
                    }
                },
            }),
        )
    },
];

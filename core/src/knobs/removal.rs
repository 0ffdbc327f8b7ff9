//! Noise, clipping, strength and grain of a removal.

use seidel_render::remove::Saturation;

use super::choice::{Choice, ChoiceOption, index_in};
use super::kind::{HostGroup, Knob, KnobKind, KnobScope, Mode, Number, Unit};
use crate::settings::Grain;

const GRAINS: [Grain; 2] = [Grain::Keep, Grain::Solved];

/// Index of the option of `clip` that is a level.
const BY_LEVEL: usize = 2;

pub(super) static KNOBS: &[Knob] = &[
    Knob {
        has_effect: |case| case.mode == Mode::Remove,
        ..Knob::new(
            "strength",
            KnobScope::Remove,
            "Weight of the sharp image against the plate: 0 leaves the plate unchanged",
            KnobKind::Number(Number {
                unit: Unit::Factor,
                range: (0.0, 1.0),
                default: Some(1.0),
                absent: "",
                slider: (0.0, 1.0),
                digits: 3,
                get: |settings| Some(settings.removal.strength),
                set: |settings, value| settings.removal.strength = value,
            }),
        )
        .in_hosts(HostGroup::Remove, ["strength", "Strength"])
    },
    Knob {
        has_effect: |case| case.mode == Mode::Remove,
        ..Knob::new(
            "grain",
            KnobScope::Remove,
            "Grain of the sharp image",
            KnobKind::Choice(Choice {
                options: &[
                    ChoiceOption {
                        word: "keep",
                        label: "Keep",
                        help: "The grain of the plate",
                    },
                    ChoiceOption {
                        word: "solved",
                        label: "Solved",
                        help: "That of the solution, which has hardly any",
                    },
                ],
                default: 0,
                get: |settings| index_in(&GRAINS, &settings.removal.grain),
                set: |settings, index| settings.removal.grain = GRAINS[index],
            }),
        )
        .in_hosts(HostGroup::Remove, ["grain", "Grain"])
    },
    Knob {
        has_effect: |case| case.is_removal(),
        ..Knob::new(
            "noise",
            KnobScope::Removal,
            "Standard deviation of the plate's noise: one for all colours, or one for each",
            KnobKind::Number(Number {
                unit: Unit::SceneLinear,
                range: (0.0, f64::MAX),
                default: None,
                absent: "estimated from the plate",
                slider: (0.0, 0.1),
                digits: 5,
                // An invalid value stands for all, so that the check finds it.
                get: |settings| {
                    let noise = &settings.removal.noise;
                    let bad = noise
                        .iter()
                        .find(|noise| !(0.0..=f64::MAX).contains(*noise));
                    bad.or(noise.first()).copied()
                },
                set: |settings, value| settings.removal.noise = vec![value],
            }),
        )
        .in_hosts(HostGroup::Remove, ["noise", "Noise"])
    },
    Knob {
        has_effect: |case| case.is_removal(),
        ..Knob::new(
            "clip",
            KnobScope::Removal,
            "Level from which samples are clipped: they and the pixels that their light reaches keep their blur",
            KnobKind::Choice(Choice {
                options: &[
                    ChoiceOption {
                        word: "auto",
                        label: "Auto",
                        help: "The level is estimated from the plate",
                    },
                    ChoiceOption {
                        word: "none",
                        label: "None",
                        help: "No sample is clipped",
                    },
                    ChoiceOption {
                        word: "level",
                        label: "Level",
                        help: "Samples at or above the clip level are clipped",
                    },
                ],
                default: 0,
                get: |settings| match settings.removal.saturation {
                    Saturation::Auto => 0,
                    Saturation::Never => 1,
                    Saturation::Level(_) => BY_LEVEL,
                },
                set: |settings, index| {
                    settings.removal.saturation = match index {
                        0 => Saturation::Auto,
                        1 => Saturation::Never,
                        _ => Saturation::Level(1.0),
                    };
                },
            }),
        )
        .in_hosts(HostGroup::Remove, ["clip", "Clipping"])
    },
    Knob {
        has_effect: |case| {
            case.is_removal() && matches!(case.settings.removal.saturation, Saturation::Level(_))
        },
        ..Knob::new(
            "clip-level",
            KnobScope::Removal,
            "Level from which samples are clipped, where clipping is by level",
            KnobKind::Number(Number {
                unit: Unit::SceneLinear,
                range: (f64::MIN, f64::MAX),
                default: Some(1.0),
                absent: "",
                slider: (0.5, 4.0),
                digits: 3,
                get: |settings| match settings.removal.saturation {
                    Saturation::Level(level) => Some(level),
                    Saturation::Auto | Saturation::Never => None,
                },
                set: |settings, value| {
                    if let Saturation::Level(level) = &mut settings.removal.saturation {
                        *level = value;
                    }
                },
            }),
        )
        .in_hosts(HostGroup::Remove, ["clipLevel", "Clip Level"])
    },
];

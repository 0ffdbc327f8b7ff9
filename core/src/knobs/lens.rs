//! The lens, its strength and its frame.

use seidel_optics::profile::Controls;
use seidel_render::{Displacement, MAX_AMOUNT};

use super::choice::{Choice, ChoiceOption, index_in};
use super::kind::{HostGroup, HostKnob, Knob, KnobKind, KnobScope, Number, Relation, Unit};
use crate::plate::LensScale;
use crate::settings::Settings;

const fn host(name: &'static str, label: &'static str) -> Option<HostKnob> {
    Some(HostKnob {
        name,
        label,
        group: HostGroup::Lens,
    })
}

/// A control of the lens that stays as measured if it is left out.
const fn control(
    unit: Unit,
    range: (f64, f64),
    slider: (f64, f64),
    digits: u8,
    get: fn(&Settings) -> Option<f64>,
    set: fn(&mut Settings, Option<f64>),
) -> KnobKind {
    KnobKind::Number(Number {
        unit,
        range,
        default: None,
        absent: Controls::AS_MEASURED,
        slider,
        digits,
        get,
        set,
    })
}

const GEOMETRIES: [Displacement; 3] = [
    Displacement::None,
    Displacement::Lateral,
    Displacement::Full,
];

pub(super) static KNOBS: &[Knob] = &[
    Knob {
        name: "amount",
        host: host("amount", "Amount"),
        scope: KnobScope::Plates,
        help: "Strength of the lens's blur and displacement: 0 leaves the plate unchanged, 1 is as measured",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Number(Number {
            unit: Unit::Factor,
            range: (0.0, MAX_AMOUNT),
            default: Some(1.0),
            absent: "",
            slider: (0.0, 2.0),
            digits: 3,
            get: |settings| Some(settings.amount),
            set: |settings, value| settings.amount = value.unwrap_or(1.0),
        }),
        has_effect: |_| true,
    },
    Knob {
        name: "focal-length-mm",
        host: host("focalLength", "Focal Length"),
        scope: KnobScope::Lens,
        help: "Focal length to scale the lens and its frame to; f-number and focus distance stay",
        details: "Blur is that of a lens of this focal length with the measured one's aberrations. For lenses of rays: those of the library, and those fitted by the model reduced or extended.",
        relation: Relation::None,
        kind: control(
            Unit::Millimetres,
            (0.1, 1e4),
            (0.0, 300.0),
            1,
            |settings| settings.controls.focal_length_mm,
            |settings, value| settings.controls.focal_length_mm = value,
        ),
        has_effect: |case| {
            case.has_rays()
                && case.lens_is_none_or(|lens| lens.profile().camera.focal_length_mm.is_some())
        },
    },
    Knob {
        name: "f-number",
        host: host("fStop", "F Stop"),
        scope: KnobScope::Lens,
        help: "F-number to stop the lens down to",
        details: "Below the measured one the blur is extrapolated. For lenses of rays.",
        relation: Relation::None,
        kind: control(
            Unit::FNumber,
            (0.5, 1e4),
            (0.0, 22.0),
            2,
            |settings| settings.controls.f_number,
            |settings, value| settings.controls.f_number = value,
        ),
        has_effect: |case| {
            case.has_rays() && case.lens_is_none_or(|lens| lens.profile().camera.f_number.is_some())
        },
    },
    Knob {
        name: "sensor-shift-um",
        host: host("sensorShift", "Sensor Shift"),
        scope: KnobScope::Lens,
        help: "Shift of the sensor away from the lens; negative towards it",
        details: "For lenses of rays.",
        relation: Relation::None,
        kind: control(
            Unit::Micrometres,
            (-1e5, 1e5),
            (-200.0, 200.0),
            1,
            |settings| settings.controls.sensor_shift_um,
            |settings, value| settings.controls.sensor_shift_um = value,
        ),
        has_effect: |case| case.has_rays(),
    },
    Knob {
        name: "geometry",
        host: host("geometry", "Geometry"),
        scope: KnobScope::Plates,
        help: "Displacement of light by the lens",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Choice(Choice {
            options: &[
                ChoiceOption {
                    word: "none",
                    label: "None",
                    help: "Blur alone: each kernel has its centroid on its source pixel",
                },
                ChoiceOption {
                    word: "lateral",
                    label: "Lateral",
                    help: "Lateral colour: channels are displaced against each other, the plate is not distorted",
                },
                ChoiceOption {
                    word: "full",
                    label: "Full",
                    help: "Distortion and lateral colour",
                },
            ],
            default: 1,
            get: |settings| index_in(&GEOMETRIES, &settings.displacement),
            set: |settings, index| settings.displacement = GEOMETRIES[index],
        }),
        has_effect: |_| true,
    },
    Knob {
        name: "lens-scale",
        host: host("lensScale", "Lens Scale"),
        scope: KnobScope::Plates,
        help: "Scale of the lens's frame on the plate, along y",
        details: "",
        relation: Relation::None,
        kind: KnobKind::Number(Number {
            unit: Unit::PlateScale,
            range: (1e-4, 1e4),
            default: None,
            absent: "from the display window",
            slider: (0.0, 4.0),
            digits: 4,
            get: |settings| match settings.lens_scale {
                LensScale::PixelRatio(ratio) => Some(ratio),
                LensScale::FrameWidth | LensScale::FilmBack(_) => None,
            },
            set: |settings, value| {
                settings.lens_scale = value.map(LensScale::PixelRatio).unwrap_or_default();
            },
        }),
        has_effect: |case| !matches!(case.settings.lens_scale, LensScale::FilmBack(_)),
    },
    Knob {
        name: "film-back-mm",
        host: host("filmBack", "Film Back"),
        scope: KnobScope::Plates,
        help: "Width of the sensor that the display window shows (film back), instead of the lens scale: a smaller sensor crops the lens's frame",
        details: "Common widths: 36 for full frame, 24.9 for Super 35, 12.5 for Super 16. The lens profile must have a pixel pitch. Beyond the frame of the lens its blur is extrapolated.",
        relation: Relation::Replaces("lens-scale"),
        kind: KnobKind::Number(Number {
            unit: Unit::Millimetres,
            range: (1e-4, 1e4),
            default: None,
            absent: "by the lens scale",
            slider: (0.0, 70.0),
            digits: 2,
            get: |settings| match settings.lens_scale {
                LensScale::FilmBack(width_mm) => Some(width_mm),
                LensScale::FrameWidth | LensScale::PixelRatio(_) => None,
            },
            set: |settings, value| {
                if let Some(width_mm) = value {
                    settings.lens_scale = LensScale::FilmBack(width_mm);
                }
            },
        }),
        has_effect: |case| case.lens_is_none_or(|lens| lens.profile().pixel_pitch_um.is_some()),
    },
];

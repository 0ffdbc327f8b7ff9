//! The lens, its strength and its frame.

use seidel_optics::profile::Controls;
use seidel_render::{Displacement, MAX_AMOUNT};

use super::choice::{Choice, ChoiceOption, index_in};
use super::kind::{HostGroup, Knob, KnobKind, KnobScope, Number, Relation, Unit};
use crate::plate::LensScale;
use crate::settings::Settings;

/// Unit and range of a control of the lens.
pub(super) struct Control {
    pub(super) unit: Unit,
    pub(super) range: (f64, f64),
    pub(super) slider: (f64, f64),
    pub(super) digits: u8,
}

pub(super) const FOCAL_LENGTH: Control = Control {
    unit: Unit::Millimetres,
    range: (0.1, 1e4),
    slider: (0.0, 300.0),
    digits: 1,
};

pub(super) const F_NUMBER: Control = Control {
    unit: Unit::FNumber,
    range: (0.5, 1e4),
    slider: (0.0, 22.0),
    digits: 2,
};

pub(super) const SENSOR_SHIFT: Control = Control {
    unit: Unit::Micrometres,
    range: (-1e5, 1e5),
    slider: (-200.0, 200.0),
    digits: 1,
};

impl Control {
    /// The knob of a control, which has the value `absent` in words if it is left out.
    pub(super) const fn knob(
        self,
        absent: &'static str,
        get: fn(&Settings) -> Option<f64>,
        set: fn(&mut Settings, f64),
    ) -> KnobKind {
        KnobKind::Number(Number {
            unit: self.unit,
            range: self.range,
            default: None,
            absent,
            slider: self.slider,
            digits: self.digits,
            get,
            set,
        })
    }
}

const GEOMETRIES: [Displacement; 3] = [
    Displacement::None,
    Displacement::Lateral,
    Displacement::Full,
];

pub(super) static KNOBS: &[Knob] = &[
    Knob::new(
        "amount",
        KnobScope::Plates,
        "Strength of the lens's blur and displacement: 0 leaves the plate unchanged, 1 is as measured",
        KnobKind::Number(Number {
            unit: Unit::Factor,
            range: (0.0, MAX_AMOUNT),
            default: Some(1.0),
            absent: "",
            slider: (0.0, 2.0),
            digits: 3,
            get: |settings| Some(settings.amount),
            set: |settings, value| settings.amount = value,
        }),
    )
    .in_hosts(HostGroup::Lens, ["amount", "Amount"]),
    Knob {
        details: "Blur is that of a lens of this focal length with the measured one's aberrations. For lenses of rays: those of the library, and those fitted by the model reduced or extended.",
        has_effect: |case| {
            case.has_rays()
                && case.lens_is_none_or(|lens| lens.profile().camera.focal_length_mm.is_some())
        },
        ..Knob::new(
            "focal-length-mm",
            KnobScope::Lens,
            "Focal length to scale the lens and its frame to; f-number and focus distance stay",
            FOCAL_LENGTH.knob(
                Controls::AS_MEASURED,
                |settings| settings.controls.focal_length_mm,
                |settings, value| settings.controls.focal_length_mm = Some(value),
            ),
        )
        .in_hosts(HostGroup::Lens, ["focalLength", "Focal Length"])
    },
    Knob {
        details: "Below the measured one the blur is extrapolated. For lenses of rays.",
        has_effect: |case| {
            case.has_rays() && case.lens_is_none_or(|lens| lens.profile().camera.f_number.is_some())
        },
        ..Knob::new(
            "f-number",
            KnobScope::Lens,
            "F-number to stop the lens down to",
            F_NUMBER.knob(
                Controls::AS_MEASURED,
                |settings| settings.controls.f_number,
                |settings, value| settings.controls.f_number = Some(value),
            ),
        )
        .in_hosts(HostGroup::Lens, ["fStop", "F Stop"])
    },
    Knob {
        details: "For lenses of rays.",
        has_effect: |case| case.has_rays(),
        ..Knob::new(
            "sensor-shift-um",
            KnobScope::Lens,
            "Shift of the sensor away from the lens; negative towards it",
            SENSOR_SHIFT.knob(
                Controls::AS_MEASURED,
                |settings| settings.controls.sensor_shift_um,
                |settings, value| settings.controls.sensor_shift_um = Some(value),
            ),
        )
        .in_hosts(HostGroup::Lens, ["sensorShift", "Sensor Shift"])
    },
    Knob::new(
        "geometry",
        KnobScope::Plates,
        "Displacement of light by the lens",
        KnobKind::Choice(Choice {
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
    )
    .in_hosts(HostGroup::Lens, ["geometry", "Geometry"]),
    Knob {
        has_effect: |case| !matches!(case.settings.lens_scale, LensScale::FilmBack(_)),
        ..Knob::new(
            "lens-scale",
            KnobScope::Plates,
            "Scale of the lens's frame on the plate, along y",
            KnobKind::Number(Number {
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
                set: |settings, value| settings.lens_scale = LensScale::PixelRatio(value),
            }),
        )
        .in_hosts(HostGroup::Lens, ["lensScale", "Lens Scale"])
    },
    Knob {
        details: "Common widths: 36 for full frame, 24.9 for Super 35, 12.5 for Super 16. The lens profile must have a pixel pitch. Beyond the frame of the lens its blur is extrapolated.",
        relation: Relation::Replaces("lens-scale"),
        has_effect: |case| case.lens_is_none_or(|lens| lens.profile().pixel_pitch_um.is_some()),
        ..Knob::new(
            "film-back-mm",
            KnobScope::Plates,
            "Width of the sensor that the display window shows (film back), instead of the lens scale: a smaller sensor crops the lens's frame",
            KnobKind::Number(Number {
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
                set: |settings, value| settings.lens_scale = LensScale::FilmBack(value),
            }),
        )
        .in_hosts(HostGroup::Lens, ["filmBack", "Film Back"])
    },
];

//! Controls of one of the two lenses of `relens`, where they differ from those of both.

use seidel_optics::distance::ObjectDistance;

use super::focus::{FOCUS_DISTANCE, metres};
use super::kind::{HostGroup, Knob, KnobKind, KnobScope, KnobUse, Mode};
use super::lens::{F_NUMBER, FOCAL_LENGTH, SENSOR_SHIFT};
use crate::lens::Lens;

/// A control that is left out, in words.
const AS_BOTH: &str = "that of both lenses";

fn is_set(case: &KnobUse, lens: Option<&Lens>) -> bool {
    case.mode == Mode::Relens && lens.is_none_or(|lens| lens.predictor().has_rays())
}

fn of_from(case: &KnobUse) -> bool {
    is_set(case, case.lens)
}

fn of_to(case: &KnobUse) -> bool {
    is_set(case, case.look_lens)
}

const fn row(
    name: &'static str,
    host: [&'static str; 2],
    help: &'static str,
    kind: KnobKind,
    has_effect: fn(&KnobUse) -> bool,
) -> Knob {
    Knob {
        has_effect,
        ..Knob::new(name, KnobScope::Relens, help, kind)
    }
    .in_hosts(HostGroup::Relens, host)
}

pub(super) static KNOBS: &[Knob] = &[
    row(
        "from-focal-length-mm",
        ["fromFocalLength", "From Focal Length"],
        "Focal length of the lens that the plate was taken with",
        FOCAL_LENGTH.knob(
            AS_BOTH,
            |settings| settings.from_controls.focal_length_mm,
            |settings, value| settings.from_controls.focal_length_mm = Some(value),
        ),
        of_from,
    ),
    row(
        "from-f-number",
        ["fromFStop", "From F Stop"],
        "F-number of the lens that the plate was taken with",
        F_NUMBER.knob(
            AS_BOTH,
            |settings| settings.from_controls.f_number,
            |settings, value| settings.from_controls.f_number = Some(value),
        ),
        of_from,
    ),
    row(
        "from-sensor-shift-um",
        ["fromSensorShift", "From Sensor Shift"],
        "Shift of the sensor of the lens that the plate was taken with",
        SENSOR_SHIFT.knob(
            AS_BOTH,
            |settings| settings.from_controls.sensor_shift_um,
            |settings, value| settings.from_controls.sensor_shift_um = Some(value),
        ),
        of_from,
    ),
    row(
        "from-focus-distance",
        ["fromFocusDistance", "From Focus Distance"],
        "Focus distance of the lens that the plate was taken with",
        FOCUS_DISTANCE.knob(
            AS_BOTH,
            |settings| settings.from_controls.focus_distance.and_then(metres),
            |settings, value| {
                settings.from_controls.focus_distance = ObjectDistance::metres(value).ok()
            },
        ),
        of_from,
    ),
    row(
        "to-focal-length-mm",
        ["toFocalLength", "To Focal Length"],
        "Focal length of the lens whose blur the plate gets",
        FOCAL_LENGTH.knob(
            AS_BOTH,
            |settings| settings.to_controls.focal_length_mm,
            |settings, value| settings.to_controls.focal_length_mm = Some(value),
        ),
        of_to,
    ),
    row(
        "to-f-number",
        ["toFStop", "To F Stop"],
        "F-number of the lens whose blur the plate gets",
        F_NUMBER.knob(
            AS_BOTH,
            |settings| settings.to_controls.f_number,
            |settings, value| settings.to_controls.f_number = Some(value),
        ),
        of_to,
    ),
    row(
        "to-sensor-shift-um",
        ["toSensorShift", "To Sensor Shift"],
        "Shift of the sensor of the lens whose blur the plate gets",
        SENSOR_SHIFT.knob(
            AS_BOTH,
            |settings| settings.to_controls.sensor_shift_um,
            |settings, value| settings.to_controls.sensor_shift_um = Some(value),
        ),
        of_to,
    ),
    row(
        "to-focus-distance",
        ["toFocusDistance", "To Focus Distance"],
        "Focus distance of the lens whose blur the plate gets",
        FOCUS_DISTANCE.knob(
            AS_BOTH,
            |settings| settings.to_controls.focus_distance.and_then(metres),
            |settings, value| {
                settings.to_controls.focus_distance = ObjectDistance::metres(value).ok()
            },
        ),
        of_to,
    ),
];

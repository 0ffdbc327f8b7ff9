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

/// The four rows of one side: the field of its controls, its word in names and in labels, what its
/// lens is, and when it has an effect.
macro_rules! rows {
    ($controls:ident, $side:literal, $label:literal, $lens:literal, $has_effect:ident) => {
        [
            row(
                concat!($side, "-focal-length-mm"),
                [
                    concat!($side, "FocalLength"),
                    concat!($label, " Focal Length"),
                ],
                concat!("Focal length of the lens ", $lens),
                FOCAL_LENGTH.knob(
                    AS_BOTH,
                    |settings| settings.$controls.focal_length_mm,
                    |settings, value| settings.$controls.focal_length_mm = Some(value),
                ),
                $has_effect,
            ),
            row(
                concat!($side, "-f-number"),
                [concat!($side, "FStop"), concat!($label, " F Stop")],
                concat!("F-number of the lens ", $lens),
                F_NUMBER.knob(
                    AS_BOTH,
                    |settings| settings.$controls.f_number,
                    |settings, value| settings.$controls.f_number = Some(value),
                ),
                $has_effect,
            ),
            row(
                concat!($side, "-sensor-shift-um"),
                [
                    concat!($side, "SensorShift"),
                    concat!($label, " Sensor Shift"),
                ],
                concat!("Shift of the sensor of the lens ", $lens),
                SENSOR_SHIFT.knob(
                    AS_BOTH,
                    |settings| settings.$controls.sensor_shift_um,
                    |settings, value| settings.$controls.sensor_shift_um = Some(value),
                ),
                $has_effect,
            ),
            row(
                concat!($side, "-focus-distance"),
                [
                    concat!($side, "FocusDistance"),
                    concat!($label, " Focus Distance"),
                ],
                concat!("Focus distance of the lens ", $lens),
                FOCUS_DISTANCE.knob(
                    AS_BOTH,
                    |settings| settings.$controls.focus_distance.and_then(metres),
                    |settings, value| {
                        settings.$controls.focus_distance = ObjectDistance::metres(value).ok()
                    },
                ),
                $has_effect,
            ),
        ]
    };
}

pub(super) static FROM: &[Knob] = &rows!(
    from_controls,
    "from",
    "From",
    "that the plate was taken with",
    of_from
);

pub(super) static TO: &[Knob] = &rows!(to_controls, "to", "To", "whose blur the plate gets", of_to);

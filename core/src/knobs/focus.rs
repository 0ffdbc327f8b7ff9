//! The distance in focus, and the growth of blur before and behind it.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::profile::Controls;
use seidel_render::MAX_MULTIPLIER;

use super::kind::{HostGroup, Knob, KnobKind, KnobScope, Number, Unit};
use super::lens::Control;
use crate::settings::Settings;

pub(super) const FOCUS_DISTANCE: Control = Control {
    unit: Unit::Distance,
    range: (f64::MIN_POSITIVE, f64::INFINITY),
    slider: (0.1, 20.0),
    digits: 3,
};

/// A factor on the growth of blur on one side of the focus plane.
const fn multiplier(get: fn(&Settings) -> Option<f64>, set: fn(&mut Settings, f64)) -> KnobKind {
    KnobKind::Number(Number {
        unit: Unit::Factor,
        range: (0.0, MAX_MULTIPLIER),
        default: Some(1.0),
        absent: "",
        slider: (0.0, 2.0),
        digits: 3,
        get,
        set,
    })
}

pub(super) static KNOBS: &[Knob] = &[
    Knob {
        details: "For lenses of rays: those of the library, and those fitted by the model reduced or extended.",
        has_effect: |case| case.has_rays(),
        ..Knob::new(
            "focus-distance",
            KnobScope::Lens,
            "Distance to focus the lens on",
            FOCUS_DISTANCE.knob(
                Controls::AS_MEASURED,
                |settings| settings.controls.focus_distance.and_then(metres),
                |settings, value| settings.controls.focus_distance = ObjectDistance::metres(value).ok(),
            ),
        )
    },
    Knob {
        details: "Beyond the range, depth is measured from its nearer end.",
        ..Knob::new(
            "depth-of-field",
            KnobScope::Plates,
            "Depth of the range that is as sharp as the focus plane, half of it on each side",
            KnobKind::Number(Number {
                unit: Unit::Metres,
                range: (0.0, 1e6),
                default: Some(0.0),
                absent: "",
                slider: (0.0, 10.0),
                digits: 3,
                get: |settings| Some(settings.focus.depth_of_field_m),
                set: |settings, value| settings.focus.depth_of_field_m = value,
            }),
        )
        .in_hosts(HostGroup::Focus, ["dof", "Depth of Field"])
    },
    Knob::new(
        "front-multiplier",
        KnobScope::Plates,
        "Factor on the distance from focus, in vergence, in front of the focus plane: blur grows as many times as fast",
        multiplier(
            |settings| Some(settings.focus.front),
            |settings, value| settings.focus.front = value,
        ),
    )
    .in_hosts(HostGroup::Focus, ["front", "Front Multiplier"]),
    Knob::new(
        "back-multiplier",
        KnobScope::Plates,
        "Factor on the distance from focus, in vergence, behind the focus plane",
        multiplier(
            |settings| Some(settings.focus.back),
            |settings, value| settings.focus.back = value,
        ),
    )
    .in_hosts(HostGroup::Focus, ["back", "Back Multiplier"]),
    Knob {
        details: "For other kernels it is two standard deviations. A larger kernel is replaced by that of the distance at which it has this radius.",
        ..Knob::new(
            "maximum-size",
            KnobScope::Plates,
            "Radius of the largest kernel in the frame: that of a uniform disc",
            KnobKind::Number(Number {
                unit: Unit::PlatePixels,
                range: (f64::MIN_POSITIVE, 1e6),
                default: None,
                absent: "none",
                slider: (0.0, 256.0),
                digits: 1,
                get: |settings| settings.focus.maximum_px,
                set: |settings, value| settings.focus.maximum_px = Some(value),
            }),
        )
        .in_hosts(HostGroup::Focus, ["maxSize", "Maximum"])
    },
];

/// Returns a known distance in metres.
pub(super) fn metres(distance: ObjectDistance) -> Option<f64> {
    match distance {
        ObjectDistance::Unknown => None,
        ObjectDistance::Infinity => Some(f64::INFINITY),
        ObjectDistance::Metres(metres) => Some(metres),
    }
}

//! The distance in focus, and the growth of blur before and behind it.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::profile::Controls;
use seidel_render::MAX_MULTIPLIER;

use super::kind::{HostGroup, HostKnob, Knob, KnobKind, KnobScope, Number, Relation, Unit};
use crate::settings::Settings;

const fn host(name: &'static str, label: &'static str) -> Option<HostKnob> {
    Some(HostKnob {
        name,
        label,
        group: HostGroup::Focus,
    })
}

/// A factor on the growth of blur on one side of the focus plane.
const fn multiplier(
    get: fn(&Settings) -> Option<f64>,
    set: fn(&mut Settings, Option<f64>),
) -> KnobKind {
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
        name: "focus-distance",
        // The node sets it by a menu: as measured, a distance, or a value of the depth pass.
        host: None,
        scope: KnobScope::Lens,
        help: "Distance to focus the lens on",
        details: "For lenses of rays: those of the library, and those fitted by the model reduced or extended.",
        relation: Relation::None,
        kind: KnobKind::Number(Number {
            unit: Unit::Distance,
            range: (f64::MIN_POSITIVE, f64::INFINITY),
            default: None,
            absent: Controls::AS_MEASURED,
            slider: (0.1, 20.0),
            digits: 3,
            get: |settings| settings.controls.focus_distance.and_then(metres),
            set: |settings, value| {
                let distance = value.map(ObjectDistance::metres);
                settings.controls.focus_distance = distance.and_then(Result::ok);
            },
        }),
        has_effect: |case| case.has_rays(),
    },
    Knob {
        name: "depth-of-field",
        host: host("dof", "Depth of Field"),
        scope: KnobScope::Plates,
        help: "Depth of the range that is as sharp as the focus plane, half of it on each side",
        details: "Beyond the range, depth is measured from its nearer end.",
        relation: Relation::None,
        kind: KnobKind::Number(Number {
            unit: Unit::Metres,
            range: (0.0, 1e6),
            default: Some(0.0),
            absent: "",
            slider: (0.0, 10.0),
            digits: 3,
            get: |settings| Some(settings.focus.depth_of_field_m),
            set: |settings, value| settings.focus.depth_of_field_m = value.unwrap_or(0.0),
        }),
        has_effect: |_| true,
    },
    Knob {
        name: "front-multiplier",
        host: host("front", "Front Multiplier"),
        scope: KnobScope::Plates,
        help: "Factor on the distance from focus, in vergence, in front of the focus plane: blur grows as many times as fast",
        details: "",
        relation: Relation::None,
        kind: multiplier(
            |settings| Some(settings.focus.front),
            |settings, value| settings.focus.front = value.unwrap_or(1.0),
        ),
        has_effect: |_| true,
    },
    Knob {
        name: "back-multiplier",
        host: host("back", "Back Multiplier"),
        scope: KnobScope::Plates,
        help: "Factor on the distance from focus, in vergence, behind the focus plane",
        details: "",
        relation: Relation::None,
        kind: multiplier(
            |settings| Some(settings.focus.back),
            |settings, value| settings.focus.back = value.unwrap_or(1.0),
        ),
        has_effect: |_| true,
    },
    Knob {
        name: "maximum-size",
        host: host("maxSize", "Maximum"),
        scope: KnobScope::Plates,
        help: "Radius of the largest kernel in the frame: that of a uniform disc",
        details: "For other kernels it is two standard deviations. A larger kernel is replaced by that of the distance at which it has this radius.",
        relation: Relation::None,
        kind: KnobKind::Number(Number {
            unit: Unit::PlatePixels,
            range: (f64::MIN_POSITIVE, 1e6),
            default: None,
            absent: "none",
            slider: (0.0, 256.0),
            digits: 1,
            get: |settings| settings.focus.maximum_px,
            set: |settings, value| settings.focus.maximum_px = value,
        }),
        has_effect: |_| true,
    },
];

/// Returns a known distance in metres.
fn metres(distance: ObjectDistance) -> Option<f64> {
    match distance {
        ObjectDistance::Unknown => None,
        ObjectDistance::Infinity => Some(f64::INFINITY),
        ObjectDistance::Metres(metres) => Some(metres),
    }
}

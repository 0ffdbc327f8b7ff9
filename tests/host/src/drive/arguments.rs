//! The property sets that actions are given and fill in.

use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::frame::Request;
use crate::host::Host;
use crate::host::properties::{PropertySet, Value, Values};
use crate::picture::{Rect, Region};

/// Properties by name, put together.
#[derive(Default)]
pub(super) struct Arguments {
    values: Values,
}

impl Arguments {
    pub(super) fn ints(self, name: &CStr, list: &[i32]) -> Self {
        self.with(name, list.iter().map(|v| Value::Int(*v)).collect())
    }

    pub(super) fn doubles(self, name: &CStr, list: &[f64]) -> Self {
        self.with(name, list.iter().map(|v| Value::Double(*v)).collect())
    }

    pub(super) fn text(self, name: &CStr, text: &CStr) -> Self {
        self.with(name, vec![Value::Text(text.to_owned())])
    }

    pub(super) fn with(mut self, name: &CStr, values: Vec<Value>) -> Self {
        let name = name.to_string_lossy().into_owned();
        self.values.insert(name, values);
        self
    }

    /// With a property that carries the name of a clip.
    pub(super) fn of_clip(mut self, start: &str, clip: &str, values: Vec<Value>) -> Self {
        self.values.insert(format!("{start}{clip}"), values);
        self
    }

    /// Made known to the plugin, as what goes into or comes out of an action.
    pub(super) fn known(self, host: &Host, out: bool, action: &CStr) -> Arc<PropertySet> {
        let way = if out { "outArgs" } else { "inArgs" };
        let name = format!("{way} of {}", action.to_string_lossy());
        host.property_set(&name, &name, self.values, false)
    }
}

/// What actions about a time and a scale get.
pub(super) fn at(time: f64, scale: (f64, f64)) -> Arguments {
    Arguments::default()
        .doubles(kOfxPropTime, &[time])
        .doubles(kOfxImageEffectPropRenderScale, &[scale.0, scale.1])
}

/// What a render gets, and with a window of its own each of its tiles.
pub(super) fn of_render(host: &Host, request: &Request, window: Rect) -> Arguments {
    let mut arguments = at(request.time, request.scale)
        .text(kOfxImageEffectPropFieldToRender, request.field)
        .ints(kOfxImageEffectPropRenderWindow, &window.corners())
        .ints(kOfxImageEffectPropSequentialRenderStatus, &[0])
        .ints(kOfxImageEffectPropInteractiveRenderStatus, &[0])
        .ints(kOfxImageEffectPropRenderQualityDraft, &[0]);
    if host.profile.api >= (1, 5) {
        arguments = arguments.text(kOfxImageEffectPropThumbnailRender, c"false");
    }
    arguments
}

/// What the begin and the end of a sequence get.
pub(super) fn of_sequence(request: &Request) -> Arguments {
    Arguments::default()
        .doubles(kOfxImageEffectPropFrameRange, &[request.time, request.time])
        .doubles(kOfxImageEffectPropFrameStep, &[1.0])
        .ints(kOfxPropIsInteractive, &[0])
        .doubles(
            kOfxImageEffectPropRenderScale,
            &[request.scale.0, request.scale.1],
        )
        .ints(kOfxImageEffectPropSequentialRenderStatus, &[0])
        .ints(kOfxImageEffectPropInteractiveRenderStatus, &[0])
}

/// The rectangle in a property, nothing if it does not hold four numbers.
pub(super) fn region(values: Option<&Vec<Value>>) -> Option<Region> {
    let numbers: Vec<f64> = values?
        .iter()
        .filter_map(|value| match value {
            Value::Double(v) => Some(*v),
            _ => None,
        })
        .collect();
    match numbers[..] {
        [x1, y1, x2, y2] => Some(Region::new(x1, y1, x2, y2)),
        _ => None,
    }
}

//! Property sets for the arguments of actions.

use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::frame::RenderRequest;
use crate::host::Host;
use crate::host::properties::{PropertySet, Schema, Value, Values, property_name};
use crate::picture::{Rect, Region};

/// A builder of argument sets.
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
        self.values.insert(property_name(name), values);
        self
    }

    /// Adds a property whose name ends with that of a clip.
    pub(super) fn for_clip(mut self, prefix: &str, clip: &str, values: Vec<Value>) -> Self {
        self.values.insert(format!("{prefix}{clip}"), values);
        self
    }

    /// Creates the `inArgs` of an action.
    pub(super) fn in_args(self, host: &Host, action: &CStr) -> Arc<PropertySet> {
        self.register(host, "inArgs", action)
    }

    /// Creates the `outArgs` of an action.
    pub(super) fn out_args(self, host: &Host, action: &CStr) -> Arc<PropertySet> {
        self.register(host, "outArgs", action)
    }

    fn register(self, host: &Host, kind: &str, action: &CStr) -> Arc<PropertySet> {
        let name = format!("{kind} of {}", action.to_string_lossy());
        host.property_set(&name, &name, self.values, Schema::Fixed)
    }
}

/// Returns the arguments of actions at a time and render scale.
pub(super) fn at_time(time: f64, scale: (f64, f64)) -> Arguments {
    Arguments::default()
        .doubles(kOfxPropTime, &[time])
        .doubles(kOfxImageEffectPropRenderScale, &[scale.0, scale.1])
}

/// Returns the arguments of Render.
pub(super) fn for_render(host: &Host, request: &RenderRequest, window: Rect) -> Arguments {
    let mut arguments = at_time(request.time, request.scale)
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

/// Returns the arguments of BeginSequenceRender and EndSequenceRender.
pub(super) fn for_sequence(request: &RenderRequest) -> Arguments {
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

/// Converts the values of a property to a region, if they are four doubles.
pub(super) fn to_region(values: Option<&Vec<Value>>) -> Option<Region> {
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

//! Describe and DescribeInContext.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::Call;
use crate::api::PropertySet;
use crate::faults::Fault;

pub(super) fn describe(call: &Call<'_>) -> OfxStatus {
    let Some(set) = call.effect.properties() else {
        return kOfxStatErrBadHandle;
    };
    if call.fault != Fault::NoLabel {
        set.set_strings(kOfxPropLabel, &[c"Box"]);
    }
    set.set_strings(kOfxImageEffectPluginPropGrouping, &[c"Filter"]);
    set.set_strings(
        kOfxImageEffectPropSupportedContexts,
        &[kOfxImageEffectContextFilter, kOfxImageEffectContextGeneral],
    );
    let depths = [
        (kOfxBitDepthFloat, call.fault.takes_floats()),
        (kOfxBitDepthByte, call.fault.takes_bytes()),
    ];
    let depths = depths.into_iter().filter(|(_, taken)| *taken);
    let depths: Vec<_> = depths.map(|(depth, _)| depth).collect();
    set.set_strings(kOfxImageEffectPropSupportedPixelDepths, &depths);
    set.set_strings(
        kOfxImageEffectPluginRenderThreadSafety,
        &[kOfxImageEffectRenderFullySafe],
    );
    set.set_int(kOfxImageEffectPluginPropHostFrameThreading, 0);
    set.set_int(kOfxImageEffectPropSupportsMultiResolution, 1);
    set.set_int(kOfxImageEffectPropSupportsTiles, 1);
    set.set_int(kOfxImageEffectPluginPropFieldRenderTwiceAlways, 1);
    kOfxStatOK
}

pub(super) fn describe_in_context(call: &Call<'_>) -> OfxStatus {
    let Some(define) = call.effect.suites.effect.clipDefine else {
        return kOfxStatErrMissingHostFeature;
    };
    if call.effect.handle.is_null() {
        return kOfxStatErrBadHandle;
    }
    let components = [
        kOfxImageComponentRGBA,
        kOfxImageComponentRGB,
        kOfxImageComponentAlpha,
    ];
    for (name, optional) in [(c"Source", 0), (c"Depth", 1), (c"Mask", 1), (c"Output", 0)] {
        let mut handle = std::ptr::null_mut();
        // SAFETY: memory for a handle.
        let status = unsafe { define(call.effect.handle, name.as_ptr(), &raw mut handle) };
        if status != kOfxStatOK {
            return status;
        }
        let set = PropertySet {
            suites: call.effect.suites,
            handle,
        };
        let supported = if name == c"Mask" {
            &components[2..]
        } else {
            &components[..]
        };
        set.set_strings(kOfxImageEffectPropSupportedComponents, supported);
        set.set_int(kOfxImageClipPropOptional, optional);
        set.set_int(kOfxImageEffectPropSupportsTiles, 1);
    }
    let default_size = if call.fault == Fault::BadDefault {
        -1.0
    } else {
        3.0
    };
    define_double(call, c"size", c"", default_size, 100.0);
    define_parameter(call, kOfxParamTypeGroup, c"blend");
    define_double(call, c"mix", c"blend", 1.0, 1.0);
    for name in [c"useDepth", c"useMask"] {
        define_parameter(call, kOfxParamTypeBoolean, name);
    }
    if let Some(set) = define_parameter(call, kOfxParamTypeString, c"file") {
        set.set_strings(kOfxParamPropStringMode, &[kOfxParamStringIsFilePath]);
        set.set_int(kOfxParamPropAnimates, 0);
    }
    if let Some(set) = define_parameter(call, kOfxParamTypePage, c"Controls") {
        let mut children = vec![c"size", c"blend", c"mix", c"useDepth", c"useMask", c"file"];
        children.retain(|name| call.fault != Fault::UnlistedGroup || *name != c"blend");
        set.set_strings(kOfxParamPropPageChild, &children);
    }
    kOfxStatOK
}

fn define_parameter<'a>(call: &Call<'a>, kind: &CStr, name: &CStr) -> Option<PropertySet<'a>> {
    let define = call.effect.suites.parameter.paramDefine?;
    let parameters = call.effect.parameters()?;
    let mut handle = std::ptr::null_mut();
    // SAFETY: memory for a handle.
    let status = unsafe { define(parameters, kind.as_ptr(), name.as_ptr(), &raw mut handle) };
    (status == kOfxStatOK).then_some(PropertySet {
        suites: call.effect.suites,
        handle,
    })
}

/// Defines a double parameter with a range from 0 to `max`, in the group `parent` if it is not empty.
fn define_double(call: &Call<'_>, name: &CStr, parent: &CStr, default: f64, max: f64) {
    if let Some(set) = define_parameter(call, kOfxParamTypeDouble, name) {
        set.set_strings(kOfxPropLabel, &[name]);
        set.set_strings(kOfxParamPropParent, &[parent]);
        set.set_doubles(kOfxParamPropDefault, &[default]);
        for property in [kOfxParamPropMin, kOfxParamPropDisplayMin] {
            set.set_doubles(property, &[0.0]);
        }
        for property in [kOfxParamPropMax, kOfxParamPropDisplayMax] {
            set.set_doubles(property, &[max]);
        }
    }
}

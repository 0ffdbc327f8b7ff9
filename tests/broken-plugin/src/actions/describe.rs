//! What the plugin is.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::Call;
use crate::api::Set;
use crate::faults::Fault;

pub(super) fn describe(call: &Call<'_>) -> OfxStatus {
    let Some(set) = call.effect.set() else {
        return kOfxStatErrBadHandle;
    };
    if call.fault != Fault::NoLabel {
        set.set_texts(kOfxPropLabel, &[c"Box"]);
    }
    set.set_texts(kOfxImageEffectPluginPropGrouping, &[c"Filter"]);
    set.set_texts(
        kOfxImageEffectPropSupportedContexts,
        &[kOfxImageEffectContextFilter, kOfxImageEffectContextGeneral],
    );
    set.set_texts(
        kOfxImageEffectPropSupportedPixelDepths,
        &[kOfxBitDepthFloat],
    );
    set.set_texts(
        kOfxImageEffectPluginRenderThreadSafety,
        &[kOfxImageEffectRenderFullySafe],
    );
    set.set_int(kOfxImageEffectPluginPropHostFrameThreading, 0);
    set.set_int(kOfxImageEffectPropSupportsMultiResolution, 1);
    set.set_int(kOfxImageEffectPropSupportsTiles, 1);
    set.set_int(kOfxImageEffectPluginPropFieldRenderTwiceAlways, 1);
    kOfxStatOK
}

pub(super) fn in_context(call: &Call<'_>) -> OfxStatus {
    let Some(define) = call.effect.suites.effect.clipDefine else {
        return kOfxStatErrMissingHostFeature;
    };
    if call.effect.handle.is_null() {
        return kOfxStatErrBadHandle;
    }
    let all = [
        kOfxImageComponentRGBA,
        kOfxImageComponentRGB,
        kOfxImageComponentAlpha,
    ];
    for (name, optional) in [(c"Source", 0), (c"Depth", 1), (c"Mask", 1), (c"Output", 0)] {
        let mut handle = std::ptr::null_mut();
        // SAFETY: room for a handle.
        let done = unsafe { define(call.effect.handle, name.as_ptr(), &raw mut handle) };
        if done != kOfxStatOK {
            return done;
        }
        let set = Set {
            suites: call.effect.suites,
            handle,
        };
        let components = if name == c"Mask" { &all[2..] } else { &all[..] };
        set.set_texts(kOfxImageEffectPropSupportedComponents, components);
        set.set_int(kOfxImageClipPropOptional, optional);
        set.set_int(kOfxImageEffectPropSupportsTiles, 1);
    }
    let first = if call.fault == Fault::BadDefault {
        -1.0
    } else {
        3.0
    };
    double(call, c"size", first, 100.0);
    double(call, c"mix", 1.0, 1.0);
    for name in [c"useDepth", c"useMask"] {
        parameter(call, kOfxParamTypeBoolean, name);
    }
    if let Some(set) = parameter(call, kOfxParamTypeString, c"file") {
        set.set_texts(kOfxParamPropStringMode, &[kOfxParamStringIsFilePath]);
        set.set_int(kOfxParamPropAnimates, 0);
    }
    kOfxStatOK
}

fn parameter<'a>(call: &Call<'a>, kind: &CStr, name: &CStr) -> Option<Set<'a>> {
    let define = call.effect.suites.parameter.paramDefine?;
    let mut handle = std::ptr::null_mut();
    // SAFETY: room for a handle.
    let done = unsafe {
        define(
            call.effect.parameters()?,
            kind.as_ptr(),
            name.as_ptr(),
            &raw mut handle,
        )
    };
    (done == kOfxStatOK).then_some(Set {
        suites: call.effect.suites,
        handle,
    })
}

fn double(call: &Call<'_>, name: &CStr, first: f64, most: f64) {
    if let Some(set) = parameter(call, kOfxParamTypeDouble, name) {
        set.set_texts(kOfxPropLabel, &[name]);
        set.set_doubles(kOfxParamPropDefault, &[first]);
        for property in [kOfxParamPropMin, kOfxParamPropDisplayMin] {
            set.set_doubles(property, &[0.0]);
        }
        for property in [kOfxParamPropMax, kOfxParamPropDisplayMax] {
            set.set_doubles(property, &[most]);
        }
    }
}

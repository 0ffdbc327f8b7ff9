//! GetClipPreferences, GetRegionOfDefinition, GetRegionsOfInterest and IsIdentity.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::Call;
use crate::faults::Fault;

/// Gives Source and Output the components that Source has.
pub(super) fn clip_preferences(call: &Call<'_>) -> OfxStatus {
    let source = call.effect.clip(c"Source");
    let own = source.and_then(|clip| clip.properties.string(kOfxImageClipPropUnmappedComponents));
    let known = [
        kOfxImageComponentRGBA,
        kOfxImageComponentRGB,
        kOfxImageComponentAlpha,
    ];
    let own = known
        .into_iter()
        .find(|name| own.as_deref().map(str::as_bytes) == Some(name.to_bytes()));
    let (Some(own), false) = (own, call.fault == Fault::WidestOutput) else {
        return kOfxStatReplyDefault;
    };
    for property in [
        c"OfxImageClipPropComponents_Source",
        c"OfxImageClipPropComponents_Output",
    ] {
        call.out_args.set_strings(property, &[own]);
    }
    kOfxStatOK
}

/// Expands a rectangle (x1, y1, x2, y2) on every side.
fn expanded(rect: [f64; 4], margin: f64) -> [f64; 4] {
    let [x1, y1, x2, y2] = rect;
    [x1 - margin, y1 - margin, x2 + margin, y2 + margin]
}

/// Returns the region of definition of Source, if the host provides it.
pub(super) fn source_region(call: &Call<'_>) -> Option<[f64; 4]> {
    let get = call.effect.suites.effect.clipGetRegionOfDefinition?;
    let clip = call.effect.clip(c"Source")?;
    let mut bounds = OfxRectD {
        x1: 0.0,
        y1: 0.0,
        x2: 0.0,
        y2: 0.0,
    };
    // SAFETY: memory for a rectangle.
    let status = unsafe { get(clip.handle, call.time(), &raw mut bounds) };
    (status == kOfxStatOK).then_some([bounds.x1, bounds.y1, bounds.x2, bounds.y2])
}

pub(super) fn region_of_definition(call: &Call<'_>) -> OfxStatus {
    let Some(source) = source_region(call) else {
        return kOfxStatReplyDefault;
    };
    if call.fault == Fault::SmallRegionOfDefinition {
        return kOfxStatReplyDefault;
    }
    let size = call.size();
    let margin = if size > 0.0 { size + 0.5 } else { 0.0 };
    call.out_args.set_doubles(
        kOfxImageEffectPropRegionOfDefinition,
        &expanded(source, margin),
    );
    kOfxStatOK
}

pub(super) fn regions_of_interest(call: &Call<'_>) -> OfxStatus {
    let Some(window) = call
        .in_args
        .doubles::<4>(kOfxImageEffectPropRegionOfInterest)
    else {
        return kOfxStatReplyDefault;
    };
    if call.fault == Fault::RequiresRegion && source_region(call).is_none() {
        return kOfxStatReplyDefault;
    }
    // A few pixels of the render scale more than the box reaches.
    let scale = call
        .in_args
        .double(kOfxImageEffectPropRenderScale, 1)
        .unwrap_or(1.0);
    let margin = if call.fault == Fault::SmallRegionOfInterest {
        0.0
    } else {
        call.size() + 0.5 + 4.0 / scale.max(1e-3)
    };
    call.out_args
        .set_doubles(c"OfxImageClipPropRoI_Source", &expanded(window, margin));
    kOfxStatOK
}

pub(super) fn identity(call: &Call<'_>) -> OfxStatus {
    if call.effect.handle.is_null() {
        return kOfxStatErrBadHandle;
    }
    let time = call.time();
    let size = call.size();
    let mix = call.effect.double(c"mix", time).unwrap_or(1.0);
    // The render fails if the file is missing, so it must be called.
    let names_file = call
        .effect
        .string(c"file", time)
        .is_some_and(|file| !file.is_empty());
    let identity_size = if call.fault == Fault::FalseIdentity {
        5.0
    } else {
        0.0
    };
    if (size > identity_size && mix > 0.0) || names_file {
        return kOfxStatReplyDefault;
    }
    call.out_args.set_strings(kOfxPropName, &[c"Source"]);
    call.out_args.set_doubles(kOfxPropTime, &[time]);
    kOfxStatOK
}

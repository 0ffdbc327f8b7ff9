//! Where there is a picture, what is needed for it, and whether it is only copied.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::Call;
use crate::faults::Fault;

/// The rectangle with a margin on every side.
fn grown([x1, y1, x2, y2]: [f64; 4], by: f64) -> [f64; 4] {
    [x1 - by, y1 - by, x2 + by, y2 + by]
}

/// Where Source has pixels, if the host says so.
pub(super) fn source_region(call: &Call<'_>) -> Option<[f64; 4]> {
    let get = call.effect.suites.effect.clipGetRegionOfDefinition?;
    let (clip, _) = call.effect.clip(c"Source")?;
    let mut bounds = OfxRectD {
        x1: 0.0,
        y1: 0.0,
        x2: 0.0,
        y2: 0.0,
    };
    // SAFETY: room for a rectangle.
    let status = unsafe { get(clip, call.time(), &raw mut bounds) };
    (status == kOfxStatOK).then_some([bounds.x1, bounds.y1, bounds.x2, bounds.y2])
}

pub(super) fn of_definition(call: &Call<'_>) -> OfxStatus {
    let Some(source) = source_region(call) else {
        return kOfxStatReplyDefault;
    };
    if call.fault == Fault::SmallDefinition {
        return kOfxStatReplyDefault;
    }
    let size = call.size();
    let margin = if size > 0.0 { size + 0.5 } else { 0.0 };
    call.wanted.set_doubles(
        kOfxImageEffectPropRegionOfDefinition,
        &grown(source, margin),
    );
    kOfxStatOK
}

pub(super) fn of_interest(call: &Call<'_>) -> OfxStatus {
    let Some(window) = call.given.doubles::<4>(kOfxImageEffectPropRegionOfInterest) else {
        return kOfxStatReplyDefault;
    };
    if call.fault == Fault::NeedsRegion && source_region(call).is_none() {
        return kOfxStatReplyDefault;
    }
    // Two pixels more at any scale than the box reaches.
    let scale = call
        .given
        .double(kOfxImageEffectPropRenderScale, 1)
        .unwrap_or(1.0);
    let margin = match call.fault {
        Fault::SmallRegion => 0.0,
        _ => call.size() + 0.5 + 4.0 / scale.max(1e-3),
    };
    call.wanted
        .set_doubles(c"OfxImageClipPropRoI_Source", &grown(window, margin));
    kOfxStatOK
}

pub(super) fn identity(call: &Call<'_>) -> OfxStatus {
    if call.effect.handle.is_null() {
        return kOfxStatErrBadHandle;
    }
    let time = call.time();
    let size = call.size();
    let mix = call.effect.double(c"mix", time).unwrap_or(1.0);
    let missing = call
        .effect
        .string(c"file", time)
        .is_some_and(|file| !file.is_empty());
    let most = if call.fault == Fault::FalseIdentity {
        5.0
    } else {
        0.0
    };
    if (size > most && mix > 0.0) || missing {
        return kOfxStatReplyDefault;
    }
    call.wanted.set_texts(kOfxPropName, &[c"Source"]);
    call.wanted.set_doubles(kOfxPropTime, &[time]);
    kOfxStatOK
}

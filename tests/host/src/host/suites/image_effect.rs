//! The image effect suite.

use std::ffi::{c_char, c_int, c_void};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::OfxParamSetHandle;

use super::memory::Block;
use super::pointers::{found, name, put, put_if};
use crate::host::effect::{Clip, Effect};
use crate::host::images::{fetch, release};
use crate::host::properties::{PropertySet, clip_descriptor};
use crate::host::{Object, current, locked, under};
use crate::picture::Region;

pub(super) fn suite() -> OfxImageEffectSuiteV1 {
    OfxImageEffectSuiteV1 {
        getPropertySet: Some(get_property_set),
        getParamSet: Some(get_param_set),
        clipDefine: Some(clip_define),
        clipGetHandle: Some(clip_get_handle),
        clipGetPropertySet: Some(clip_get_property_set),
        clipGetImage: Some(clip_get_image),
        clipReleaseImage: Some(clip_release_image),
        clipGetRegionOfDefinition: Some(clip_get_rod),
        abort: Some(abort),
        imageMemoryAlloc: Some(image_memory_alloc),
        imageMemoryFree: Some(image_memory_free),
        imageMemoryLock: Some(image_memory_lock),
        imageMemoryUnlock: Some(image_memory_unlock),
    }
}

unsafe extern "C" fn get_property_set(
    effect: OfxImageEffectHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    match found::<Effect>(effect as usize, "getPropertySet") {
        // SAFETY: the plugin gives room for a handle.
        Ok((_, effect)) => unsafe {
            put(set, effect.properties.handle() as *mut _, "getPropertySet")
        },
        Err(status) => status,
    }
}

unsafe extern "C" fn get_param_set(
    effect: OfxImageEffectHandle,
    set: *mut OfxParamSetHandle,
) -> OfxStatus {
    match found::<Effect>(effect as usize, "getParamSet") {
        // SAFETY: the plugin gives room for a handle.
        Ok((_, effect)) => unsafe { put(set, effect.parameters.handle() as *mut _, "getParamSet") },
        Err(status) => status,
    }
}

unsafe extern "C" fn clip_define(
    effect: OfxImageEffectHandle,
    clip: *const c_char,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let (host, effect) = match found::<Effect>(effect as usize, "clipDefine") {
        Ok(found) => found,
        Err(status) => return status,
    };
    if effect.instance || under::now().is_none_or(|under| !under.defines()) {
        host.misused("clipDefine was called outside DescribeInContext".to_owned());
        return kOfxStatErrBadHandle;
    }
    // SAFETY: the plugin names the clip by a string.
    let Some(clip) = (unsafe { name(clip) }) else {
        return kOfxStatErrValue;
    };
    let text = clip.to_string_lossy().into_owned();
    if effect.clip(&text).is_some() {
        host.misused(format!("clip {text} was defined twice"));
        return kOfxStatErrExists;
    }
    let values = clip_descriptor(&host.profile, clip);
    let title = format!("clip {text}");
    let properties = host.property_set("clip descriptor", &title, values, !host.profile.describes);
    let handle = properties.handle();
    effect.add_clip(&host, &text, properties);
    // SAFETY: room for a handle, or NULL if it is not wanted.
    unsafe { put_if(set, handle as *mut _) };
    kOfxStatOK
}

unsafe extern "C" fn clip_get_handle(
    effect: OfxImageEffectHandle,
    clip: *const c_char,
    handle: *mut OfxImageClipHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let (host, effect) = match found::<Effect>(effect as usize, "clipGetHandle") {
        Ok(found) => found,
        Err(status) => return status,
    };
    if !effect.instance {
        host.misused("clipGetHandle was called on a descriptor".to_owned());
        return kOfxStatErrBadHandle;
    }
    // SAFETY: the plugin names the clip by a string.
    let Some(clip) = (unsafe { name(clip) }) else {
        return kOfxStatErrValue;
    };
    match effect.clip(&clip.to_string_lossy()) {
        Some(clip) => {
            // SAFETY: room for handles, the second NULL if it is not wanted.
            unsafe {
                put_if(set, clip.properties.handle() as *mut _);
                put(handle, clip.handle() as *mut _, "clipGetHandle")
            }
        }
        None => kOfxStatErrUnknown,
    }
}

unsafe extern "C" fn clip_get_property_set(
    clip: OfxImageClipHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    match found::<Clip>(clip as usize, "clipGetPropertySet") {
        // SAFETY: the plugin gives room for a handle.
        Ok((_, clip)) => unsafe {
            put(
                set,
                clip.properties.handle() as *mut _,
                "clipGetPropertySet",
            )
        },
        Err(status) => status,
    }
}

unsafe extern "C" fn clip_get_image(
    clip: OfxImageClipHandle,
    time: OfxTime,
    region: *const OfxRectD,
    image: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let (host, clip) = match found::<Clip>(clip as usize, "clipGetImage") {
        Ok(found) => found,
        Err(status) => return status,
    };
    if let Some(under) = under::now()
        && !under.fetches()
    {
        host.misused(format!("clipGetImage was called in {}", under.action));
        return kOfxStatFailed;
    }
    let region = (!region.is_null()).then(|| {
        // SAFETY: not NULL, so a rectangle.
        let r = unsafe { region.read_unaligned() };
        Region::new(r.x1, r.y1, r.x2, r.y2)
    });
    match fetch(&host, &clip, time, region) {
        // SAFETY: the plugin gives room for a handle.
        Ok(handle) => unsafe { put(image, handle as *mut _, "clipGetImage") },
        Err(status) => {
            // SAFETY: as above. What was there stays there in no host to rely on.
            unsafe { put_if(image, std::ptr::null_mut()) };
            status
        }
    }
}

unsafe extern "C" fn clip_release_image(image: OfxPropertySetHandle) -> OfxStatus {
    match found::<PropertySet>(image as usize, "clipReleaseImage") {
        Ok((host, set)) => release(&host, &set),
        Err(status) => status,
    }
}

unsafe extern "C" fn clip_get_rod(
    clip: OfxImageClipHandle,
    time: OfxTime,
    bounds: *mut OfxRectD,
) -> OfxStatus {
    let (host, clip) = match found::<Clip>(clip as usize, "clipGetRegionOfDefinition") {
        Ok(found) => found,
        Err(status) => return status,
    };
    if host.profile.late_regions && under::now().is_some_and(|under| under.needs()) {
        return kOfxStatFailed;
    }
    let Some(effect) = clip.effect.upgrade() else {
        return kOfxStatErrBadHandle;
    };
    let scene = locked(&effect.scene).clone();
    let wanted = if clip.name == "Output" {
        "Source"
    } else {
        &clip.name
    };
    let rendering = under::now().and_then(|under| under.rendering);
    let (across, up) = match &rendering {
        Some(rendering) if host.profile.pixel_regions => rendering.scale,
        _ => (1.0, 1.0),
    };
    match scene.region(wanted, time) {
        Some(r) => {
            let rect = OfxRectD {
                x1: r.x1 * across,
                y1: r.y1 * up,
                x2: r.x2 * across,
                y2: r.y2 * up,
            };
            // SAFETY: the plugin gives room for a rectangle.
            unsafe { put(bounds, rect, "clipGetRegionOfDefinition") }
        }
        None => kOfxStatFailed,
    }
}

unsafe extern "C" fn abort(effect: OfxImageEffectHandle) -> c_int {
    let Ok((host, _)) = found::<Effect>(effect as usize, "abort") else {
        return 0;
    };
    host.counts.polls.fetch_add(1, Ordering::SeqCst);
    let left = host
        .patience
        .fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| {
            (left > 0).then(|| left - 1)
        })
        .unwrap_or_else(|left| left);
    let stop = left == 0;
    if stop {
        host.counts.polls_told.fetch_add(1, Ordering::SeqCst);
    }
    c_int::from(stop)
}

unsafe extern "C" fn image_memory_alloc(
    effect: OfxImageEffectHandle,
    bytes: usize,
    handle: *mut OfxImageMemoryHandle,
) -> OfxStatus {
    let host = if effect.is_null() {
        current().ok_or(kOfxStatFailed)
    } else {
        found::<Effect>(effect as usize, "imageMemoryAlloc").map(|(host, _)| host)
    };
    let host = match host {
        Ok(host) => host,
        Err(status) => return status,
    };
    let block = Arc::new(Block::new(bytes));
    let given = host.keep("a block of image memory", Object::Block(block));
    host.counts.memory_out.fetch_add(1, Ordering::SeqCst);
    // SAFETY: the plugin gives room for a handle.
    unsafe { put(handle, given as *mut _, "imageMemoryAlloc") }
}

unsafe extern "C" fn image_memory_free(memory: OfxImageMemoryHandle) -> OfxStatus {
    match found::<Block>(memory as usize, "imageMemoryFree") {
        Ok((host, _)) => {
            host.end(memory as usize);
            host.counts.memory_out.fetch_sub(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn image_memory_lock(
    memory: OfxImageMemoryHandle,
    at: *mut *mut c_void,
) -> OfxStatus {
    match found::<Block>(memory as usize, "imageMemoryLock") {
        // SAFETY: the plugin gives room for a pointer.
        Ok((_, block)) => unsafe { put(at, block.data(), "imageMemoryLock") },
        Err(status) => status,
    }
}

unsafe extern "C" fn image_memory_unlock(memory: OfxImageMemoryHandle) -> OfxStatus {
    found::<Block>(memory as usize, "imageMemoryUnlock")
        .err()
        .unwrap_or(kOfxStatOK)
}

//! The image effect suite.

use std::ffi::{c_char, c_int, c_void};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::OfxParamSetHandle;

use super::memory::MemoryBlock;
use super::pointers::{c_str, resolve, with_host, with_object, write_optional, write_result};
use crate::host::action::current_action;
use crate::host::effect::{Clip, Effect, EffectRole};
use crate::host::images::{fetch, release};
use crate::host::properties::{PropertySet, clip_descriptor};
use crate::host::{Host, Object, locked};
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
    with_object::<Effect>(effect as usize, "getPropertySet", |_, effect| {
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(set, effect.properties.handle() as *mut _, "getPropertySet") }
    })
}

unsafe extern "C" fn get_param_set(
    effect: OfxImageEffectHandle,
    set: *mut OfxParamSetHandle,
) -> OfxStatus {
    with_object::<Effect>(effect as usize, "getParamSet", |_, effect| {
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(set, effect.parameters.handle() as *mut _, "getParamSet") }
    })
}

unsafe extern "C" fn clip_define(
    effect: OfxImageEffectHandle,
    clip: *const c_char,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    with_object::<Effect>(effect as usize, "clipDefine", |host, effect| {
        if effect.role == EffectRole::Instance
            || current_action().is_none_or(|action| !action.allows_definitions())
        {
            host.record_misuse("clipDefine was called outside DescribeInContext");
            return kOfxStatErrBadHandle;
        }
        // SAFETY: the plugin passes a string.
        let Some(clip) = (unsafe { c_str(clip) }) else {
            return kOfxStatErrValue;
        };
        let name = clip.to_string_lossy().into_owned();
        if effect.clip(&name).is_some() {
            host.record_misuse(format!("clip {name} was defined twice"));
            return kOfxStatErrExists;
        }
        let properties = host.property_set(
            "clip descriptor",
            &format!("clip {name}"),
            clip_descriptor(&host.profile, clip),
            host.profile.descriptor_schema(),
        );
        let handle = properties.handle();
        effect.add_clip(host, &name, properties);
        // SAFETY: NULL or memory for a handle.
        unsafe { write_optional(set, handle as *mut _) };
        kOfxStatOK
    })
}

unsafe extern "C" fn clip_get_handle(
    effect: OfxImageEffectHandle,
    clip: *const c_char,
    handle: *mut OfxImageClipHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    with_object::<Effect>(effect as usize, "clipGetHandle", |host, effect| {
        if effect.role == EffectRole::Descriptor {
            host.record_misuse("clipGetHandle was called on a descriptor");
            return kOfxStatErrBadHandle;
        }
        // SAFETY: the plugin passes a string.
        let Some(clip) = (unsafe { c_str(clip) }) else {
            return kOfxStatErrValue;
        };
        let Some(clip) = effect.clip(&clip.to_string_lossy()) else {
            return kOfxStatErrUnknown;
        };
        // SAFETY: memory for handles; the second may be NULL.
        unsafe {
            write_optional(set, clip.properties.handle() as *mut _);
            write_result(handle, clip.handle() as *mut _, "clipGetHandle")
        }
    })
}

unsafe extern "C" fn clip_get_property_set(
    clip: OfxImageClipHandle,
    set: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let call = "clipGetPropertySet";
    with_object::<Clip>(clip as usize, call, |_, clip| {
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(set, clip.properties.handle() as *mut _, call) }
    })
}

unsafe extern "C" fn clip_get_image(
    clip: OfxImageClipHandle,
    time: OfxTime,
    region: *const OfxRectD,
    image: *mut OfxPropertySetHandle,
) -> OfxStatus {
    with_object::<Clip>(clip as usize, "clipGetImage", |host, clip| {
        if let Some(action) = current_action()
            && !action.allows_images()
        {
            host.record_misuse(format!("clipGetImage was called in {}", action.name));
            return kOfxStatFailed;
        }
        let region = (!region.is_null()).then(|| {
            // SAFETY: not NULL, so it points to a rectangle.
            let r = unsafe { region.read_unaligned() };
            Region::new(r.x1, r.y1, r.x2, r.y2)
        });
        match fetch(host, clip, time, region) {
            // SAFETY: the plugin provides memory for a handle.
            Ok(handle) => unsafe { write_result(image, handle as *mut _, "clipGetImage") },
            Err(status) => {
                // Hosts differ in whether they leave the handle as it was.
                // SAFETY: as above.
                unsafe { write_optional(image, std::ptr::null_mut()) };
                status
            }
        }
    })
}

unsafe extern "C" fn clip_release_image(image: OfxPropertySetHandle) -> OfxStatus {
    with_object::<PropertySet>(image as usize, "clipReleaseImage", |host, set| {
        release(host, set)
    })
}

unsafe extern "C" fn clip_get_rod(
    clip: OfxImageClipHandle,
    time: OfxTime,
    bounds: *mut OfxRectD,
) -> OfxStatus {
    let call = "clipGetRegionOfDefinition";
    with_object::<Clip>(clip as usize, call, |host, clip| {
        let action = current_action();
        if host.profile.late_regions
            && (action.as_ref()).is_some_and(|a| a.is(kOfxImageEffectActionGetRegionsOfInterest))
        {
            return kOfxStatFailed;
        }
        let Some(effect) = clip.effect.upgrade() else {
            return kOfxStatErrBadHandle;
        };
        let scene = locked(&effect.scene).clone();
        let input = if clip.name == "Output" {
            "Source"
        } else {
            &clip.name
        };
        let (scale_x, scale_y) = match action.and_then(|action| action.render) {
            Some(render) if host.profile.pixel_regions => render.scale,
            _ => (1.0, 1.0),
        };
        let Some(r) = scene.region(input, time) else {
            return kOfxStatFailed;
        };
        let rect = OfxRectD {
            x1: r.x1 * scale_x,
            y1: r.y1 * scale_y,
            x2: r.x2 * scale_x,
            y2: r.y2 * scale_y,
        };
        // SAFETY: the plugin provides memory for a rectangle.
        unsafe { write_result(bounds, rect, call) }
    })
}

unsafe extern "C" fn abort(effect: OfxImageEffectHandle) -> c_int {
    let Ok((host, _)) = resolve::<Effect>(effect as usize, "abort") else {
        return 0;
    };
    host.counters.abort_polls.fetch_add(1, Ordering::SeqCst);
    let left = host
        .polls_before_abort
        .fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| {
            (left > 0).then(|| left - 1)
        })
        .unwrap_or_else(|left| left);
    let is_due = locked(&host.abort_from).is_some_and(|moment| Instant::now() >= moment);
    let aborts = left == 0 || is_due;
    if aborts {
        host.counters.abort_replies.fetch_add(1, Ordering::SeqCst);
    }
    c_int::from(aborts)
}

unsafe extern "C" fn image_memory_alloc(
    effect: OfxImageEffectHandle,
    bytes: usize,
    handle: *mut OfxImageMemoryHandle,
) -> OfxStatus {
    let call = "imageMemoryAlloc";
    let allocate = |host: &Host| {
        let block = Object::MemoryBlock(Arc::new(MemoryBlock::new(bytes)));
        let block = host.register("an image memory block", block);
        host.counters.memory_held.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(handle, block as *mut _, call) }
    };
    if effect.is_null() {
        with_host(allocate)
    } else {
        with_object::<Effect>(effect as usize, call, |host, _| allocate(host))
    }
}

unsafe extern "C" fn image_memory_free(memory: OfxImageMemoryHandle) -> OfxStatus {
    with_object::<MemoryBlock>(memory as usize, "imageMemoryFree", |host, _| {
        host.invalidate(memory as usize);
        host.counters.memory_held.fetch_sub(1, Ordering::SeqCst);
        kOfxStatOK
    })
}

unsafe extern "C" fn image_memory_lock(
    memory: OfxImageMemoryHandle,
    data: *mut *mut c_void,
) -> OfxStatus {
    with_object::<MemoryBlock>(memory as usize, "imageMemoryLock", |_, block| {
        // SAFETY: the plugin provides memory for a pointer.
        unsafe { write_result(data, block.data(), "imageMemoryLock") }
    })
}

unsafe extern "C" fn image_memory_unlock(memory: OfxImageMemoryHandle) -> OfxStatus {
    with_object::<MemoryBlock>(memory as usize, "imageMemoryUnlock", |_, _| kOfxStatOK)
}

//! The actions.

mod describe;
mod regions;
mod render;

use std::ffi::c_void;
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::OfxImageEffectHandle;

use crate::api::{Effect, Set};
use crate::faults::Fault;
use crate::state::{self, LOADS, Suites};

/// An action under way.
pub(crate) struct Call<'a> {
    pub(crate) fault: Fault,
    pub(crate) effect: Effect<'a>,
    pub(crate) given: Set<'a>,
    pub(crate) wanted: Set<'a>,
}

/// What an instance keeps.
struct Instance {
    size: f64,
}

/// Actions that the plugin leaves to the host.
const UNUSED: [&str; 12] = [
    "OfxImageEffectActionGetClipPreferences",
    "OfxImageEffectActionGetFramesNeeded",
    "OfxImageEffectActionGetTimeDomain",
    "OfxImageEffectActionBeginSequenceRender",
    "OfxImageEffectActionEndSequenceRender",
    "OfxActionBeginInstanceChanged",
    "OfxActionEndInstanceChanged",
    "OfxActionBeginInstanceEdit",
    "OfxActionEndInstanceEdit",
    "OfxActionPurgeCaches",
    "OfxActionSyncPrivateData",
    "OfxImageEffectActionGetOutputColourspace",
];

/// Does an action.
pub(crate) fn act(
    fault: Fault,
    action: &str,
    handle: *const c_void,
    given: OfxPropertySetHandle,
    wanted: OfxPropertySetHandle,
) -> OfxStatus {
    if action == "OfxActionLoad" {
        return load(fault);
    }
    let Some(suites) = state::suites(fault) else {
        return if action == "OfxActionUnload" {
            kOfxStatOK
        } else {
            kOfxStatFailed
        };
    };
    let call = Call {
        fault,
        effect: Effect {
            suites: &suites,
            handle: handle.cast_mut().cast::<()>() as OfxImageEffectHandle,
        },
        given: Set {
            suites: &suites,
            handle: given,
        },
        wanted: Set {
            suites: &suites,
            handle: wanted,
        },
    };
    match action {
        "OfxActionUnload" => {
            state::unload(fault);
            kOfxStatOK
        }
        "OfxActionDescribe" => describe::describe(&call),
        "OfxImageEffectActionDescribeInContext" => describe::in_context(&call),
        "OfxActionCreateInstance" => create(&call),
        "OfxActionDestroyInstance" => destroy(&call),
        "OfxActionInstanceChanged" => changed(&call),
        "OfxImageEffectActionGetRegionOfDefinition" => regions::of_definition(&call),
        "OfxImageEffectActionGetRegionsOfInterest" => regions::of_interest(&call),
        "OfxImageEffectActionIsIdentity" => regions::identity(&call),
        "OfxImageEffectActionRender" => render::render(&call),
        _ if fault == Fault::WrongReply && !UNUSED.contains(&action) => kOfxStatFailed,
        _ => kOfxStatReplyDefault,
    }
}

fn load(fault: Fault) -> OfxStatus {
    let status = state::load(fault);
    if status != kOfxStatOK {
        return status;
    }
    if fault == Fault::LingeringThread {
        std::thread::spawn(|| {
            loop {
                std::thread::park();
            }
        });
    }
    let suites: Option<Suites> = state::suites(fault);
    if let (Fault::FatalProperty, Some(suites)) = (fault, suites) {
        let host = Set {
            suites: &suites,
            handle: suites.host,
        };
        if host.int(kOfxPropAPIVersion, 0).is_none() {
            return kOfxStatErrMissingHostFeature;
        }
    }
    kOfxStatOK
}

fn create(call: &Call<'_>) -> OfxStatus {
    let Some(set) = call.effect.set() else {
        return kOfxStatErrBadHandle;
    };
    release(call, &set);
    let kept = Box::into_raw(Box::new(Instance {
        size: call.effect.double(c"size", 0.0).unwrap_or(0.0),
    }));
    set.set_pointer(kOfxPropInstanceData, kept.cast());
    if set.pointer(kOfxPropInstanceData) != Some(kept.cast()) {
        // A host that does not keep it, or does not give it back.
        set.set_pointer(kOfxPropInstanceData, std::ptr::null_mut());
        // SAFETY: made above, and nobody has it.
        drop(unsafe { Box::from_raw(kept) });
    }
    kOfxStatOK
}

/// Frees what the instance keeps, if anything.
fn release(call: &Call<'_>, set: &Set<'_>) {
    let kept = set
        .pointer(kOfxPropInstanceData)
        .unwrap_or(std::ptr::null_mut());
    if kept.is_null() || call.fault == Fault::LeaksInstance {
        return;
    }
    set.set_pointer(kOfxPropInstanceData, std::ptr::null_mut());
    let now = set.pointer(kOfxPropInstanceData);
    // A host that cannot forget it would hand it out again.
    if now.is_some_and(|now| now.is_null()) {
        // SAFETY: from `create`, and nobody has it any more.
        drop(unsafe { Box::from_raw(kept.cast::<Instance>()) });
    }
}

fn destroy(call: &Call<'_>) -> OfxStatus {
    match call.effect.set() {
        Some(set) => {
            if call.fault == Fault::NullInstance {
                let kept = set
                    .pointer(kOfxPropInstanceData)
                    .unwrap_or(std::ptr::null_mut());
                // SAFETY: it may be NULL: this is the fault.
                unsafe { std::ptr::read_volatile(kept.cast::<Instance>()) };
            }
            release(call, &set);
            if call.fault == Fault::ClearsDestroyed {
                call.effect.content(false);
            }
            kOfxStatOK
        }
        None => kOfxStatErrBadHandle,
    }
}

fn changed(call: &Call<'_>) -> OfxStatus {
    if call.fault == Fault::StaleParameter
        && let Some(set) = call.effect.set()
        && let Some(kept) = set.pointer(kOfxPropInstanceData)
        && !kept.is_null()
        && let Some(size) = call.effect.double_now(c"size")
    {
        // SAFETY: from `create`.
        unsafe { (*kept.cast::<Instance>()).size = size };
    }
    if call.fault != Fault::KeepsMessage && !call.effect.handle.is_null() {
        call.effect.content(call.fault == Fault::ClearsAlways);
    }
    kOfxStatReplyDefault
}

impl Call<'_> {
    pub(crate) fn time(&self) -> f64 {
        self.given.double(kOfxPropTime, 0).unwrap_or(0.0)
    }

    /// The radius in canonical pixels.
    pub(crate) fn size(&self) -> f64 {
        let size = self
            .effect
            .double(c"size", self.time())
            .unwrap_or(0.0)
            .max(0.0);
        match self.fault {
            Fault::StaleState => size + LOADS.load(Ordering::SeqCst) as f64 - 1.0,
            Fault::StaleParameter => {
                let kept = self
                    .effect
                    .set()
                    .and_then(|set| set.pointer(kOfxPropInstanceData));
                match kept.filter(|kept| !kept.is_null()) {
                    // SAFETY: from `create`.
                    Some(kept) => unsafe { (*kept.cast::<Instance>()).size },
                    None => size,
                }
            }
            Fault::ReadsUntimed => self.effect.double_now(c"size").unwrap_or(size),
            _ => size,
        }
    }
}

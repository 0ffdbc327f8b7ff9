//! The actions.

mod describe;
mod regions;
mod render;

use std::ffi::c_void;
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::OfxImageEffectHandle;

use crate::api::{Effect, PropertySet};
use crate::faults::Fault;
use crate::state::{self, LOADS};

/// An action under way.
pub(crate) struct Call<'a> {
    pub(crate) fault: Fault,
    pub(crate) effect: Effect<'a>,
    pub(crate) in_args: PropertySet<'a>,
    pub(crate) out_args: PropertySet<'a>,
}

/// The data of an instance.
struct Instance {
    size: f64,
}

/// Known actions for which the plugin returns the default reply.
const DEFAULT_ACTIONS: [&str; 11] = [
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

/// Performs an action.
pub(crate) fn act(
    fault: Fault,
    action: &str,
    handle: *const c_void,
    in_args: OfxPropertySetHandle,
    out_args: OfxPropertySetHandle,
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
    let properties = |handle| PropertySet {
        suites: &suites,
        handle,
    };
    let call = Call {
        fault,
        effect: Effect {
            suites: &suites,
            handle: handle.cast_mut().cast::<()>() as OfxImageEffectHandle,
        },
        in_args: properties(in_args),
        out_args: properties(out_args),
    };
    match action {
        "OfxActionUnload" => {
            state::unload(fault);
            kOfxStatOK
        }
        "OfxActionDescribe" => describe::describe(&call),
        "OfxImageEffectActionDescribeInContext" => describe::describe_in_context(&call),
        "OfxActionCreateInstance" => create_instance(&call),
        "OfxActionDestroyInstance" => destroy_instance(&call),
        "OfxActionInstanceChanged" => instance_changed(&call),
        "OfxImageEffectActionGetClipPreferences" => regions::clip_preferences(&call),
        "OfxImageEffectActionGetRegionOfDefinition" => regions::region_of_definition(&call),
        "OfxImageEffectActionGetRegionsOfInterest" => regions::regions_of_interest(&call),
        "OfxImageEffectActionIsIdentity" => regions::identity(&call),
        "OfxImageEffectActionRender" => render::render(&call),
        _ if fault == Fault::WrongReply && !DEFAULT_ACTIONS.contains(&action) => kOfxStatFailed,
        _ => kOfxStatReplyDefault,
    }
}

fn load(fault: Fault) -> OfxStatus {
    let status = state::load(fault);
    if status != kOfxStatOK {
        return status;
    }
    if fault == Fault::LeftoverThread {
        std::thread::spawn(|| {
            loop {
                std::thread::park();
            }
        });
    }
    if fault == Fault::RequiresApiVersion
        && let Some(suites) = state::suites(fault)
    {
        let host = PropertySet {
            suites: &suites,
            handle: suites.host,
        };
        if host.int(kOfxPropAPIVersion, 0).is_none() {
            return kOfxStatErrMissingHostFeature;
        }
    }
    kOfxStatOK
}

fn create_instance(call: &Call<'_>) -> OfxStatus {
    let Some(set) = call.effect.properties() else {
        return kOfxStatErrBadHandle;
    };
    free_instance_data(call, &set);
    let data = Box::into_raw(Box::new(Instance {
        size: call.effect.double(c"size", 0.0).unwrap_or(0.0),
    }));
    set.set_pointer(kOfxPropInstanceData, data.cast());
    if set.pointer(kOfxPropInstanceData, 0) != Some(data.cast()) {
        // The host does not store the pointer or does not return it.
        set.set_pointer(kOfxPropInstanceData, std::ptr::null_mut());
        // SAFETY: created above, and nobody else has it.
        drop(unsafe { Box::from_raw(data) });
    }
    kOfxStatOK
}

/// Frees the data of the instance, if it has any.
fn free_instance_data(call: &Call<'_>, set: &PropertySet<'_>) {
    let Some(data) = set.non_null(kOfxPropInstanceData) else {
        return;
    };
    if call.fault == Fault::LeaksInstance {
        return;
    }
    set.set_pointer(kOfxPropInstanceData, std::ptr::null_mut());
    let now = set.pointer(kOfxPropInstanceData, 0);
    // A host that cannot reset the pointer would return it again.
    if now.is_some_and(|now| now.is_null()) {
        // SAFETY: from `create_instance`, and nobody else has it any more.
        drop(unsafe { Box::from_raw(data.cast::<Instance>()) });
    }
}

fn destroy_instance(call: &Call<'_>) -> OfxStatus {
    let Some(set) = call.effect.properties() else {
        return kOfxStatErrBadHandle;
    };
    if call.fault == Fault::ReadsNullInstance {
        let data = set.non_null(kOfxPropInstanceData);
        let data = data.unwrap_or(std::ptr::null_mut());
        // SAFETY: none if it is NULL; this is the fault.
        unsafe { std::ptr::read_volatile(data.cast::<Instance>()) };
    }
    free_instance_data(call, &set);
    if call.fault == Fault::ClearsMessageInDestroy {
        call.effect.clear_message();
    }
    kOfxStatOK
}

fn instance_changed(call: &Call<'_>) -> OfxStatus {
    if call.fault == Fault::StaleParameter
        && let Some(data) = call.instance_data()
        && let Some(size) = call.effect.current_double(c"size")
    {
        // SAFETY: from `create_instance`.
        unsafe { (*data).size = size };
    }
    if !call.effect.handle.is_null() {
        call.clear_message();
    }
    kOfxStatReplyDefault
}

impl Call<'_> {
    pub(crate) fn time(&self) -> f64 {
        self.in_args.double(kOfxPropTime, 0).unwrap_or(0.0)
    }

    /// Returns the radius in canonical pixels.
    pub(crate) fn size(&self) -> f64 {
        let size = self
            .effect
            .double(c"size", self.time())
            .unwrap_or(0.0)
            .max(0.0);
        match self.fault {
            Fault::StaleState => size + LOADS.load(Ordering::SeqCst) as f64 - 1.0,
            Fault::StaleParameter => match self.instance_data() {
                // SAFETY: from `create_instance`.
                Some(data) => unsafe { (*data).size },
                None => size,
            },
            Fault::ReadsWithoutTime => self.effect.current_double(c"size").unwrap_or(size),
            _ => size,
        }
    }

    /// Clears the persistent message.
    pub(crate) fn clear_message(&self) {
        match self.fault {
            Fault::KeepsMessage => {}
            Fault::ClearsMessageInResolve => self.effect.clear_message_anywhere(),
            _ => self.effect.clear_message(),
        }
    }

    fn instance_data(&self) -> Option<*mut Instance> {
        let data = self.effect.properties()?.non_null(kOfxPropInstanceData)?;
        Some(data.cast())
    }
}

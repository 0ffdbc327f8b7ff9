//! The actions that hosts call, one a file.

mod changed;
mod check_lens;
mod describe;
mod describe_in_context;
mod enabled;
mod guess_depth;
mod identity;
mod instance_set;
mod instances;
mod load;
mod persistent_message;
mod preferences;
mod region_of_definition;
mod regions_of_interest;
mod render;
mod show_lens_data;

use std::ffi::CStr;

use crate::host::{self, Call, Result};
use crate::sys::actions as names;
use crate::sys::plugin::{STATUS_ERR_BAD_HANDLE, STATUS_FAILED, STATUS_OK, STATUS_REPLY_DEFAULT};
use crate::sys::{Handle, OfxStatus};

/// The answer of an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answer {
    /// The action was carried out.
    Done,
    /// The host should do what it does by default.
    Default,
}

/// Carries out the action `name`; returns its status. Errors and panics are shown to the user.
pub(crate) fn perform(name: &CStr, handle: Handle, inputs: Handle, outputs: Handle) -> OfxStatus {
    if name == names::LOAD {
        return load::load();
    }
    if name == names::UNLOAD {
        return load::unload();
    }
    let work: fn(&Call) -> Result<Answer> = match name {
        name if name == names::DESCRIBE => describe::describe,
        name if name == names::DESCRIBE_IN_CONTEXT => describe_in_context::describe,
        name if name == names::CREATE_INSTANCE => instances::create,
        name if name == names::DESTROY_INSTANCE => instances::destroy,
        name if name == names::INSTANCE_CHANGED => changed::changed,
        name if name == names::GET_CLIP_PREFERENCES => preferences::preferences,
        name if name == names::GET_OUTPUT_COLOURSPACE => preferences::colourspace,
        name if name == names::GET_REGION_OF_DEFINITION => region_of_definition::region,
        name if name == names::GET_REGIONS_OF_INTEREST => regions_of_interest::regions,
        name if name == names::IS_IDENTITY => identity::action,
        name if name == names::RENDER => render::render,
        name if name == names::BEGIN_SEQUENCE_RENDER => do_nothing,
        name if name == names::END_SEQUENCE_RENDER => do_nothing,
        name if name == names::PURGE_CACHES => purge_caches,
        _ => return STATUS_REPLY_DEFAULT,
    };
    // A host that calls actions before Load gets an error.
    let Some(host) = host::current() else {
        return STATUS_FAILED;
    };
    if handle.is_null() {
        return STATUS_ERR_BAD_HANDLE;
    }
    let call = Call::new(&host, handle, inputs, outputs);
    match host::catch_panic(|| work(&call)) {
        Ok(Ok(Answer::Done)) => STATUS_OK,
        Ok(Ok(Answer::Default)) => STATUS_REPLY_DEFAULT,
        Ok(Err(failure)) => {
            persistent_message::show(&host, handle, &failure.text);
            failure.status
        }
        Err(panic) => {
            host::log(
                &host,
                handle,
                &format!("Seidel: {}: {panic}", name.to_string_lossy()),
            );
            let text = format!(
                "An error in Seidel stopped this ({panic}); please report it and the steps to it. Other frames are not affected."
            );
            persistent_message::show(&host, handle, &text);
            STATUS_FAILED
        }
    }
}

fn do_nothing(_: &Call) -> Result<Answer> {
    Ok(Answer::Done)
}

fn purge_caches(_: &Call) -> Result<Answer> {
    load::purge_caches();
    Ok(Answer::Done)
}

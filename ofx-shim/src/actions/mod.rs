//! What the host asks for, one action a file.

mod changed;
mod check_lens;
mod create;
mod describe;
mod describe_in_context;
mod enabled;
mod focal_point;
mod identity;
mod load;
mod preferences;
mod region_of_definition;
mod regions_of_interest;
mod render;
mod told;

use std::ffi::CStr;

use crate::host::{self, Effect, Host, PropertySet, Result};
use crate::sys::actions as names;
use crate::sys::plugin::{STATUS_ERR_BAD_HANDLE, STATUS_FAILED, STATUS_OK, STATUS_REPLY_DEFAULT};
use crate::sys::{Handle, OfxStatus};

pub(crate) use focal_point::focus as focus_there;
pub(crate) use render::chosen_lens;
pub(crate) use told::{tell, untell};

/// What an action is called with.
pub(crate) struct Call<'h> {
    pub(crate) host: &'h Host,
    pub(crate) effect: Effect<'h>,
    pub(crate) arguments: PropertySet<'h>,
    pub(crate) answers: PropertySet<'h>,
}

/// What an action answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answer {
    /// It was done.
    Done,
    /// The host's own way is right.
    Default,
}

/// Does an action.
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
        name if name == names::CREATE_INSTANCE => create::create,
        name if name == names::DESTROY_INSTANCE => create::destroy,
        name if name == names::INSTANCE_CHANGED => changed::changed,
        name if name == names::GET_CLIP_PREFERENCES => preferences::preferences,
        name if name == names::GET_OUTPUT_COLOURSPACE => preferences::colourspace,
        name if name == names::GET_REGION_OF_DEFINITION => region_of_definition::region,
        name if name == names::GET_REGIONS_OF_INTEREST => regions_of_interest::regions,
        name if name == names::IS_IDENTITY => identity::action,
        name if name == names::RENDER => render::render,
        name if name == names::BEGIN_SEQUENCE_RENDER => nothing,
        name if name == names::END_SEQUENCE_RENDER => nothing,
        name if name == names::PURGE_CACHES => purge,
        _ => return STATUS_REPLY_DEFAULT,
    };
    // Out of order: nothing can be done before Load, but for an answer.
    let Some(host) = host::current() else {
        return STATUS_FAILED;
    };
    if handle.is_null() {
        return STATUS_ERR_BAD_HANDLE;
    }
    let props = |handle| host.property_set(handle);
    let call = Call {
        host: &host,
        effect: Effect {
            host: &host,
            handle,
        },
        arguments: props(inputs),
        answers: props(outputs),
    };
    match host::catch_panic(|| work(&call)) {
        Ok(Ok(Answer::Done)) => STATUS_OK,
        Ok(Ok(Answer::Default)) => STATUS_REPLY_DEFAULT,
        Ok(Err(failure)) => {
            tell(&host, handle, &failure.text);
            failure.status
        }
        Err(said) => {
            host::log(
                &host,
                handle,
                &format!("Seidel: {}: {said}", name.to_string_lossy()),
            );
            let text = format!(
                "A fault of Seidel stopped this ({said}); please report it, with what was done. Other frames can go on."
            );
            tell(&host, handle, &text);
            STATUS_FAILED
        }
    }
}

fn nothing(_: &Call) -> Result<Answer> {
    Ok(Answer::Done)
}

/// Lets go of lenses and configs that nobody renders with.
fn purge(_: &Call) -> Result<Answer> {
    crate::lens::forget();
    crate::colour::forget();
    Ok(Answer::Done)
}

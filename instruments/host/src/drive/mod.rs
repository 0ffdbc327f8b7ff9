//! Driving a plugin: loading, describing, creating instances, rendering, in the order of hosts or any other.

mod arguments;
mod frame;
mod instance;
mod library;
mod overlay;
mod plugin;
mod queries;

pub use frame::{Frame, RenderRequest};
pub use instance::Instance;
pub use library::{Library, Plugin, binary_path};
pub use plugin::LoadedPlugin;
pub(crate) use plugin::new_descriptor;

use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;

use crate::host::action::{ActiveAction, within_action};
use crate::host::images::ActiveRender;
use crate::host::properties::PropertySet;

/// Returns the name of a status.
#[must_use]
pub fn status_name(status: OfxStatus) -> String {
    const NAMES: [&str; 16] = [
        "OK",
        "Failed",
        "ErrFatal",
        "ErrUnknown",
        "ErrMissingHostFeature",
        "ErrUnsupported",
        "ErrExists",
        "ErrFormat",
        "ErrMemory",
        "ErrBadHandle",
        "ErrBadIndex",
        "ErrValue",
        "ReplyYes",
        "ReplyNo",
        "ReplyDefault",
        "Unlicensed",
    ];
    match usize::try_from(status).ok().and_then(|i| NAMES.get(i)) {
        Some(name) => format!("kOfxStat{name}"),
        None if status == 1000 => "kOfxStatErrImageFormat".to_owned(),
        None => format!("the status {status}"),
    }
}

/// Returns an error unless `call` returned kOfxStatOK or kOfxStatReplyDefault.
pub(crate) fn check_status(call: &str, status: OfxStatus) -> Result<(), String> {
    if status == kOfxStatOK || status == kOfxStatReplyDefault {
        Ok(())
    } else {
        Err(format!("{call} returned {}", status_name(status)))
    }
}

/// The arguments of an action beside its handle.
#[derive(Default)]
pub(crate) struct ActionArguments<'a> {
    pub(crate) in_args: Option<&'a PropertySet>,
    pub(crate) out_args: Option<&'a PropertySet>,
    /// The render that it belongs to.
    pub(crate) render: Option<Arc<ActiveRender>>,
}

/// Calls an action without arguments.
pub(crate) fn act(plugin: &Plugin, action: &CStr, handle: usize) -> OfxStatus {
    act_with(plugin, action, handle, ActionArguments::default())
}

/// Calls an action.
pub(crate) fn act_with(
    plugin: &Plugin,
    action: &CStr,
    handle: usize,
    arguments: ActionArguments<'_>,
) -> OfxStatus {
    let active = ActiveAction {
        render: arguments.render,
        ..ActiveAction::new(action)
    };
    let handle_of = |set: Option<&PropertySet>| set.map_or(0, PropertySet::handle);
    within_action(Some(active), || {
        plugin.main_entry(
            action,
            handle,
            handle_of(arguments.in_args),
            handle_of(arguments.out_args),
        )
    })
}

//! Plugins driven from outside: loaded, described, instanced, rendered, in the order of hosts or in any other.

mod arguments;
mod frame;
mod instance;
mod library;
mod loaded;
mod overlay;
mod questions;

pub use frame::{Frame, Request};
pub use instance::Instance;
pub use library::{Library, Plugin, binary_of};
pub use loaded::Loaded;
pub(crate) use loaded::new_descriptor;

use std::ffi::CStr;
use std::sync::Arc;

use openfx::sys::generic::core::*;

use crate::host::images::Rendering;
use crate::host::properties::PropertySet;
use crate::host::under::{Under, doing};

/// What a status is called.
#[must_use]
pub fn status_name(status: OfxStatus) -> String {
    let names = [
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
    match usize::try_from(status).ok().and_then(|i| names.get(i)) {
        Some(name) => format!("kOfxStat{name}"),
        None if status == 1000 => "kOfxStatErrImageFormat".to_owned(),
        None => format!("the status {status}"),
    }
}

/// Calls an action of the plugin.
pub(crate) fn act(
    plugin: &Plugin,
    action: &CStr,
    handle: usize,
    given: Option<&PropertySet>,
    wanted: Option<&PropertySet>,
    rendering: Option<Arc<Rendering>>,
) -> OfxStatus {
    let under = Under {
        action: action.to_string_lossy().into_owned(),
        rendering,
    };
    let set = |set: Option<&PropertySet>| set.map_or(0, PropertySet::handle);
    doing(Some(under), || {
        plugin.main_entry(action, handle, set(given), set(wanted))
    })
}

//! A box blur as an OpenFX plugin, correct and in variants with one fault each.
//!
//! Each variant is a plugin of its own, `org.seidel.box.` and the name of the fault, so that one binary contains them all.

mod actions;
mod api;
mod blur;
mod faults;
mod image;
mod state;

use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use openfx::sys::generic::core::*;

use faults::{COUNT, Fault};

/// A table of plugins that is never modified.
struct PluginTable([OfxPlugin; COUNT]);

// SAFETY: nothing in it changes.
unsafe impl Sync for PluginTable {}

static PLUGINS: PluginTable = PluginTable(faults::PLUGINS);

/// Returns the plugin with index `N`.
const fn plugin<const N: usize>(id: &'static CStr) -> OfxPlugin {
    OfxPlugin {
        pluginApi: c"OfxImageEffectPluginAPI".as_ptr(),
        apiVersion: 1,
        pluginIdentifier: id.as_ptr(),
        pluginVersionMajor: 1,
        pluginVersionMinor: 0,
        setHost: Some(set_host::<N>),
        mainEntry: Some(main_entry::<N>),
    }
}

unsafe extern "C" fn set_host<const N: usize>(host: *mut OfxHost) {
    // Cannot panic, so it needs no guard.
    state::set_host(Fault::of_plugin(N), host);
}

unsafe extern "C" fn main_entry<const N: usize>(
    action: *const c_char,
    handle: *const c_void,
    in_args: OfxPropertySetHandle,
    out_args: OfxPropertySetHandle,
) -> OfxStatus {
    let status = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the host passes the action as a string.
        let action = unsafe { api::string(action) };
        actions::act(Fault::of_plugin(N), &action, handle, in_args, out_args)
    }));
    status.unwrap_or(kOfxStatFailed)
}

/// Returns the number of plugins.
#[unsafe(no_mangle)]
pub extern "C" fn OfxGetNumberOfPlugins() -> c_int {
    c_int::try_from(COUNT).unwrap_or(0)
}

/// Returns a plugin, or NULL for an invalid index.
#[unsafe(no_mangle)]
pub extern "C" fn OfxGetPlugin(nth: c_int) -> *mut OfxPlugin {
    usize::try_from(nth)
        .ok()
        .and_then(|n| PLUGINS.0.get(n))
        .map_or(std::ptr::null_mut(), |plugin| {
            (plugin as *const OfxPlugin).cast_mut()
        })
}

//! The exports of the binary, and the main entry of the plugin.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::null_mut;

use crate::sys::effect::API;
use crate::sys::plugin::{STATUS_FAILED, STATUS_OK};
use crate::sys::{Handle, OfxHost, OfxPlugin, OfxStatus};
use crate::{actions, host};

/// Identifier of the plugin. Projects store it, so that it never changes. It has dots alone, since some hosts replace other
/// punctuation.
pub(crate) const IDENTIFIER: &CStr = c"org.seidel.lensblur";

/// Major version: grows when the same parameters give another image. Hosts keep major versions apart.
const MAJOR: u32 = 1;
/// Minor version: grows with corrections.
const MINOR: u32 = 0;

static PLUGIN: OfxPlugin = OfxPlugin {
    plugin_api: API.as_ptr(),
    api_version: 1,
    plugin_identifier: IDENTIFIER.as_ptr(),
    plugin_version_major: MAJOR,
    plugin_version_minor: MINOR,
    set_host: Some(set_host),
    main_entry: Some(main_entry),
};

/// Returns the number of plugins in the binary.
#[unsafe(no_mangle)]
#[allow(non_snake_case)]
pub extern "C" fn OfxGetNumberOfPlugins() -> c_int {
    1
}

/// Returns the plugin `nth`, which is NULL for any but the first.
#[unsafe(no_mangle)]
#[allow(non_snake_case)]
pub extern "C" fn OfxGetPlugin(nth: c_int) -> *mut OfxPlugin {
    if nth == 0 {
        // Hosts only read it, although the pointer of the standard is not const.
        (&raw const PLUGIN).cast_mut()
    } else {
        null_mut()
    }
}

/// Receives the host before any other call (since OpenFX 1.4; Fusion requires this export).
#[unsafe(no_mangle)]
#[allow(non_snake_case)]
pub extern "C" fn OfxSetHost(host: *const OfxHost) -> OfxStatus {
    host::set_host(host.cast_mut());
    STATUS_OK
}

unsafe extern "C" fn set_host(host: *mut OfxHost) {
    host::set_host(host);
}

unsafe extern "C" fn main_entry(
    action: *const c_char,
    handle: *const c_void,
    inputs: Handle,
    outputs: Handle,
) -> OfxStatus {
    let status = host::catch_panic(|| {
        if action.is_null() {
            return STATUS_FAILED;
        }
        // SAFETY: the host passes the name of an action as a C string.
        let action = unsafe { CStr::from_ptr(action) };
        actions::perform(action, handle.cast_mut(), inputs, outputs)
    });
    status.unwrap_or(STATUS_FAILED)
}

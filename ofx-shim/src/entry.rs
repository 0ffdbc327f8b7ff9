//! What the binary exports, and the plugin's main entry.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::null_mut;

use crate::sys::effect::API;
use crate::sys::plugin::{STATUS_FAILED, STATUS_OK};
use crate::sys::{Handle, OfxHost, OfxPlugin, OfxStatus};
use crate::{actions, host};

/// Never changed: projects keep it. Dots alone: some hosts rewrite other marks.
pub(crate) const IDENTIFIER: &CStr = c"org.seidel.lensblur";

/// Grows when the same knobs make another picture; hosts keep versions apart.
const MAJOR: u32 = 1;
/// Grows with repairs.
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

/// How many plugins the binary holds.
#[unsafe(no_mangle)]
#[allow(non_snake_case)]
pub extern "C" fn OfxGetNumberOfPlugins() -> c_int {
    1
}

/// The plugin; NULL for any other than the first.
#[unsafe(no_mangle)]
#[allow(non_snake_case)]
pub extern "C" fn OfxGetPlugin(nth: c_int) -> *mut OfxPlugin {
    match nth {
        // Hosts read it; the pointer is not const in the standard only.
        0 => (&raw const PLUGIN).cast_mut(),
        _ => null_mut(),
    }
}

/// Gets the host before anything else (since 1.4; Fusion wants it to be there).
#[unsafe(no_mangle)]
#[allow(non_snake_case)]
pub extern "C" fn OfxSetHost(given: *const OfxHost) -> OfxStatus {
    host::set_host(given.cast_mut());
    STATUS_OK
}

unsafe extern "C" fn set_host(given: *mut OfxHost) {
    host::set_host(given);
}

unsafe extern "C" fn main_entry(
    action: *const c_char,
    handle: *const c_void,
    inputs: Handle,
    outputs: Handle,
) -> OfxStatus {
    let done = host::catch_panic(|| {
        if action.is_null() {
            return STATUS_FAILED;
        }
        // SAFETY: hosts give the name of an action, a text with a zero at its end.
        let action = unsafe { CStr::from_ptr(action) };
        actions::perform(action, handle.cast_mut(), inputs, outputs)
    });
    done.unwrap_or(STATUS_FAILED)
}

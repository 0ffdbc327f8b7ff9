//! A box blur as an OpenFX plugin, once as it should be and once for each fault that it can have.
//!
//! Every variant is a plugin of its own in the binary, `org.seidel.box.` and the fault's name, so that one process can
//! try them all.

mod actions;
mod api;
mod blur;
mod faults;
mod image;
mod state;

use std::ffi::{c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

use openfx::sys::generic::core::*;

use faults::{COUNT, Fault, IDS};

/// A table that is never written to.
struct Table([OfxPlugin; COUNT]);

// SAFETY: nothing in it changes.
unsafe impl Sync for Table {}

unsafe extern "C" fn set_host<const N: usize>(host: *mut OfxHost) {
    // Nothing in it panics.
    state::set_host(Fault::of(N), host);
}

unsafe extern "C" fn main_entry<const N: usize>(
    action: *const c_char,
    handle: *const c_void,
    given: OfxPropertySetHandle,
    wanted: OfxPropertySetHandle,
) -> OfxStatus {
    let done = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the host names the action by a string.
        let action = unsafe { api::text_at(action) };
        actions::act(Fault::of(N), &action, handle, given, wanted)
    }));
    done.unwrap_or(kOfxStatFailed)
}

macro_rules! plugins {
    ($($n:literal)*) => {
        Table([$(OfxPlugin {
            pluginApi: c"OfxImageEffectPluginAPI".as_ptr(),
            apiVersion: 1,
            pluginIdentifier: IDS[$n].as_ptr(),
            pluginVersionMajor: 1,
            pluginVersionMinor: 0,
            setHost: Some(set_host::<$n>),
            mainEntry: Some(main_entry::<$n>),
        }),*])
    };
}

static PLUGINS: Table = plugins!(
    0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40 41
    42 43
);

/// How many plugins there are.
#[unsafe(no_mangle)]
pub extern "C" fn OfxGetNumberOfPlugins() -> c_int {
    c_int::try_from(COUNT).unwrap_or(0)
}

/// One of them, NULL if there is none of that number.
#[unsafe(no_mangle)]
pub extern "C" fn OfxGetPlugin(nth: c_int) -> *mut OfxPlugin {
    usize::try_from(nth)
        .ok()
        .and_then(|n| PLUGINS.0.get(n))
        .map_or(std::ptr::null_mut(), |plugin| {
            (plugin as *const OfxPlugin).cast_mut()
        })
}

//! The OpenFX 1.4 image effect ABI as far as this plugin speaks it: structs of function pointers, status codes and the
//! names of suites, actions and properties, as the standard has them (openeffects.org). One suite a file.
//!
//! Every function of a suite may be missing: hosts leave out what they do not know.

pub mod actions;
pub mod clip;
pub mod draw;
pub mod effect;
pub mod interact;
pub mod message;
pub mod multi_thread;
pub mod param;
pub mod plugin;
pub mod property;

pub use plugin::{
    OfxEntry, OfxHost, OfxPlugin, OfxPointD, OfxRectD, OfxRectI, OfxSetHostFn, OfxStatus,
};

/// A handle of the host's, of which nothing is known but where it is.
pub type Handle = *mut std::ffi::c_void;

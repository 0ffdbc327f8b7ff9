//! Declarations of the OpenFX image effect API, version 1.4, and of the draw suite and the colour management of 1.5, as
//! far as this plugin uses them: structs of function pointers, status codes, and names of suites, actions and
//! properties. One suite per file. Sections are those of the OpenFX reference (<https://openfx.readthedocs.io>).
//!
//! Every function of a suite is an `Option`, because hosts leave out functions that they do not implement.

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

/// An opaque handle of the host: an effect, a clip, an image, a property set, a parameter, an interact…
pub type Handle = *mut std::ffi::c_void;

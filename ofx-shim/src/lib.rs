//! Seidel's OpenFX plugin: actions, knobs, clips and host suites on top of the C ABI of `seidel-plugin`.
//!
//! `sys` is the ABI of OpenFX as it is, `host` the same behind safe names. `actions` holds what hosts ask for, one action
//! a file; `knobs` and `clips` what they are shown; `rendering` turns a frame of theirs into a plate of the library's,
//! `colour` its codes into light.
//! Every function that a host calls goes through `host::catch_panic`: no panic leaves the plugin.

mod actions;
mod clips;
mod colour;
mod depth;
mod entry;
mod ffi;
mod geometry;
mod host;
mod kept;
mod knobs;
mod lens;
mod overlay;
mod pixels;
mod rendering;
mod setup;
pub mod sys;

pub use entry::{OfxGetNumberOfPlugins, OfxGetPlugin, OfxSetHost};

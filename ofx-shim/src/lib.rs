//! Seidel's OpenFX plugin: actions, parameters, clips and host suites around `seidel-core`.
//!
//! Imports point one way: `actions` (one action a file) and `overlay` use `rendering`, which reads a frame of the host as a
//! plate and renders it; `rendering` uses `settings`, `depth`, `colour` and `lens`; these use `knobs` and `host`, the host
//! behind safe functions; `host` uses `sys`, the ABI of OpenFX. `unsafe` is in `entry`, `overlay`, `host` and `sys` only.
//! Every function that a host calls goes through `host::catch_panic`, so that no panic leaves the plugin.

mod actions;
mod clips;
mod colour;
mod depth;
mod entry;
mod errors;
mod expansion;
mod file_cache;
mod file_reference;
mod geometry;
mod host;
mod interleaved;
mod knobs;
mod lens;
mod lens_data;
mod overlay;
mod plate_image;
mod remarks;
mod rendering;
mod settings;
pub mod sys;
mod threads;

pub use entry::{OfxGetNumberOfPlugins, OfxGetPlugin, OfxSetHost};

//! Lenses: those of files, cached until the files change, and those that come with the plugin.

pub(crate) mod built_in;
mod cache;
mod kernel;

pub(crate) use cache::{LensOrigin, clear, load};
pub(crate) use kernel::{KernelSource, grid_points};

//! Lenses: those of files, cached until the files change, and those that come with the plugin.

pub(crate) mod built_in;
mod cache;
mod folder;
mod kernel;

pub(crate) use cache::{LensOrigin, clear, load};
pub(crate) use folder::names as folder_names;
pub(crate) use kernel::{KernelRequest, KernelSource, grid_points};

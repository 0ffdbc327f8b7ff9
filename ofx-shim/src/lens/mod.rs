//! Lenses: those of files, kept while they stay as they are, and those that come with the plugin.

pub(crate) mod built_in;
mod cache;
mod info;
mod kernel;

pub(crate) use cache::{Choice, Lens, forget, lens};
pub(crate) use info::Info;
pub(crate) use kernel::points;

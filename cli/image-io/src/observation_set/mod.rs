//! PSF observation sets on disk: `manifest.json` and the tiles it names.

mod entry;
mod fields;
mod read;
mod write;

pub use read::{Dropped, Loaded, ReadOptions, read};
pub use write::{add_set, write};

/// Name of the manifest in a set's folder.
pub const MANIFEST: &str = "manifest.json";

/// Value of the `format` key.
const FORMAT: &str = "psf-observations";

/// The version that is read and written.
const VERSION: u64 = 1;

//! PSF observation sets as folders: `manifest.json` and the image files of the tiles.

mod entry;
mod fields;
mod read;
mod write;

pub use read::{LoadedSet, ReadOptions, SkippedObservation, read};
pub use write::{write, write_into};

/// Name of the manifest in the folder of a set.
pub const MANIFEST: &str = "manifest.json";

/// Value of the key `format`.
const FORMAT: &str = "psf-observations";

/// The supported value of the key `version`.
const VERSION: u64 = 1;

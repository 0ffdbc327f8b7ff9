//! PSF observation sets as folders: `manifest.json` and the image files of the tiles.

mod faults;
mod observation_entry;
mod read;
mod set_entry;
mod text;
mod write;

pub use read::{LoadedSet, ReadOptions, SkippedObservation, read};
pub use write::{write, write_into};

/// Name of the manifest in the folder of a set.
pub const MANIFEST: &str = "manifest.json";

/// Value of the key `format`.
const FORMAT: &str = "psf-observations";

/// Value of the key `version` of sets whose tiles hold every channel at every pixel.
const VERSION: u64 = 1;

/// Value of the key `version` of sets whose tiles are raw pixels of a colour filter mosaic.
const MOSAIC_VERSION: u64 = 2;

/// Name of the only plane of a mosaic's tile, and of a weight mask.
const PLANE: &str = "Y";

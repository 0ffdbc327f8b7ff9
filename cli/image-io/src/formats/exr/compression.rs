//! Compression of OpenEXR files: the user's choice, and which methods are lossy.

use exr::image::{AnyChannel, FlatSamples, Levels};
use exr::prelude::Compression;

use super::samples::full_level;

/// A compression method of OpenEXR.
// The comments of the variants are help texts of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ExrCompression {
    /// No compression
    None,
    /// Run-length encoding
    Rle,
    /// Deflate, one scan line per block
    Zips,
    /// Deflate, sixteen scan lines per block
    Zip,
    /// Wavelets: small for grain
    Piz,
    /// Deflate; floats are rounded to 24 bits
    Pxr24,
    /// Half floats at a fixed rate, lossy
    B44,
    /// B44 with smaller flat areas, lossy
    B44a,
    /// Cosine transform of 32 scan lines, lossy
    Dwaa,
    /// Cosine transform of 256 scan lines, lossy
    Dwab,
}

impl ExrCompression {
    pub(super) fn method(self) -> Compression {
        match self {
            Self::None => Compression::Uncompressed,
            Self::Rle => Compression::RLE,
            Self::Zips => Compression::ZIP1,
            Self::Zip => Compression::ZIP16,
            Self::Piz => Compression::PIZ,
            Self::Pxr24 => Compression::PXR24,
            Self::B44 => Compression::B44,
            Self::B44a => Compression::B44A,
            Self::Dwaa => Compression::DWAA(None),
            Self::Dwab => Compression::DWAB(None),
        }
    }
}

/// Returns whether a compression is lossy for `channels`.
pub(super) fn is_lossy(
    compression: Compression,
    channels: &[AnyChannel<Levels<FlatSamples>>],
) -> bool {
    let is_float = |channel: &AnyChannel<Levels<FlatSamples>>| {
        full_level(&channel.sample_data).is_some_and(|s| matches!(s, FlatSamples::F32(_)))
    };
    match compression {
        Compression::B44 | Compression::B44A | Compression::DWAA(_) | Compression::DWAB(_) => true,
        // Rounds floats, but not half floats.
        Compression::PXR24 => channels.iter().any(is_float),
        _ => false,
    }
}

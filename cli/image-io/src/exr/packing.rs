//! How EXR files are packed: as users may choose it, and what loses quality.

use exr::image::{AnyChannel, FlatSamples, Levels};
use exr::prelude::Compression;

use crate::exr::choice::ColourGroup;
use crate::exr::plate::{ExrPlate, full_level};

/// A compression of OpenEXR.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Packing {
    /// None
    None,
    /// Runs of equal bytes
    Rle,
    /// Deflate, line by line
    Zips,
    /// Deflate, sixteen lines at once
    Zip,
    /// Wavelets: small for grain
    Piz,
    /// Deflate; floats keep 24 bits
    Pxr24,
    /// Half floats at a fixed rate, with loss
    B44,
    /// The same, flat areas smaller
    B44a,
    /// Cosine transform of 32 lines, with loss
    Dwaa,
    /// The same of 256 lines
    Dwab,
}

impl Packing {
    pub(crate) fn compression(self) -> Compression {
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

/// Whether `channels` lose quality by a compression.
pub(crate) fn loses(
    compression: Compression,
    channels: &[AnyChannel<Levels<FlatSamples>>],
) -> bool {
    let is_float = |channel: &AnyChannel<Levels<FlatSamples>>| {
        full_level(&channel.sample_data).is_some_and(|s| matches!(s, FlatSamples::F32(_)))
    };
    match compression {
        Compression::B44 | Compression::B44A | Compression::DWAA(_) | Compression::DWAB(_) => true,
        // Loses bits of floats only.
        Compression::PXR24 => channels.iter().any(is_float),
        _ => false,
    }
}

impl ExrPlate {
    /// Packs the part of `group` by another compression; ZIP where that would spoil channels that are no colour.
    pub(crate) fn pack(&mut self, group: &ColourGroup, packing: Packing) {
        let part = group.colour[0].part();
        let colours: Vec<_> = (group.colour.iter())
            .chain(&group.alpha)
            .chain(&group.own_alpha)
            .collect();
        let others = self.channels().into_iter();
        let others = others.filter(|c| c.id.part() == part && !colours.contains(&&c.id));
        let others: Vec<String> = others.map(|c| c.name).collect();
        let wanted = packing.compression();
        let spoils = !others.is_empty() && self.would_lose(part, wanted);
        self.set_compression(part, if spoils { Compression::ZIP16 } else { wanted });
        if spoils {
            self.note(format!(
                "{wanted} would spoil {}, which are in the same part: it is written with ZIP",
                others.join(", ")
            ));
        }
    }
}

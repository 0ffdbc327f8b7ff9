//! The metadata of a TIFF file.

use std::io::{Read, Seek};
use std::path::Path;

use tiff::decoder::Decoder;
use tiff::tags::{ExtraSamples, IfdPointer, Tag, Type};

use super::tags::{
    DIRECTORIES, MAKER_NOTE, PHOTOSHOP_LAYERS, SUB_IFDS, StoredTag, StoredTags, read_tags,
};
use crate::error::Result;
use crate::metadata::TextAttributes;
use crate::raster::{AssumedEncoding, Metadata, RasterImage};

/// The metadata of a TIFF file.
#[derive(Debug, Clone, Default)]
pub(super) struct TiffMetadata {
    pub(super) stored: StoredTags,
    has_more_pages: bool,
    /// Whether the file states another orientation than upright.
    is_rotated: bool,
    /// Tags that do not pass through and are not about the storage of the pixels.
    lost: Vec<u16>,
}

/// Tags that state the colour space of the samples, with their names for messages.
const COLOUR_SPACE: [(u16, &str); 5] = [
    (301, "TransferFunction"),
    (318, "WhitePoint"),
    (319, "PrimaryChromaticities"),
    (342, "TransferRange"),
    (ICC_PROFILE, "the ICC profile"),
];

/// The orientation of pixels that are stored as they are seen: rows from the top, columns from the left.
const UPRIGHT: u16 = 1;
const ICC_PROFILE: u16 = 34_675;

/// Names of tags that are texts.
const TEXT_TAGS: [(u16, &str); 12] = [
    (269, "DocumentName"),
    (270, "ImageDescription"),
    (271, "Make"),
    (272, "Model"),
    (285, "PageName"),
    (305, "Software"),
    (306, "DateTime"),
    (315, "Artist"),
    (316, "HostComputer"),
    (33_432, "Copyright"),
    (36_867, "DateTimeOriginal"),
    (42_036, "LensModel"),
];

impl TiffMetadata {
    /// Creates the metadata of a new file. `premultiplied` is the meaning of its alpha, if it has any.
    pub(super) fn new(premultiplied: Option<bool>, icc_profile: Option<Vec<u8>>) -> Self {
        let tag = |tag, kind, bytes| StoredTag { tag, kind, bytes };
        // The format requires a resolution, which is unknown.
        let one = [1_u32.to_ne_bytes(), 1_u32.to_ne_bytes()].concat();
        let no_unit = 1_u16.to_ne_bytes().to_vec();
        let mut tags = vec![
            tag(Tag::XResolution.to_u16(), Type::RATIONAL, one.clone()),
            tag(Tag::YResolution.to_u16(), Type::RATIONAL, one),
            tag(Tag::ResolutionUnit.to_u16(), Type::SHORT, no_unit),
        ];
        tags.extend(icc_profile.map(|bytes| tag(ICC_PROFILE, Type::UNDEFINED, bytes)));
        let alpha = premultiplied.map(|premultiplied| {
            if premultiplied {
                ExtraSamples::AssociatedAlpha
            } else {
                ExtraSamples::UnassociatedAlpha
            }
        });
        let stored = StoredTags {
            tags,
            alpha,
            ..StoredTags::default()
        };
        Self {
            stored,
            ..Self::default()
        }
    }

    /// Reads the metadata of a file whose alpha is of the kind `alpha`. Unreadable tags are lost.
    pub(super) fn read<R: Read + Seek>(
        decoder: &mut Decoder<R>,
        alpha: Option<ExtraSamples>,
    ) -> Self {
        let mut lost = Vec::new();
        let has_more_pages = decoder.more_images();
        let orientation = decoder.find_tag_unsigned::<u16>(Tag::Orientation);
        let is_rotated = orientation
            .ok()
            .flatten()
            .is_some_and(|value| value != UPRIGHT);
        let tags = read_tags(decoder.image_ifd(), &mut lost);
        let mut directories = Vec::new();
        for tag in DIRECTORIES {
            let Ok(Some(offset)) = decoder.find_tag_unsigned::<u64>(tag) else {
                continue;
            };
            match decoder.read_directory(IfdPointer(offset)) {
                Ok(directory) => {
                    let own = read_tags(decoder.read_directory_tags(&directory), &mut lost);
                    if !own.is_empty() {
                        directories.push((tag, own));
                    }
                }
                Err(_) => lost.push(tag.to_u16()),
            }
        }
        let stored = StoredTags {
            tags,
            directories,
            alpha,
        };
        Self {
            stored,
            has_more_pages,
            is_rotated,
            lost,
        }
    }
}

impl Metadata for TiffMetadata {
    fn write(&self, path: &Path, image: &RasterImage) -> Result<()> {
        super::write::write(path, image, &self.stored)
    }

    fn is_premultiplied(&self) -> bool {
        self.stored.alpha == Some(ExtraSamples::AssociatedAlpha)
    }

    fn icc_profile(&self) -> Option<&[u8]> {
        let tag = self.stored.tags.iter().find(|tag| tag.tag == ICC_PROFILE)?;
        Some(&tag.bytes)
    }

    fn remove_colour_space(&mut self) -> Vec<String> {
        let has = |wanted: u16| self.stored.tags.iter().any(|own| own.tag == wanted);
        let removed = COLOUR_SPACE.iter().filter(|(tag, _)| has(*tag));
        let names = removed.map(|(_, name)| (*name).to_owned()).collect();
        self.stored
            .tags
            .retain(|own| COLOUR_SPACE.iter().all(|(tag, _)| own.tag != *tag));
        names
    }

    /// Returns the tags that are texts.
    fn summary(&self) -> TextAttributes {
        let directories = self.stored.directories.iter().flat_map(|(_, tags)| tags);
        let all = self.stored.tags.iter().chain(directories);
        let texts = all.filter(|own| own.kind == Type::ASCII).map(|own| {
            let known = TEXT_TAGS.iter().find(|(tag, _)| *tag == own.tag);
            let name = known.map_or_else(|| format!("tag {}", own.tag), |(_, n)| (*n).to_owned());
            let text = String::from_utf8_lossy(&own.bytes);
            (name, text.trim_end_matches('\0').to_owned())
        });
        texts.collect()
    }

    fn read_warning(&self, _encoding: AssumedEncoding) -> Option<String> {
        self.is_rotated.then(|| {
            "the orientation of the TIFF is ignored: pixels are taken as they are stored".to_owned()
        })
    }

    fn rewrite_losses(&self, _image: &RasterImage) -> Vec<String> {
        if self.lost.is_empty() {
            return Vec::new();
        }
        let name = |tag: &u16| match *tag {
            SUB_IFDS => "SubIFDs".to_owned(),
            MAKER_NOTE => "the maker's note".to_owned(),
            PHOTOSHOP_LAYERS => "Photoshop's layers".to_owned(),
            other => other.to_string(),
        };
        let names: Vec<String> = self.lost.iter().map(name).collect();
        vec![format!(
            "tags that are not valid in the new file are left out: {}",
            names.join(", ")
        )]
    }

    fn conversion_loss(&self, _kept: &[&str]) -> Option<String> {
        let has_others = self.stored.tags.iter().any(|tag| tag.tag != ICC_PROFILE);
        (has_others || !self.stored.directories.is_empty())
            .then(|| "the tags of the TIFF".to_owned())
    }

    fn multiple_images(&self) -> Option<&'static str> {
        self.has_more_pages.then_some("page of the TIFF")
    }
}

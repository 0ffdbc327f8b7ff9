//! The tags of a TIFF file that pass through.

use tiff::decoder::IfdDecoder;
use tiff::tags::{ByteOrder, ExtraSamples, Tag, Type, ValueBuffer};

/// The tags of an image that pass through.
#[derive(Debug, Clone, Default)]
pub(super) struct StoredTags {
    pub(super) tags: Vec<StoredTag>,
    /// The EXIF and GPS directories, each with the tag that points to it.
    pub(super) directories: Vec<(Tag, Vec<StoredTag>)>,
    /// The ExtraSamples value of the alpha channel: premultiplied or not; `None` if not stated.
    pub(super) alpha: Option<ExtraSamples>,
}

/// A tag with its value in the byte order of this machine.
#[derive(Debug, Clone)]
pub(super) struct StoredTag {
    pub(super) tag: u16,
    pub(super) kind: Type,
    pub(super) bytes: Vec<u8>,
}

/// ImageHistory of TIFF/EP, which stores the provenance.
pub(super) const IMAGE_HISTORY: Tag = Tag::Unknown(37_395);

/// Tags about the storage of the pixels, by TIFF 6.0 and libtiff. A new file has its own.
const STORAGE: [std::ops::RangeInclusive<u16>; 14] = [
    // NewSubfileType to PhotometricInterpretation, FillOrder, StripOffsets, and SamplesPerPixel to MaxSampleValue.
    254..=268,
    273..=273,
    277..=281,
    284..=284,
    // Free space, grey response, fax.
    288..=293,
    317..=317,
    // ColorMap; tiles; fax.
    320..=328,
    // ExtraSamples to SMaxSampleValue.
    338..=341,
    346..=347,
    // JPEG, and YCbCr.
    512..=521,
    529..=532,
    559..=559,
    // Matteing, DataType, ImageDepth, TileDepth.
    32_995..=32_998,
    37_395..=37_395,
];

/// SubIFDs: further images, or pointers to anywhere.
pub(super) const SUB_IFDS: u16 = 330;
/// The maker's note of EXIF, which may point into the old file.
pub(super) const MAKER_NOTE: u16 = 37_500;
/// The layers of Photoshop, which shows them in place of the image.
pub(super) const PHOTOSHOP_LAYERS: u16 = 37_724;

/// Tags that do not pass through; also Interoperability of EXIF and further annotations of Photoshop.
const EXCLUDED: [u16; 5] = [SUB_IFDS, PHOTOSHOP_LAYERS, MAKER_NOTE, 40_965, 50_255];

/// Tags that point to a directory that passes through.
pub(super) const DIRECTORIES: [Tag; 2] = [Tag::ExifDirectory, Tag::GpsDirectory];

/// Reads the tags of a directory that pass through. Others that are not about storage are added to `lost`.
pub(super) fn read_tags(mut directory: IfdDecoder<'_>, lost: &mut Vec<u16>) -> Vec<StoredTag> {
    let all: Vec<Tag> = directory.directory().iter().map(|(tag, _)| tag).collect();
    let mut stored = Vec::new();
    for tag in all {
        let number = tag.to_u16();
        if STORAGE.iter().any(|range| range.contains(&number)) || DIRECTORIES.contains(&tag) {
            continue;
        }
        let mut value = ValueBuffer::empty(Type::BYTE);
        let found = directory.find_tag_buf(tag, &mut value);
        let is_pointer = matches!(
            value.data_type(),
            Type::IFD | Type::IFD8 | Type::LONG8 | Type::SLONG8
        );
        if found.is_err() || is_pointer || EXCLUDED.contains(&number) {
            lost.push(number);
        } else if !value.as_bytes().is_empty() {
            value.set_byte_order(ByteOrder::native());
            stored.push(StoredTag {
                tag: number,
                kind: value.data_type(),
                bytes: value.as_bytes().to_vec(),
            });
        }
    }
    stored
}

//! The tags of a TIFF file beside its pixels: which there are, and which are carried over.

use std::io::{Read, Seek};

use tiff::decoder::{Decoder, IfdDecoder};
use tiff::tags::{ByteOrder, ExtraSamples, IfdPointer, Tag, Type, ValueBuffer};

use crate::provenance::Texts;

/// What a TIFF file holds beside its pixels and is written back.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Carried {
    pub(crate) tags: Vec<CarriedTag>,
    /// Directories beside that of the picture, each with the tag that points to it: EXIF and GPS.
    pub(crate) directories: Vec<(Tag, Vec<CarriedTag>)>,
    /// The ExtraSamples value of the alpha channel: premultiplied or not; `None` where not said.
    pub(crate) alpha: Option<ExtraSamples>,
    /// Whether the file has further pages, which are not carried over.
    pub(crate) more_pages: bool,
    /// Tags that are not carried over and do not only say how the old file was stored.
    left_out: Vec<u16>,
}

/// A tag with its value in the byte order of this machine.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CarriedTag {
    pub(crate) tag: u16,
    pub(crate) kind: Type,
    pub(crate) bytes: Vec<u8>,
}

/// What was done to the picture, in TIFF/EP's ImageHistory: our texts, told apart from other tags.
pub(crate) const IMAGE_HISTORY: Tag = Tag::Unknown(37_395);

/// Tags that say how pixels are stored, which the new file has its own of: TIFF 6.0, and what libtiff adds to it.
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

/// Tags that say what codes are as colour: TransferFunction, WhitePoint, PrimaryChromaticities, TransferRange, ICC.
const COLOUR: [u16; 5] = [301, 318, 319, 342, PROFILE];

const PROFILE: u16 = 34_675;

/// Names of texts.
const TEXTS: [(u16, &str); 12] = [
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

/// Tags that do not go along: SubIFDs, which are pictures or point anywhere; Photoshop's layers, which that program shows
/// in place of the picture; in EXIF the maker's note, which may point into the old file, and Interoperability.
const NOT_CARRIED: [u16; 5] = [330, 37_724, 37_500, 40_965, 50_255];

/// Tags that point to a directory that is carried over.
const DIRECTORIES: [Tag; 2] = [Tag::ExifDirectory, Tag::GpsDirectory];

impl Carried {
    /// What a new file holds beside the pixels: what its alpha means, where there is one, and a colour profile. The format
    /// asks for a resolution, which is not known.
    pub(crate) fn new(premultiplied: Option<bool>, icc: Option<Vec<u8>>) -> Self {
        let tag = |tag, kind, bytes| CarriedTag { tag, kind, bytes };
        let one = [1_u32.to_ne_bytes(), 1_u32.to_ne_bytes()].concat();
        let unknown = 1_u16.to_ne_bytes().to_vec();
        let mut tags = vec![
            tag(Tag::XResolution.to_u16(), Type::RATIONAL, one.clone()),
            tag(Tag::YResolution.to_u16(), Type::RATIONAL, one),
            tag(Tag::ResolutionUnit.to_u16(), Type::SHORT, unknown),
        ];
        tags.extend(icc.map(|bytes| tag(PROFILE, Type::UNDEFINED, bytes)));
        Self {
            tags,
            alpha: premultiplied.map(|premultiplied| match premultiplied {
                true => ExtraSamples::AssociatedAlpha,
                false => ExtraSamples::UnassociatedAlpha,
            }),
            ..Self::default()
        }
    }

    /// What the file of `decoder` holds, whose alpha is of the kind `alpha`. Tags that do not read are left out: they are no
    /// part of the picture.
    pub(crate) fn read<R: Read + Seek>(
        decoder: &mut Decoder<R>,
        alpha: Option<ExtraSamples>,
    ) -> Self {
        let mut carried = Self {
            alpha,
            more_pages: decoder.more_images(),
            ..Self::default()
        };
        let mut left_out = Vec::new();
        carried.tags = tags(decoder.image_ifd(), &mut left_out);
        for tag in DIRECTORIES {
            let Ok(Some(at)) = decoder.find_tag_unsigned::<u64>(tag) else {
                continue;
            };
            match decoder.read_directory(IfdPointer(at)) {
                Ok(directory) => {
                    let own = tags(decoder.read_directory_tags(&directory), &mut left_out);
                    if !own.is_empty() {
                        carried.directories.push((tag, own));
                    }
                }
                Err(_) => left_out.push(tag.to_u16()),
            }
        }
        carried.left_out = left_out;
        carried
    }

    /// The colour profile.
    pub(crate) fn icc(&self) -> Option<Vec<u8>> {
        let own = self.tags.iter().find(|tag| tag.tag == PROFILE)?;
        Some(own.bytes.clone())
    }

    /// Whether there are tags beside a colour profile.
    pub(crate) fn has_texts(&self) -> bool {
        let others = self.tags.iter().any(|tag| tag.tag != PROFILE);
        others || !self.directories.is_empty()
    }

    /// Whether the file says that its colour is premultiplied by alpha.
    pub(crate) fn is_premultiplied(&self) -> bool {
        self.alpha == Some(ExtraSamples::AssociatedAlpha)
    }

    /// The tags that are texts, each with its name.
    pub(crate) fn texts(&self) -> Texts {
        let directories = self.directories.iter().flat_map(|(_, tags)| tags);
        let all = self.tags.iter().chain(directories);
        let texts = all.filter(|own| own.kind == Type::ASCII).map(|own| {
            let known = TEXTS.iter().find(|(tag, _)| *tag == own.tag);
            let name = known.map_or_else(|| format!("tag {}", own.tag), |(_, n)| (*n).to_owned());
            let text = String::from_utf8_lossy(&own.bytes);
            (name, text.trim_end_matches('\0').to_owned())
        });
        texts.collect()
    }

    /// Tags that are not carried over, in words.
    pub(crate) fn left_out(&self) -> Vec<String> {
        let name = |&tag: &u16| match tag {
            330 => "SubIFDs".to_owned(),
            37_500 => "the maker's note".to_owned(),
            37_724 => "Photoshop's layers".to_owned(),
            other => other.to_string(),
        };
        self.left_out.iter().map(name).collect()
    }

    /// Takes away what says of what colour space codes are; the names of that.
    pub(crate) fn drop_colour(&mut self) -> Vec<String> {
        let names = [
            "TransferFunction",
            "WhitePoint",
            "PrimaryChromaticities",
            "TransferRange",
            "the colour profile (ICC)",
        ];
        let has = |tag: &u16| self.tags.iter().any(|own| own.tag == *tag);
        let pairs = COLOUR.iter().zip(names).filter(|(tag, _)| has(tag));
        let names = pairs.map(|(_, name)| name.to_owned()).collect();
        self.tags.retain(|own| !COLOUR.contains(&own.tag));
        names
    }
}

/// The tags of a directory that are carried over; others that matter go to `left_out`.
fn tags(mut directory: IfdDecoder<'_>, left_out: &mut Vec<u16>) -> Vec<CarriedTag> {
    let all: Vec<Tag> = directory.directory().iter().map(|(tag, _)| tag).collect();
    let mut carried = Vec::new();
    for tag in all {
        let number = tag.to_u16();
        if STORAGE.iter().any(|range| range.contains(&number)) || DIRECTORIES.contains(&tag) {
            continue;
        }
        let mut value = ValueBuffer::empty(Type::BYTE);
        let found = directory.find_tag_buf(tag, &mut value);
        let plain = !matches!(
            value.data_type(),
            Type::IFD | Type::IFD8 | Type::LONG8 | Type::SLONG8
        );
        if found.is_err() || !plain || NOT_CARRIED.contains(&number) {
            left_out.push(number);
        } else if !value.as_bytes().is_empty() {
            value.set_byte_order(ByteOrder::native());
            carried.push(CarriedTag {
                tag: number,
                kind: value.data_type(),
                bytes: value.as_bytes().to_vec(),
            });
        }
    }
    carried
}

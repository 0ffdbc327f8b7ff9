//! TIFF files: 8 and 16 bit, half and float, one page.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::decoder::{Decoder, DecodingResult};
use tiff::encoder::colortype::{
    ColorType as EncodedType, Gray8, Gray16, Gray32Float, RGB8, RGB16, RGB32Float, RGBA8, RGBA16,
    RGBA32Float,
};
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{Compression, TiffEncoder, TiffValue};
use tiff::tags::{ByteOrder, ExtraSamples, Tag, Type, ValueBuffer};
use tiff::{ColorType, Directory, TiffError};

use super::atomic::{Output, write_whole};
use super::error::{FileError, Result};
use super::flat_plate::{Container, FlatPlate, SampleDepth, names, to_u8, to_u16};
use super::guard::caught;
use super::limits::{Limits, open};
use super::provenance::{Texts, is_ours};

/// What a TIFF file holds beside its pixels and is written back.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Carried {
    tags: Vec<CarriedTag>,
    /// The ExtraSamples value of the alpha channel: premultiplied or not; `None` where not said.
    alpha: Option<ExtraSamples>,
    /// Whether the file has further pages, which are not carried over.
    pub(super) more_pages: bool,
}

impl Carried {
    /// What a new file holds beside the pixels: what its alpha means, where there is one, and a colour profile.
    pub(super) fn new(premultiplied: Option<bool>, icc: Option<Vec<u8>>) -> Self {
        let profile = icc.map(|bytes| CarriedTag {
            tag: Tag::IccProfile.to_u16(),
            kind: Type::UNDEFINED,
            bytes,
        });
        Self {
            tags: profile.into_iter().collect(),
            alpha: premultiplied.map(|premultiplied| match premultiplied {
                true => ExtraSamples::AssociatedAlpha,
                false => ExtraSamples::UnassociatedAlpha,
            }),
            more_pages: false,
        }
    }

    /// The colour profile.
    pub(super) fn icc(&self) -> Option<Vec<u8>> {
        let profile = Tag::IccProfile.to_u16();
        let own = self.tags.iter().find(|tag| tag.tag == profile)?;
        Some(own.bytes.clone())
    }

    /// Whether there are tags beside a colour profile.
    pub(super) fn has_texts(&self) -> bool {
        let profile = Tag::IccProfile.to_u16();
        self.tags.iter().any(|tag| tag.tag != profile)
    }

    /// Whether the file says that its colour is premultiplied by alpha.
    pub(super) fn is_premultiplied(&self) -> bool {
        self.alpha == Some(ExtraSamples::AssociatedAlpha)
    }
}

#[derive(Debug, Clone, PartialEq)]
struct CarriedTag {
    tag: u16,
    kind: Type,
    bytes: Vec<u8>,
}

/// The tags that are carried over: those that say how to show, print or attribute the picture. The
/// others describe the layout of the old file or point into it.
const CARRIED: [Tag; 14] = [
    Tag::ImageDescription,
    Tag::Make,
    Tag::Model,
    Tag::Orientation,
    Tag::XResolution,
    Tag::YResolution,
    Tag::ResolutionUnit,
    Tag::Software,
    Tag::DateTime,
    Tag::Artist,
    Tag::HostComputer,
    Tag::Copyright,
    Tag::IccProfile,
    // XMP.
    Tag::Unknown(700),
];

/// Reads the first page of a TIFF file.
pub(super) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (file, length) = open(path)?;
    let refuse = |error: TiffError| refusal(path, error);
    let unsupported = |what: String| {
        FileError::new(
            path,
            "",
            format!("is a TIFF of a kind that is not supported ({what})"),
            "save it as grey or RGB, 8-bit, 16-bit or float, one page",
        )
    };
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(refuse)?;
    let (width, height) = decoder.dimensions().map_err(refuse)?;
    let (width, height) = (width as usize, height as usize);
    limits.check_sides(path, "ImageWidth, ImageLength", width, height)?;
    let kind = decoder.colortype().map_err(refuse)?;
    let stored = decoder
        .find_tag_unsigned::<u16>(Tag::SamplesPerPixel)
        .map_err(refuse)?
        .unwrap_or(1);
    let extra: Vec<u16> = decoder
        .find_tag_unsigned_vec(Tag::ExtraSamples)
        .map_err(refuse)?
        .unwrap_or_default();
    let (colour, alpha) = match kind {
        ColorType::Gray(_) => (false, false),
        // Grey with alpha comes under this name.
        ColorType::Multiband { num_samples: 2, .. } if matches!(extra[..], [1 | 2]) => {
            (false, true)
        }
        ColorType::RGB(_) => (true, false),
        ColorType::RGBA(_) => (true, true),
        other => return Err(unsupported(format!("{other:?}"))),
    };
    let names = names(colour, alpha);
    if usize::from(stored) != names.len() {
        return Err(unsupported(format!(
            "{stored} samples a pixel where {} are used",
            names.join(", ")
        )));
    }
    let sample_bytes = u128::from(kind.bit_depth().div_ceil(8));
    let bytes = width as u128 * height as u128 * names.len() as u128 * sample_bytes;
    limits.check_bytes(path, "ImageWidth, ImageLength", bytes * 5, length)?;
    let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);

    let mut room = tiff::decoder::Limits::default();
    room.decoding_buffer_size = bytes;
    room.intermediate_buffer_size = bytes.max(1 << 20).saturating_mul(4);
    room.ifd_value_size = 64 << 20;
    let mut decoder = decoder.with_limits(room);
    let carried = Carried {
        tags: carried_tags(&mut decoder),
        alpha: extra.first().and_then(|&v| ExtraSamples::from_u16(v)),
        more_pages: decoder.more_images(),
    };
    let mut data = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut data).map_err(refuse)?;
    let planar = layout.planes > 1;
    let count = names.len();
    let (planes, depth) = match &data {
        // Grey of fewer bits than eight would come packed.
        DecodingResult::U8(d) if kind.bit_depth() == 8 => (
            planes(d, count, planar, |s| f32::from(s) / 255.0),
            SampleDepth::U8,
        ),
        DecodingResult::U16(d) if kind.bit_depth() == 16 => (
            planes(d, count, planar, |s| f32::from(s) / 65535.0),
            SampleDepth::U16,
        ),
        DecodingResult::F16(d) => (planes(d, count, planar, |s| s.to_f32()), SampleDepth::F16),
        DecodingResult::F32(d) => (planes(d, count, planar, |s| s), SampleDepth::F32),
        _ => {
            return Err(unsupported(format!("{} bits a sample", kind.bit_depth())));
        }
    };
    if planes.len() != count || planes.iter().any(|p| p.len() != width * height) {
        return Err(damaged(path, "pixels are missing"));
    }
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Tiff(carried),
        depth,
        width,
        height,
        names,
        planes,
        texts: history(&mut decoder),
    })
}

fn planes<T: Copy>(
    data: &[T],
    count: usize,
    planar: bool,
    convert: impl Fn(T) -> f32,
) -> Vec<Vec<f32>> {
    if planar {
        data.chunks(data.len().div_ceil(count).max(1))
            .map(|plane| plane.iter().map(|&s| convert(s)).collect())
            .collect()
    } else {
        FlatPlate::planes_of(data, count, convert)
    }
}

/// The carried tags, those that do not read left out: they are no part of the picture.
fn carried_tags(decoder: &mut Decoder<BufReader<File>>) -> Vec<CarriedTag> {
    CARRIED
        .iter()
        .filter_map(|&tag| {
            let mut value = ValueBuffer::empty(Type::BYTE);
            decoder.image_ifd().find_tag_buf(tag, &mut value).ok()??;
            value.set_byte_order(ByteOrder::native());
            Some(CarriedTag {
                tag: tag.to_u16(),
                kind: value.data_type(),
                bytes: value.as_bytes().to_vec(),
            })
        })
        .collect()
}

/// What was done to the picture, in TIFF/EP's ImageHistory: a line a text, or more where it is indented.
const IMAGE_HISTORY: Tag = Tag::Unknown(37_395);

/// The texts of ImageHistory; what it holds otherwise is one text.
fn history(decoder: &mut Decoder<BufReader<File>>) -> Texts {
    let found = decoder.find_tag(IMAGE_HISTORY);
    let Some(text) = found
        .ok()
        .flatten()
        .and_then(|value| value.into_string().ok())
    else {
        return Texts::new();
    };
    let mut texts = Texts::new();
    for line in text.lines() {
        match (
            line.strip_prefix("  "),
            line.split_once(": "),
            texts.last_mut(),
        ) {
            (Some(more), _, Some((_, text))) => {
                text.push('\n');
                text.push_str(more);
            }
            (None, Some((name, text)), _) if is_ours(name) => {
                texts.push((name.to_owned(), text.to_owned()));
            }
            _ => return vec![("ImageHistory".to_owned(), text)],
        }
    }
    texts
}

/// The same as ImageHistory holds it.
fn as_history(texts: &Texts) -> String {
    let line = |(name, text): &(String, String)| match is_ours(name) {
        true => format!("{name}: {}", text.replace('\n', "\n  ")),
        false => text.clone(),
    };
    texts.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Writes a TIFF file, deflate compressed, whole or not at all.
pub(super) fn write(path: &Path, plate: &FlatPlate, carried: &Carried) -> Result<()> {
    let channels = plate.planes.len();
    // Alpha of unstated meaning is stored as it came, as a fourth sample without a word about it.
    let mute_alpha = channels == 4 && carried.alpha.is_none();
    write_whole(path, |out| {
        match (plate.depth, channels > 2, mute_alpha) {
            (SampleDepth::U8, false, _) => encode::<Gray8>(out, plate, carried, to_u8),
            (SampleDepth::U8, true, false) => encode::<RGB8>(out, plate, carried, to_u8),
            (SampleDepth::U8, true, true) => encode::<RGBA8>(out, plate, carried, to_u8),
            (SampleDepth::U16, false, _) => encode::<Gray16>(out, plate, carried, to_u16),
            (SampleDepth::U16, true, false) => encode::<RGB16>(out, plate, carried, to_u16),
            (SampleDepth::U16, true, true) => encode::<RGBA16>(out, plate, carried, to_u16),
            (_, false, _) => encode::<Gray32Float>(out, plate, carried, |s| s),
            (_, true, false) => encode::<RGB32Float>(out, plate, carried, |s| s),
            (_, true, true) => encode::<RGBA32Float>(out, plate, carried, |s| s),
        }
        .map_err(|error| error.to_string())
    })
}

/// Writes float planes as a new TIFF file, whole or not at all.
pub(super) fn write_float(
    path: &Path,
    width: usize,
    height: usize,
    names: Vec<String>,
    planes: Vec<Vec<f32>>,
) -> Result<()> {
    let carried = Carried::default();
    let plate = FlatPlate {
        path: path.to_path_buf(),
        container: Container::Tiff(carried.clone()),
        depth: SampleDepth::F32,
        width,
        height,
        names,
        planes,
        texts: Texts::new(),
    };
    write(path, &plate, &carried)
}

fn encode<C: EncodedType>(
    out: &mut Output<'_>,
    plate: &FlatPlate,
    carried: &Carried,
    convert: impl Fn(f32) -> C::Inner,
) -> std::result::Result<(), TiffError>
where
    [C::Inner]: TiffValue,
{
    let mut encoder =
        TiffEncoder::new(out)?.with_compression(Compression::Deflate(DeflateLevel::default()));
    let mut image = encoder.new_image::<C>(plate.width as u32, plate.height as u32)?;
    let beside_colour = plate.planes.len() - C::BITS_PER_SAMPLE.len();
    if let (1, Some(alpha)) = (beside_colour, carried.alpha) {
        image.extra_samples(&[alpha])?;
    }
    if !plate.texts.is_empty() {
        let history = as_history(&plate.texts);
        image.encoder().write_tag(IMAGE_HISTORY, &history[..])?;
    }
    for CarriedTag { tag, kind, bytes } in &carried.tags {
        let entry = image.encoder().write_entry_bytes(*kind, bytes)?;
        let mut directory = Directory::empty();
        directory.extend([(Tag::from_u16_exhaustive(*tag), entry)]);
        image.encoder().extend_from(&directory);
    }
    image.write_data(&plate.interleaved(convert))
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is no readable TIFF ({what})"),
        "save or copy the file again",
    )
}

fn refusal(path: &Path, error: TiffError) -> FileError {
    match error {
        TiffError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            FileError::io(path, "be read", &error)
        }
        TiffError::UnsupportedError(what) => FileError::new(
            path,
            "",
            format!("is a TIFF of a kind that is not supported ({what})"),
            "save it as grey or RGB, 8-bit, 16-bit or float, one page",
        ),
        error => damaged(path, &error.to_string()),
    }
}

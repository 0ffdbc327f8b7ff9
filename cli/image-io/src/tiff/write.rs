//! TIFF files written: strips of deflated rows, and all tags that the old file had and that still hold.

use std::path::Path;

use half::f16;
use rayon::prelude::*;
use tiff::encoder::compression::{CompressionAlgorithm, Deflate, DeflateLevel};
use tiff::encoder::{DirectoryEncoder, TiffEncoder, TiffKind};
use tiff::tags::{
    CompressionMethod, PhotometricInterpretation, PlanarConfiguration, SampleFormat, Tag,
};
use tiff::{Directory, TiffError};

use crate::atomic::{Output, write_whole};
use crate::error::Result;
use crate::flat_plate::{Container, FlatPlate, SampleDepth, to_half, to_u8, to_u16};
use crate::provenance::{Texts, is_ours};
use crate::tiff::tags::{Carried, CarriedTag, IMAGE_HISTORY};

/// Bytes of a strip before it is packed: readers take in a strip at once.
const STRIP_BYTES: usize = 1 << 20;

/// ImageHistory of the texts: a line a text, or more where it is indented.
fn as_history(texts: &Texts) -> String {
    let line = |(name, text): &(String, String)| match is_ours(name) {
        true => format!("{name}: {}", text.replace('\n', "\n  ")),
        false => text.clone(),
    };
    texts.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Writes a TIFF file, deflate compressed, whole or not at all.
pub(crate) fn write(path: &Path, plate: &FlatPlate, carried: &Carried) -> Result<()> {
    write_whole(path, |out| {
        encode(out, plate, carried).map_err(|error| error.to_string())
    })
}

/// Writes float planes as a new TIFF file, whole or not at all.
pub(crate) fn write_float(
    path: &Path,
    width: usize,
    height: usize,
    names: Vec<String>,
    planes: Vec<Vec<f32>>,
) -> Result<()> {
    let carried = Carried::new(None, None);
    let plate = FlatPlate {
        path: path.to_path_buf(),
        container: Container::Tiff(carried.clone()),
        depth: SampleDepth::F32,
        width,
        height,
        names,
        planes,
        texts: Texts::new(),
        changed: false,
        notes: Vec::new(),
    };
    write(path, &plate, &carried)
}

/// The bytes of some rows, pixel by pixel.
fn rows(plate: &FlatPlate, rows: std::ops::Range<usize>) -> Vec<u8> {
    let pixels = rows.start * plate.width..rows.end * plate.width;
    let mut bytes = Vec::new();
    for index in pixels {
        for plane in &plate.planes {
            let sample = plane[index];
            match plate.depth {
                SampleDepth::U8 => bytes.push(to_u8(sample)),
                SampleDepth::U16 => bytes.extend(to_u16(sample).to_ne_bytes()),
                SampleDepth::F16 => bytes.extend(f16::from_f32(to_half(sample)).to_ne_bytes()),
                _ => bytes.extend(sample.to_ne_bytes()),
            }
        }
    }
    bytes
}

fn encode(
    out: &mut Output<'_>,
    plate: &FlatPlate,
    carried: &Carried,
) -> std::result::Result<(), TiffError> {
    let (bits, format): (u16, _) = match plate.depth {
        SampleDepth::U8 => (8, SampleFormat::Uint),
        SampleDepth::U16 => (16, SampleFormat::Uint),
        SampleDepth::F16 => (16, SampleFormat::IEEEFP),
        _ => (32, SampleFormat::IEEEFP),
    };
    let channels = plate.planes.len();
    let row = (plate.width * channels * usize::from(bits / 8)).max(1);
    let height = STRIP_BYTES.div_ceil(row).min(plate.height.max(1));
    let starts: Vec<usize> = (0..plate.height).step_by(height).collect();
    let packed = |&start: &usize| -> std::io::Result<Vec<u8>> {
        let bytes = rows(plate, start..(start + height).min(plate.height));
        let mut packed = Vec::new();
        Deflate::with_level(DeflateLevel::default()).write_to(&mut packed, &bytes)?;
        Ok(packed)
    };
    let strips: Vec<Vec<u8>> = starts
        .par_iter()
        .map(packed)
        .collect::<std::io::Result<_>>()?;

    let mut encoder = TiffEncoder::new(out)?;
    let mut pointers = Vec::new();
    for (tag, tags) in &carried.directories {
        let mut directory = encoder.extra_directory()?;
        for tag in tags {
            put(&mut directory, tag)?;
        }
        pointers.push((*tag, directory.finish_with_offsets()?.offset));
    }
    let mut image = encoder.image_directory()?;
    let (mut offsets, mut sizes) = (Vec::new(), Vec::new());
    for strip in &strips {
        offsets.push(u32::try_from(image.write_data(&strip[..])?)?);
        sizes.push(u32::try_from(strip.len())?);
        // What is in a file begins at even places.
        if strip.len() % 2 == 1 {
            image.write_data(&[0_u8][..])?;
        }
    }
    let photometric = match channels {
        1 | 2 => PhotometricInterpretation::BlackIsZero,
        _ => PhotometricInterpretation::RGB,
    };
    image.write_tag(Tag::ImageWidth, u32::try_from(plate.width)?)?;
    image.write_tag(Tag::ImageLength, u32::try_from(plate.height)?)?;
    image.write_tag(Tag::BitsPerSample, &vec![bits; channels][..])?;
    image.write_tag(Tag::Compression, CompressionMethod::Deflate.to_u16())?;
    image.write_tag(Tag::PhotometricInterpretation, photometric.to_u16())?;
    image.write_tag(Tag::StripOffsets, &offsets[..])?;
    image.write_tag(Tag::SamplesPerPixel, u16::try_from(channels)?)?;
    image.write_tag(Tag::RowsPerStrip, u32::try_from(height)?)?;
    image.write_tag(Tag::StripByteCounts, &sizes[..])?;
    let planar = PlanarConfiguration::Chunky.to_u16();
    image.write_tag(Tag::PlanarConfiguration, planar)?;
    image.write_tag(Tag::SampleFormat, &vec![format.to_u16(); channels][..])?;
    // Alpha of unstated meaning is stored as it came, as one sample more without a word about it.
    if let (2 | 4, Some(alpha)) = (channels, carried.alpha) {
        image.write_tag(Tag::ExtraSamples, &[alpha.to_u16()][..])?;
    }
    if !plate.texts.is_empty() {
        let history = as_history(&plate.texts);
        image.write_tag(IMAGE_HISTORY, &history[..])?;
    }
    for (tag, offset) in pointers {
        image.write_tag(tag, offset)?;
    }
    for tag in &carried.tags {
        put(&mut image, tag)?;
    }
    image.finish()
}

/// Writes a tag as it was.
fn put<W: std::io::Write + std::io::Seek, K: TiffKind>(
    directory: &mut DirectoryEncoder<'_, W, K>,
    CarriedTag { tag, kind, bytes }: &CarriedTag,
) -> std::result::Result<(), TiffError> {
    let entry = directory.write_entry_bytes(*kind, bytes)?;
    let mut one = Directory::empty();
    one.extend([(Tag::from_u16_exhaustive(*tag), entry)]);
    directory.extend_from(&one);
    Ok(())
}

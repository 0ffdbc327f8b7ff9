//! Writing TIFF files: Deflate-compressed strips, and all metadata.

use std::path::Path;

use half::f16;
use rayon::prelude::*;
use tiff::encoder::compression::{CompressionAlgorithm, Deflate, DeflateLevel};
use tiff::encoder::{DirectoryEncoder, TiffEncoder, TiffKind};
use tiff::tags::{
    CompressionMethod, PhotometricInterpretation, PlanarConfiguration, SampleFormat as TiffFormat,
    Tag,
};
use tiff::{Directory, TiffError};

use super::tags::{IMAGE_HISTORY, StoredTag, StoredTags};
use crate::atomic::{Output, write_atomically};
use crate::error::Result;
use crate::metadata::{TextAttributes, is_provenance};
use crate::raster::RasterImage;
use crate::samples::{SampleFormat, clip_to_half, quantise};

/// Size of a strip before compression, bytes. Readers hold a whole strip in memory.
const STRIP_BYTES: usize = 1 << 20;

/// Formats texts as ImageHistory: a line for each, and indented lines for the further lines of a text.
fn to_history(texts: &TextAttributes) -> String {
    let line = |(name, text): &(String, String)| {
        if is_provenance(name) {
            format!("{name}: {}", text.replace('\n', "\n  "))
        } else {
            text.clone()
        }
    };
    texts.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Writes a TIFF file, Deflate compressed, whole or not at all.
pub(super) fn write(path: &Path, image: &RasterImage, stored: &StoredTags) -> Result<()> {
    write_atomically(path, |out| {
        encode(out, image, stored).map_err(|error| error.to_string())
    })
}

/// Returns the bytes of some rows, pixel by pixel.
fn encode_rows(image: &RasterImage, rows: std::ops::Range<usize>) -> Vec<u8> {
    let pixels = rows.start * image.width..rows.end * image.width;
    let mut bytes = Vec::new();
    for index in pixels {
        for plane in &image.planes {
            let sample = plane[index];
            match image.sample_format {
                SampleFormat::U8 => bytes.push(quantise(sample, 255) as u8),
                SampleFormat::U16 => bytes.extend(quantise(sample, u16::MAX).to_ne_bytes()),
                SampleFormat::F16 => {
                    bytes.extend(f16::from_f32(clip_to_half(sample)).to_ne_bytes());
                }
                _ => bytes.extend(sample.to_ne_bytes()),
            }
        }
    }
    bytes
}

fn encode(
    out: &mut Output<'_>,
    image: &RasterImage,
    stored: &StoredTags,
) -> std::result::Result<(), TiffError> {
    let (bits, format): (u16, _) = match image.sample_format {
        SampleFormat::U8 => (8, TiffFormat::Uint),
        SampleFormat::U16 => (16, TiffFormat::Uint),
        SampleFormat::F16 => (16, TiffFormat::IEEEFP),
        _ => (32, TiffFormat::IEEEFP),
    };
    let channels = image.planes.len();
    let row_bytes = (image.width * channels * usize::from(bits / 8)).max(1);
    let strip_rows = STRIP_BYTES.div_ceil(row_bytes).min(image.height.max(1));
    let starts: Vec<usize> = (0..image.height).step_by(strip_rows).collect();
    let compress = |&start: &usize| -> std::io::Result<Vec<u8>> {
        let bytes = encode_rows(image, start..(start + strip_rows).min(image.height));
        let mut compressed = Vec::new();
        Deflate::with_level(DeflateLevel::default()).write_to(&mut compressed, &bytes)?;
        Ok(compressed)
    };
    let strips: Vec<Vec<u8>> = starts
        .par_iter()
        .map(compress)
        .collect::<std::io::Result<_>>()?;

    let mut encoder = TiffEncoder::new(out)?;
    let mut pointers = Vec::new();
    for (tag, tags) in &stored.directories {
        let mut directory = encoder.extra_directory()?;
        for tag in tags {
            write_tag(&mut directory, tag)?;
        }
        pointers.push((*tag, directory.finish_with_offsets()?.offset));
    }
    let mut directory = encoder.image_directory()?;
    let (mut offsets, mut sizes) = (Vec::new(), Vec::new());
    for strip in &strips {
        offsets.push(u32::try_from(directory.write_data(&strip[..])?)?);
        sizes.push(u32::try_from(strip.len())?);
        // Values and strips begin at even offsets.
        if strip.len() % 2 == 1 {
            directory.write_data(&[0_u8][..])?;
        }
    }
    let photometric = match channels {
        1 | 2 => PhotometricInterpretation::BlackIsZero,
        _ => PhotometricInterpretation::RGB,
    };
    directory.write_tag(Tag::ImageWidth, u32::try_from(image.width)?)?;
    directory.write_tag(Tag::ImageLength, u32::try_from(image.height)?)?;
    directory.write_tag(Tag::BitsPerSample, &vec![bits; channels][..])?;
    directory.write_tag(Tag::Compression, CompressionMethod::Deflate.to_u16())?;
    directory.write_tag(Tag::PhotometricInterpretation, photometric.to_u16())?;
    directory.write_tag(Tag::StripOffsets, &offsets[..])?;
    directory.write_tag(Tag::SamplesPerPixel, u16::try_from(channels)?)?;
    directory.write_tag(Tag::RowsPerStrip, u32::try_from(strip_rows)?)?;
    directory.write_tag(Tag::StripByteCounts, &sizes[..])?;
    let planar = PlanarConfiguration::Chunky.to_u16();
    directory.write_tag(Tag::PlanarConfiguration, planar)?;
    directory.write_tag(Tag::SampleFormat, &vec![format.to_u16(); channels][..])?;
    // Alpha whose meaning the source did not state is stored without ExtraSamples too.
    if let (2 | 4, Some(alpha)) = (channels, stored.alpha) {
        directory.write_tag(Tag::ExtraSamples, &[alpha.to_u16()][..])?;
    }
    if !image.texts.is_empty() {
        let history = to_history(&image.texts);
        directory.write_tag(IMAGE_HISTORY, &history[..])?;
    }
    for (tag, offset) in pointers {
        directory.write_tag(tag, offset)?;
    }
    for tag in &stored.tags {
        write_tag(&mut directory, tag)?;
    }
    directory.finish()
}

/// Writes a tag unchanged.
fn write_tag<W: std::io::Write + std::io::Seek, K: TiffKind>(
    directory: &mut DirectoryEncoder<'_, W, K>,
    tag: &StoredTag,
) -> std::result::Result<(), TiffError> {
    let entry = directory.write_entry_bytes(tag.kind, &tag.bytes)?;
    let mut one = Directory::empty();
    one.extend([(Tag::from_u16_exhaustive(tag.tag), entry)]);
    directory.extend_from(&one);
    Ok(())
}

//! TIFF files: 8 and 16 bit, half and float, one page.

mod metadata;
mod tags;
mod write;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::{ExtraSamples, Tag};
use tiff::{ColorType, TiffError};

use self::metadata::TiffMetadata;
use self::tags::IMAGE_HISTORY;
use crate::error::{FileError, Result};
use crate::format::{AlphaSupport, Capabilities, Format, GreySupport};
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::InputFile;
use crate::metadata::{TextAttributes, is_provenance};
use crate::new_image::NewImage;
use crate::raster::{RasterImage, channel_names, deinterleave};
use crate::samples::SampleFormat;

/// The TIFF format.
pub(crate) struct Tiff;

pub(crate) const FORMAT: Format = Format {
    name: "TIFF",
    short_name: "TIFF",
    extensions: &["tif", "tiff"],
    // Little and big endian, classic and BigTIFF.
    magic: &[b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"],
    written_as: Some("the 8 or 16 bits of IN, or float"),
    sample_format: |source, _| match source {
        SampleFormat::U8 => SampleFormat::U8,
        SampleFormat::U10 | SampleFormat::U12 | SampleFormat::U16 => SampleFormat::U16,
        SampleFormat::F16 | SampleFormat::F32 | SampleFormat::Rgbe => SampleFormat::F32,
    },
    capabilities: Capabilities {
        alpha: AlphaSupport::Either,
        grey: GreySupport::Always,
        icc_profile: true,
        ..Capabilities::RGB
    },
};

/// The tag of camera raw files.
const DNG_VERSION: Tag = Tag::Unknown(50706);
const DNG: &str = "camera raw: DNG";
const DNG_REMEDY: &str = "develop it to linear OpenEXR or TIFF; `seidel measure` reads it as it is";

fn is_named_dng(path: &Path) -> bool {
    path.extension()
        .is_some_and(|own| own.eq_ignore_ascii_case("dng"))
}

impl ImageFormat for Tiff {
    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        let refuse = |error: TiffError| match error {
            TiffError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                FileError::io(input.path, "be read", &error)
            }
            TiffError::UnsupportedError(_) if is_named_dng(input.path) => {
                input.unsupported(DNG, DNG_REMEDY)
            }
            TiffError::UnsupportedError(what) => input.unsupported(&what.to_string(), SUPPORTED),
            error if error.to_string().contains("lzw end code") => input.unsupported(
                "LZW data without an end code, unless the file is damaged",
                "save it with Deflate or without compression",
            ),
            error => input.damaged(&error.to_string()),
        };
        let unsupported = |feature: String| input.unsupported(&feature, SUPPORTED);
        let mut decoder = Decoder::new(BufReader::new(&input.file)).map_err(refuse)?;
        let version: Option<Vec<u8>> =
            decoder.find_tag_unsigned_vec(DNG_VERSION).map_err(refuse)?;
        if version.is_some_and(|version| !version.is_empty()) {
            // Its first picture is a preview.
            return Err(input.unsupported(DNG, DNG_REMEDY));
        }
        let (width, height) = decoder.dimensions().map_err(refuse)?;
        let (width, height) = (width as usize, height as usize);
        let colour = decoder.colortype().map_err(refuse)?;
        let stored = decoder
            .find_tag_unsigned::<u16>(Tag::SamplesPerPixel)
            .map_err(refuse)?
            .unwrap_or(1);
        let extra: Vec<u16> = decoder
            .find_tag_unsigned_vec(Tag::ExtraSamples)
            .map_err(refuse)?
            .unwrap_or_default();
        let channels = match colour {
            ColorType::Gray(_) => 1,
            // The decoder's name for grey with alpha.
            ColorType::Multiband { num_samples: 2, .. } if matches!(extra[..], [1 | 2]) => 2,
            ColorType::RGB(_) => 3,
            ColorType::RGBA(_) => 4,
            other => return Err(unsupported(format!("{other:?}"))),
        };
        if usize::from(stored) != channels {
            return Err(unsupported(format!(
                "{stored} samples per pixel for the channels {}",
                channel_names(channels).join(", ")
            )));
        }
        // The decoder's bytes, and planes of at most four times their size.
        let pixel_bytes = channels * usize::from(colour.bit_depth().div_ceil(8));
        input.check_size("ImageWidth, ImageLength", width, height, pixel_bytes * 5)?;
        let bytes = width * height * pixel_bytes;
        let mut limits = tiff::decoder::Limits::default();
        limits.decoding_buffer_size = bytes;
        limits.intermediate_buffer_size = bytes.max(1 << 20).saturating_mul(4);
        limits.ifd_value_size = 64 << 20;
        let mut decoder = decoder.with_limits(limits);
        let alpha = extra.first().and_then(|&v| ExtraSamples::from_u16(v));
        let metadata = TiffMetadata::read(&mut decoder, alpha);
        if let Some(feature) = unsupported_layout(&mut decoder, input) {
            return Err(unsupported(feature));
        }
        let mut data = DecodingResult::U8(Vec::new());
        let layout = decoder.read_image_to_buffer(&mut data).map_err(refuse)?;
        let is_planar = layout.planes > 1;
        let (planes, sample_format) = match &data {
            // Fewer than eight bits would be packed.
            DecodingResult::U8(d) if colour.bit_depth() == 8 => (
                planes(d, channels, is_planar, |s| f32::from(s) / 255.0),
                SampleFormat::U8,
            ),
            DecodingResult::U16(d) if colour.bit_depth() == 16 => (
                planes(d, channels, is_planar, |s| f32::from(s) / 65535.0),
                SampleFormat::U16,
            ),
            DecodingResult::F16(d) => (
                planes(d, channels, is_planar, |s| s.to_f32()),
                SampleFormat::F16,
            ),
            DecodingResult::F32(d) => (planes(d, channels, is_planar, |s| s), SampleFormat::F32),
            _ => {
                let bits = colour.bit_depth();
                return Err(unsupported(format!("{bits} bits per sample")));
            }
        };
        if planes.len() != channels || planes.iter().any(|p| p.len() != width * height) {
            return Err(input.damaged("pixels are missing"));
        }
        Ok(RasterImage {
            texts: read_history(&mut decoder),
            ..RasterImage::new(input, metadata, sample_format, (width, height), planes)
        }
        .into())
    }

    fn write_new(&self, path: &Path, mut image: NewImage) -> Result<Vec<String>> {
        let premultiplied = image.alpha.as_ref().map(|_| image.premultiplied);
        let metadata = TiffMetadata::new(premultiplied, image.icc_profile.take());
        image.into_raster(metadata).write(path)
    }
}

/// Advice on files that use unsupported features.
const SUPPORTED: &str = "save it as grey or RGB, 8-bit, 16-bit or float, one page, in strips with Deflate or without compression";

/// Returns the name of a layout of the pixels that the decoder takes for damage.
fn unsupported_layout(
    decoder: &mut Decoder<BufReader<&File>>,
    input: &InputFile,
) -> Option<String> {
    let mut number = |tag| decoder.find_tag_unsigned_vec::<u64>(tag).ok().flatten();
    let first = |values: Option<Vec<u64>>| values.and_then(|all| all.first().copied());
    let (width, height) = (
        first(number(Tag::ImageWidth))?,
        first(number(Tag::ImageLength))?,
    );
    let tile = (
        first(number(Tag::TileWidth)),
        first(number(Tag::TileLength)),
    );
    let has_planes = first(number(Tag::SamplesPerPixel)).is_some_and(|samples| samples > 1);
    if let ((Some(across), Some(down)), Some(2)) = (tile, first(number(Tag::PlanarConfiguration)))
        && has_planes
        && (width % across.max(1) != 0 || height % down.max(1) != 0)
    {
        return Some(format!(
            "separate planes in tiles of {across} x {down}, with {width} x {height} no multiple of these"
        ));
    }
    let depth = first(number(Tag::BitsPerSample));
    if let Some(bits) = depth.filter(|bits| ![1, 2, 4, 8, 16, 32, 64].contains(bits)) {
        return Some(format!("{bits} bits per sample"));
    }
    let offset = first(number(Tag::StripOffsets)).or_else(|| first(number(Tag::TileOffsets)))?;
    let is_lzw = first(number(Tag::Compression)) == Some(5);
    let mut start = [0; 2];
    let mut file = &input.file;
    let place = file.stream_position().ok()?;
    let read = file
        .seek(SeekFrom::Start(offset))
        .and_then(|_| file.read_exact(&mut start));
    file.seek(SeekFrom::Start(place)).ok()?;
    // Codes of TIFF 5.0 and older begin at the lowest bit of a byte, so that the clear code looks like this.
    let is_old = is_lzw && read.is_ok() && start[0] == 0 && start[1] & 1 == 1;
    is_old.then(|| "LZW as before TIFF 6.0".to_owned())
}

/// Writes planes of `width` x `height` floats as a new TIFF file (grey or RGB), whole or not at all.
pub(crate) fn write_float(
    path: &Path,
    width: usize,
    height: usize,
    planes: Vec<Vec<f32>>,
) -> Result<()> {
    let metadata = TiffMetadata::new(None, None);
    let image = RasterImage {
        format: FORMAT,
        path: path.to_path_buf(),
        metadata: Box::new(metadata),
        sample_format: SampleFormat::F32,
        width,
        height,
        names: channel_names(planes.len()),
        planes,
        texts: TextAttributes::new(),
        changed: false,
        warnings: Vec::new(),
    };
    image.metadata.write(path, &image)
}

/// Returns the planes of samples that are stored plane by plane (`is_planar`) or interleaved.
fn planes<T: Copy>(
    samples: &[T],
    channels: usize,
    is_planar: bool,
    convert: impl Fn(T) -> f32,
) -> Vec<Vec<f32>> {
    if !is_planar {
        return deinterleave(samples, channels, convert);
    }
    samples
        .chunks(samples.len().div_ceil(channels).max(1))
        .map(|plane| plane.iter().map(|&s| convert(s)).collect())
        .collect()
}

/// Reads the provenance of ImageHistory; other content becomes one text of that name.
fn read_history(decoder: &mut Decoder<BufReader<&File>>) -> TextAttributes {
    let tag = decoder.find_tag(IMAGE_HISTORY).ok().flatten();
    let Some(history) = tag.and_then(|value| value.into_string().ok()) else {
        return TextAttributes::new();
    };
    let mut texts = TextAttributes::new();
    for line in history.lines() {
        if let (Some(more), Some((_, text))) = (line.strip_prefix("  "), texts.last_mut()) {
            text.push('\n');
            text.push_str(more);
            continue;
        }
        match line.split_once(": ") {
            Some((name, text)) if is_provenance(name) && !line.starts_with("  ") => {
                texts.push((name.to_owned(), text.to_owned()));
            }
            _ => return vec![("ImageHistory".to_owned(), history)],
        }
    }
    texts
}

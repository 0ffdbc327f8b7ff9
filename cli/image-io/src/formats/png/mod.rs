//! PNG files, 8 and 16 bit.

mod chunks;
mod icc_curve;
mod metadata;
mod transfer;

use std::borrow::Cow;
use std::io::{BufReader, Seek};
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ImageBuffer, Luma, RgbImage};
use png::chunk::ChunkType;
use png::{BitDepth, ColorType, Decoder, DecodingError, Encoder, EncodingError, Info};

use self::metadata::PngMetadata;
use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::format::{AlphaSupport, Capabilities, Format, GreySupport};
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::InputFile;
use crate::metadata::TextAttributes;
use crate::new_image::NewImage;
use crate::raster::{RasterImage, deinterleave};
use crate::samples::{SampleFormat, quantise};

/// The PNG format.
pub(crate) struct Png;

pub(crate) const FORMAT: Format = Format {
    name: "PNG",
    short_name: "PNG",
    extensions: &["png"],
    magic: &[b"\x89PNG\r\n\x1a\n"],
    written_as: Some("the 8 bits of IN, or 16"),
    sample_format: |source, _| match source {
        SampleFormat::U8 => SampleFormat::U8,
        _ => SampleFormat::U16,
    },
    capabilities: Capabilities {
        alpha: AlphaSupport::Unpremultiplied,
        grey: GreySupport::Always,
        icc_profile: true,
        texts: true,
        ..Capabilities::RGB
    },
};

impl ImageFormat for Png {
    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        let refuse = |error: DecodingError| match error {
            DecodingError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                FileError::io(input.path, "be read", &error)
            }
            error => input.damaged(&error.to_string()),
        };
        let chunks = chunks::read(&mut BufReader::new(&input.file), input.length);
        (&input.file)
            .rewind()
            .map_err(|e| FileError::io(input.path, "be read", &e))?;
        let mut decoder = Decoder::new(BufReader::new(&input.file));
        // Palettes and fewer than eight bits are expanded.
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(refuse)?;
        let (width, height) = (reader.info().width as usize, reader.info().height as usize);
        let (colour, bits) = reader.output_color_type();
        let channels = match colour {
            ColorType::Grayscale => 1,
            ColorType::GrayscaleAlpha => 2,
            ColorType::Rgb | ColorType::Indexed => 3,
            ColorType::Rgba => 4,
        };
        let (sample_format, sample_bytes) = match bits {
            BitDepth::Sixteen => (SampleFormat::U16, 2),
            _ => (SampleFormat::U8, 1),
        };
        // The decoder's bytes, and planes of at most four times their size.
        input.check_size("IHDR", width, height, channels * sample_bytes * 5)?;
        let Some(size) = reader.output_buffer_size() else {
            return Err(input.damaged("it is too large"));
        };
        let mut data = vec![0_u8; size];
        reader.next_frame(&mut data).map_err(refuse)?;
        // Texts may follow the pixels. Damage there does not affect the image.
        let _ = reader.finish();
        let info = reader.info();
        let planes = match sample_format {
            SampleFormat::U8 => deinterleave(&data, channels, |s| f32::from(s) / 255.0),
            _ => {
                let samples: Vec<u16> = data
                    .chunks_exact(2)
                    .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
                    .collect();
                deinterleave(&samples, channels, |s| f32::from(s) / 65535.0)
            }
        };
        if planes.iter().any(|plane| plane.len() != width * height) {
            return Err(input.damaged("pixels are missing"));
        }
        let is_expanded = (info.color_type, info.bit_depth) != (colour, bits);
        let metadata = PngMetadata::read(info, chunks).with_expansion(is_expanded);
        Ok(RasterImage {
            texts: metadata.texts(),
            ..RasterImage::new(input, metadata, sample_format, (width, height), planes)
        }
        .into())
    }

    fn write_new(&self, path: &Path, mut image: NewImage) -> Result<Vec<String>> {
        let metadata = PngMetadata::new(image.icc_profile.take());
        image.into_raster(metadata).write(path)
    }
}

/// Writes a PNG file, whole or not at all.
fn write(path: &Path, image: &RasterImage, metadata: &PngMetadata) -> Result<()> {
    let mut info = Info::with_size(image.width as u32, image.height as u32);
    info.color_type = match image.planes.len() {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    };
    info.icc_profile = metadata.new_icc_profile().map(Cow::Borrowed);
    let data = if image.sample_format == SampleFormat::U8 {
        info.bit_depth = BitDepth::Eight;
        image.interleaved(|code| quantise(code, 255) as u8)
    } else {
        info.bit_depth = BitDepth::Sixteen;
        image
            .interleaved(|code| quantise(code, u16::MAX).to_be_bytes())
            .concat()
    };
    let (after, before): (Vec<_>, Vec<_>) =
        (metadata.valid_chunks(image)).partition(|chunk| chunk.follows_pixels());
    write_atomically(path, |out| {
        let encode = || -> std::result::Result<(), EncodingError> {
            let mut writer = Encoder::with_info(out, info)?.write_header()?;
            for chunk in before {
                writer.write_chunk(ChunkType(chunk.name()), chunk.data())?;
            }
            for (name, text) in &image.texts {
                metadata.write_text(&mut writer, name, text)?;
            }
            writer.write_image_data(&data)?;
            for chunk in after {
                writer.write_chunk(ChunkType(chunk.name()), chunk.data())?;
            }
            writer.finish()
        };
        encode().map_err(|e| e.to_string())
    })
}

/// Writes `image` as [`write_rgb8`] does, with `texts` such as provenance.
///
/// # Errors
/// A name that does not end in `.png`, and a target that cannot be written.
pub fn write_rgb8_with_texts(path: &Path, image: &RgbImage, texts: &TextAttributes) -> Result<()> {
    FORMAT.check_name(path)?;
    write_atomically(path, |out| {
        let encode = || -> std::result::Result<(), EncodingError> {
            let mut encoder = Encoder::new(out, image.width(), image.height());
            encoder.set_color(ColorType::Rgb);
            encoder.set_depth(BitDepth::Eight);
            // Halves the files of charts with enlarged pixels, whose rows repeat.
            encoder.set_filter(png::Filter::Up);
            let mut writer = encoder.write_header()?;
            for (name, text) in texts {
                PngMetadata::default().write_text(&mut writer, name, text)?;
            }
            writer.write_image_data(image.as_raw())?;
            writer.finish()
        };
        encode().map_err(std::io::Error::other)
    })
}

/// Writes `samples`, rows of `width` pixels, as a 16-bit grey PNG file, whole or not at all.
///
/// # Errors
/// A name that does not end in `.png`, a target that cannot be written, and samples that are no whole rows.
pub fn write_gray16(path: &Path, width: u32, samples: Vec<u16>) -> Result<()> {
    FORMAT.check_name(path)?;
    let height = samples.len() as u32 / width.max(1);
    let image = ImageBuffer::<Luma<u16>, _>::from_raw(width, height, samples);
    write_atomically(path, |out| match image {
        Some(image) => image.write_with_encoder(PngEncoder::new(out)),
        None => Err(image::ImageError::Parameter(
            image::error::ParameterError::from_kind(
                image::error::ParameterErrorKind::DimensionMismatch,
            ),
        )),
    })
}

/// Writes `image` as an 8-bit PNG file, whole or not at all.
///
/// # Errors
/// A name that does not end in `.png`, and a target that cannot be written.
pub fn write_rgb8(path: &Path, image: &RgbImage) -> Result<()> {
    write_rgb8_with_texts(path, image, &TextAttributes::new())
}

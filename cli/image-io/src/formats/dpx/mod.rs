//! DPX files (SMPTE 268M-2003): 8, 10, 12 and 16 bits, both byte orders, one image element.

pub(crate) mod byte_order;
mod header;
mod metadata;
mod samples;
mod user_data;

use std::io::Write;
use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::format::{AlphaSupport, Capabilities, Format, GreySupport};
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::InputFile;
use crate::new_image::NewImage;
use crate::raster::RasterImage;
use crate::samples::{SampleFormat, quantise};
use header::{Header, set_file_size};
use metadata::DpxMetadata;
use samples::{Layout, Packing, WordEnd};

/// The DPX format.
pub(crate) struct Dpx;

pub(crate) const FORMAT: Format = Format {
    name: "DPX",
    short_name: "DPX",
    extensions: &["dpx"],
    // Big and little endian.
    magic: &[b"SDPX", b"XPDS"],
    written_as: Some("10 bits, or the 12 or 16 of IN, or 16 with alpha or without colour"),
    // RGB has the 10 bits that programs expect of DPX. Programs disagree on the layout of 10-bit samples that are not
    // three per pixel.
    sample_format: |source, channels| match source {
        SampleFormat::U12 | SampleFormat::U16 => source,
        _ if channels != 3 => SampleFormat::U16,
        _ => SampleFormat::U10,
    },
    capabilities: Capabilities {
        pixel_aspect: true,
        alpha: AlphaSupport::Premultiplied,
        grey: GreySupport::WithoutAlpha,
        common_metadata: true,
        ..Capabilities::RGB
    },
};

impl ImageFormat for Dpx {
    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        let bytes = input.read_all()?;
        let header = Header::parse(input.path, &bytes)?;
        let Header { layout, height, .. } = header;
        let components = layout.components;
        // 16-bit codes of a line, and planes of four bytes per sample.
        input.check_size(
            "pixels per line, lines",
            layout.width,
            height,
            components * 5,
        )?;
        let stride = stride(input.path, &header, bytes.len())?;

        let full_scale = f32::from(layout.packing.full_scale());
        let mut planes = vec![vec![0.0; layout.width * height]; components];
        let mut codes = vec![0; layout.samples()];
        for y in 0..height {
            let start = header.offset + y * stride;
            layout.unpack(&bytes[start..start + layout.line_bytes()], &mut codes);
            for (index, plane) in planes.iter_mut().enumerate() {
                let row = &mut plane[y * layout.width..][..layout.width];
                let own = codes
                    .iter()
                    .skip(layout.component(index))
                    .step_by(components);
                for (sample, &code) in row.iter_mut().zip(own) {
                    *sample = f32::from(code) / full_scale;
                }
            }
        }
        let end = bytes.len().min(header.offset + stride * height);
        let metadata = DpxMetadata {
            before_pixels: bytes[..header.offset].to_vec(),
            after_pixels: bytes[end..].to_vec(),
            header,
            stride,
        };
        let sample_format = match layout.packing {
            Packing::Bits8 => SampleFormat::U8,
            Packing::Bits10(_) | Packing::Contiguous(10) => SampleFormat::U10,
            Packing::Bits12(_) | Packing::Contiguous(_) => SampleFormat::U12,
            Packing::Bits16 => SampleFormat::U16,
        };
        let size = (layout.width, height);
        Ok(RasterImage {
            texts: user_data::texts(&metadata.before_pixels, layout.order),
            ..RasterImage::new(input, metadata, sample_format, size, planes)
        }
        .into())
    }

    fn write_new(&self, path: &Path, image: NewImage) -> Result<Vec<String>> {
        let mut metadata = DpxMetadata::new(&image);
        let lost = metadata.set_common(&image.common);
        let mut warnings = Vec::new();
        if !lost.is_empty() {
            let lost = lost.join(", ");
            warnings.push(format!("DPX has no room for {lost}: left out"));
        }
        warnings.extend(image.into_raster(metadata).write(path)?);
        Ok(warnings)
    }
}

/// Returns the bytes from the start of a line to that of the next.
///
/// Lines begin at 32-bit words by the standard, but not in the files of some writers. The length of the file, `length`
/// bytes, tells which is the case.
///
/// # Errors
/// A truncated file, and filled words that the header calls contiguous.
fn stride(path: &Path, header: &Header, length: usize) -> Result<usize> {
    let (line, height) = (header.layout.line_bytes(), header.height);
    let available = length - header.offset;
    let plain = line.saturating_add(header.line_padding);
    let needed = |stride: usize| stride.saturating_mul(height - 1).saturating_add(line);
    let standard = plain.checked_next_multiple_of(4).unwrap_or(plain);
    if plain.checked_mul(height) == Some(available) {
        return Ok(plain);
    }
    // Some writers fill words and call them contiguous.
    if let Packing::Contiguous(bits) = header.layout.packing {
        let filled = match bits {
            10 => Packing::Bits10(WordEnd::High),
            _ => Packing::Bits12(WordEnd::High),
        };
        let layout = Layout {
            packing: filled,
            ..header.layout
        };
        if layout.line_bytes().checked_mul(height) == Some(available) {
            return Err(FileError::new(
                path,
                "packing",
                "is 0, contiguous samples, but the image data have the length of filled words",
                header::SUPPORTED_PACKING,
            ));
        }
    }
    let fitting = [standard, plain]
        .into_iter()
        .find(|&s| needed(s) <= available);
    fitting.ok_or_else(|| {
        FileError::new(
            path,
            "image data",
            format!(
                "take {} bytes, but {available} are left in the file",
                needed(plain)
            ),
            "copy or render the file again: it is truncated or its header damaged",
        )
    })
}

/// Writes a DPX file, whole or not at all.
fn write(path: &Path, image: &RasterImage, metadata: &DpxMetadata) -> Result<()> {
    let header = &metadata.header;
    let layout = &header.layout;
    let mut start = user_data::with_texts(&metadata.before_pixels, layout.order, &image.texts);
    let size = start.len() + metadata.stride * header.height + metadata.after_pixels.len();
    set_file_size(&mut start, layout.order, size);
    let full_scale = layout.packing.full_scale();
    write_atomically(path, |out| {
        out.write_all(&start)?;
        let mut codes = vec![0; layout.samples()];
        let mut line = Vec::new();
        for y in 0..header.height {
            for (index, plane) in image.planes.iter().enumerate() {
                let row = &plane[y * layout.width..][..layout.width];
                let first = layout.component(index);
                let own = codes.iter_mut().skip(first).step_by(layout.components);
                for (code, &sample) in own.zip(row) {
                    *code = quantise(sample, full_scale);
                }
            }
            line.clear();
            layout.pack(&codes, &mut line);
            line.resize(metadata.stride, 0);
            out.write_all(&line)?;
        }
        out.write_all(&metadata.after_pixels)
    })
}

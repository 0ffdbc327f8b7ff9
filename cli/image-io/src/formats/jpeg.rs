//! JPEG files, read only: 8 bits, grey or RGB.

use std::io::Cursor;
use std::path::Path;

use image::codecs::jpeg::JpegDecoder;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError};

use crate::error::{FileError, Result};
use crate::format::{Capabilities, Format, GreySupport};
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::InputFile;
use crate::new_image::NewImage;
use crate::raster::{AssumedEncoding, Metadata, RasterImage, deinterleave};
use crate::samples::SampleFormat;

/// The JPEG format.
pub(crate) struct Jpeg;

pub(crate) const FORMAT: Format = Format {
    name: "JPEG",
    short_name: "JPEG",
    extensions: &["jpg", "jpeg"],
    magic: &[&[0xff, 0xd8, 0xff]],
    written_as: None,
    sample_format: |_, _| SampleFormat::U8,
    capabilities: Capabilities {
        grey: GreySupport::Always,
        icc_profile: true,
        ..Capabilities::RGB
    },
};

impl ImageFormat for Jpeg {
    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        let bytes = input.read_all()?;
        check_segments(input, &bytes)?;
        let refuse = |error: ImageError| input.damaged(&error.to_string());
        let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(refuse)?;
        let (width, height) = decoder.dimensions();
        let (width, height) = (width as usize, height as usize);
        let channels = match decoder.color_type() {
            ColorType::L8 => 1,
            ColorType::Rgb8 => 3,
            other => return Err(unsupported(input, &format!("{other:?} samples"))),
        };
        // The decoder's bytes, and planes of four times their size.
        input.check_size("SOF", width, height, channels * 5)?;
        // Unreadable EXIF data state no orientation.
        let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
        let metadata = JpegMetadata {
            icc_profile: decoder.icc_profile().map_err(refuse)?,
            has_exif: decoder.exif_metadata().is_ok_and(|exif| exif.is_some()),
            is_rotated: orientation != Orientation::NoTransforms,
        };
        let mut data = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut data).map_err(refuse)?;
        let planes = deinterleave(&data, channels, |s| f32::from(s) / 255.0);
        let size = (width, height);
        Ok(RasterImage::new(input, metadata, SampleFormat::U8, size, planes).into())
    }

    fn write_new(&self, path: &Path, _image: NewImage) -> Result<Vec<String>> {
        Err(read_only(path))
    }
}

/// The metadata of a JPEG file.
#[derive(Debug, Clone)]
struct JpegMetadata {
    icc_profile: Option<Vec<u8>>,
    /// Whether there are EXIF data.
    has_exif: bool,
    /// Whether EXIF asks viewers to rotate or mirror the image.
    is_rotated: bool,
}

impl Metadata for JpegMetadata {
    fn write(&self, path: &Path, _image: &RasterImage) -> Result<()> {
        Err(read_only(path))
    }

    fn icc_profile(&self) -> Option<&[u8]> {
        self.icc_profile.as_deref()
    }

    fn remove_colour_space(&mut self) -> Vec<String> {
        let removed = self.icc_profile.take();
        let name = removed.map(|_| "the ICC profile".to_owned());
        name.into_iter().collect()
    }

    fn read_warning(&self, _assumed: AssumedEncoding) -> Option<String> {
        self.is_rotated.then(|| {
            "the EXIF orientation of the JPEG is ignored: pixels are taken as they are stored"
                .to_owned()
        })
    }

    fn conversion_loss(&self, _kept: &[&str]) -> Option<String> {
        self.has_exif
            .then(|| "the EXIF metadata of the JPEG".to_owned())
    }
}

fn read_only(path: &Path) -> FileError {
    FileError::new(
        path,
        "",
        "would be JPEG, which is never written",
        "write it as PNG or TIFF",
    )
}

/// Refuses what the decoder would silently alter: CMYK, which it converts to RGB, and truncated files, which it fills
/// with grey.
fn check_segments(input: &InputFile, bytes: &[u8]) -> Result<()> {
    let truncated = || input.damaged("it is truncated");
    let mut at = 2;
    loop {
        let Some(&[0xff, marker]) = bytes.get(at..at + 2) else {
            return Err(input.damaged("a segment does not begin with a marker"));
        };
        at += 2;
        let segment = match marker {
            // A fill byte before a marker.
            0xff => {
                at -= 1;
                continue;
            }
            // Markers without a segment.
            0x01 | 0xd0..=0xd8 => continue,
            0xd9 => return Err(truncated()),
            _ => bytes.get(at..at + 2).ok_or_else(truncated)?,
        };
        let length = usize::from(u16::from_be_bytes([segment[0], segment[1]]));
        let segment = bytes.get(at + 2..at + length).ok_or_else(truncated)?;
        match (marker, segment) {
            // Tables and reserved markers within the range of frame markers.
            (0xc4 | 0xc8 | 0xcc, _) => {}
            (0xc0..=0xcf, [precision, _, _, _, _, components, ..]) => {
                if *components == 4 {
                    return Err(unsupported(input, "CMYK"));
                }
                if *precision != 8 {
                    return Err(unsupported(input, &format!("{precision} bits per sample")));
                }
            }
            // The entropy-coded scan, in which an end marker can only be the end.
            (0xda, _) => {
                let rest = &bytes[at..];
                let has_end = rest.windows(2).any(|pair| pair == [0xff, 0xd9]);
                return if has_end { Ok(()) } else { Err(truncated()) };
            }
            _ => {}
        }
        at += length;
    }
}

fn unsupported(input: &InputFile, feature: &str) -> FileError {
    input.unsupported(
        feature,
        "save it as 8-bit RGB or grey, better as TIFF or PNG",
    )
}

//! OpenEXR files: all parts, channels and attributes of flat images.

mod attributes;
mod channels;
mod codec;
pub(crate) mod compression;
mod describe;
mod dwa;
mod header;
pub(crate) mod image;
mod library_types;
mod placeholders;
mod samples;
mod selection;
mod write_new;

use std::path::Path;

pub use self::channels::{ColourChannels, DepthOwner};
pub use self::compression::ExrCompression;
pub use self::image::{ChannelId, ChannelInfo, ExrImage};
pub use self::selection::ViewChoice;
pub use self::write_new::{NewChannel, write_channels, write_channels_with_texts};

pub(crate) use self::attributes::COLOUR_SPACE;
pub(crate) use self::codec::{Compressing, write_exr};
pub(crate) use self::library_types::{bounds, new_text, window};

use crate::error::Result;
use crate::format::{AlphaSupport, Capabilities, Format, GreySupport};
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::InputFile;
use crate::new_image::NewImage;
use crate::part::Part;
use crate::samples::SampleFormat;

/// The OpenEXR format.
pub(crate) struct OpenExr;

/// The OpenEXR format.
pub const FORMAT: Format = Format {
    name: "OpenEXR",
    short_name: "EXR",
    extensions: &["exr"],
    magic: &[&[0x76, 0x2f, 0x31, 0x01]],
    written_as: Some(
        "scene-linear, premultiplied colour, as half for 8-bit, 10-bit and half-float samples, as float for others",
    ),
    // Half floats represent integers of up to 10 bits.
    sample_format: |source, _| match source {
        SampleFormat::U8 | SampleFormat::U10 | SampleFormat::F16 => SampleFormat::F16,
        _ => SampleFormat::F32,
    },
    capabilities: Capabilities {
        layers: true,
        data_window: true,
        pixel_aspect: true,
        alpha: AlphaSupport::Premultiplied,
        grey: GreySupport::Always,
        common_metadata: true,
        ..Capabilities::RGB
    },
};

impl ImageFormat for OpenExr {
    fn read(&self, input: &InputFile) -> Result<ImageFile> {
        let image = ExrImage::read(input)?;
        Ok(ImageFile::Exr(Box::new(image)))
    }

    fn describe(&self, input: &InputFile) -> Result<Vec<Part>> {
        describe::describe(input)
    }

    fn write_new(&self, path: &Path, image: NewImage) -> Result<Vec<String>> {
        write_new::write_image(path, image)?;
        Ok(Vec::new())
    }
}

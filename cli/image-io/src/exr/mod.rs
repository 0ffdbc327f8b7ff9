//! OpenEXR files: all parts, channels and attributes of flat images.

mod attributes;
mod channels;
mod codec;
mod compression;
mod describe;
mod dwa;
mod header;
mod image;
pub(crate) mod key_code;
mod write_new;

use std::path::Path;

pub use self::channels::ColourChannels;
pub use self::compression::ExrCompression;
pub use self::image::{ChannelId, ChannelInfo, ExrImage};
pub use self::write_new::{NewChannel, write_channels, write_channels_with_texts};

pub(crate) use self::attributes::new_text;
pub(crate) use self::codec::{Compressing, write_exr};
pub(crate) use self::write_new::bounds;

use crate::description::Part;
use crate::error::Result;
use crate::format::{
    AlphaSupport, Capabilities, Format, FormatInfo, GreySupport, ImageFile, ImageFormat,
};
use crate::input::InputFile;
use crate::plate::NewImage;
use crate::samples::SampleFormat;

/// The OpenEXR format.
pub(crate) struct OpenExr;

impl ImageFormat for OpenExr {
    fn info(&self) -> &'static FormatInfo {
        &FormatInfo {
            id: Format::Exr,
            name: "OpenEXR",
            extensions: &["exr"],
            magic: &[&[0x76, 0x2f, 0x31, 0x01]],
            capabilities: Capabilities {
                writable: true,
                layers: true,
                data_window: true,
                pixel_aspect: true,
                alpha: AlphaSupport::Premultiplied,
                grey: GreySupport::Always,
                icc_profile: false,
                texts: false,
                common_metadata: true,
            },
        }
    }

    /// Half floats represent integers of up to 10 bits; others need floats.
    fn sample_format(&self, source: SampleFormat, _channels: usize) -> SampleFormat {
        match source {
            SampleFormat::U8 | SampleFormat::U10 | SampleFormat::F16 => SampleFormat::F16,
            _ => SampleFormat::F32,
        }
    }

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

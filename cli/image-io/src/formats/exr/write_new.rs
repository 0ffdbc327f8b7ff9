//! Writing new OpenEXR files from planes of floats.

use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::prelude::*;
use half::f16;

use super::attributes::{COLOUR_SPACE, set_common};
use super::codec::{Compressing, write_exr};
use super::compression::ExrCompression;
use super::library_types::{bounds, new_text};
use crate::error::Result;
use crate::metadata::{CommonMetadata, TextAttributes};
use crate::new_image::NewImage;
use crate::samples::SampleFormat;
use crate::windows::ImageWindows;

/// Pixels below which one thread compresses an image, such as the tile of a PSF: of those, many are written at once.
const SMALL_PX: usize = 1 << 16;

/// A channel to write.
#[derive(Debug, Clone, Copy)]
pub struct NewChannel<'a> {
    /// The name of the channel.
    pub name: &'a str,
    /// One sample per pixel of the data window, row-major.
    pub samples: &'a [f32],
    /// Whether to store half floats, which are precise enough for colour but not for depth.
    pub half: bool,
}

/// Everything in a new file but pixels and windows.
struct Attributes {
    pixel_aspect: f64,
    texts: TextAttributes,
    common: CommonMetadata,
    compression: ExrCompression,
}

/// Writes the channels of an image as a ZIP-compressed EXR file, whole or not at all.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel does not have one sample per pixel of the data window.
pub fn write_channels(path: &Path, windows: ImageWindows, channels: &[NewChannel]) -> Result<()> {
    write_channels_with_texts(path, windows, channels, &TextAttributes::new())
}

/// Writes the channels of an image as [`write_channels`] does, with `texts` such as provenance.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel does not have one sample per pixel of the data window.
pub fn write_channels_with_texts(
    path: &Path,
    windows: ImageWindows,
    channels: &[NewChannel],
    texts: &TextAttributes,
) -> Result<()> {
    let attributes = Attributes {
        pixel_aspect: 1.0,
        texts: texts.clone(),
        common: CommonMetadata::default(),
        compression: ExrCompression::Zip,
    };
    write(path, windows, channels, attributes)
}

/// Writes an image that was converted to OpenEXR.
pub(super) fn write_image(path: &Path, image: NewImage) -> Result<()> {
    let planes = image.colour.iter().chain(&image.alpha);
    let names = image.names.iter().map(String::as_str).chain(["A"]);
    let channels: Vec<NewChannel> = names
        .zip(planes)
        .map(|(name, samples)| NewChannel {
            name,
            samples,
            half: image.sample_format == SampleFormat::F16,
        })
        .collect();
    let space = image.colour_space.iter();
    let space = space.map(|space| (COLOUR_SPACE.to_owned(), space.clone()));
    let attributes = Attributes {
        pixel_aspect: image.pixel_aspect,
        texts: image.texts.iter().cloned().chain(space).collect(),
        common: image.common.clone(),
        compression: image.compression.unwrap_or(ExrCompression::Zip),
    };
    write(path, image.windows, &channels, attributes)
}

fn write(
    path: &Path,
    windows: ImageWindows,
    channels: &[NewChannel],
    attributes: Attributes,
) -> Result<()> {
    let ImageWindows { data, display } = windows;
    let list = channels.iter().map(|channel| {
        let pixels = data.width * data.height;
        assert_eq!(channel.samples.len(), pixels, "one sample per pixel");
        let samples = if channel.half {
            let halves = channel.samples.iter().map(|&s| f16::from_f32(s));
            FlatSamples::F16(halves.collect())
        } else {
            FlatSamples::F32(channel.samples.to_vec())
        };
        AnyChannel::new(channel.name, samples)
    });
    let mut layer_attributes = LayerAttributes {
        layer_position: Vec2(data.x, data.y),
        ..LayerAttributes::default()
    };
    for (name, text) in &attributes.texts {
        let text = AttributeValue::Text(new_text(text));
        layer_attributes.other.insert(new_text(name), text);
    }
    set_common(&mut layer_attributes, &attributes.common);
    let encoding = Encoding {
        compression: attributes.compression.method(),
        // Scan lines in increasing order, so that the same image makes the same file.
        ..Encoding::SMALL_LOSSLESS
    };
    let layer = Layer::new(
        (data.width, data.height),
        layer_attributes,
        encoding,
        AnyChannels::sort(list.collect()),
    );
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = bounds(display);
    image.attributes.pixel_aspect = attributes.pixel_aspect as f32;
    image.attributes.time_code = attributes.common.time_code;
    let compressing = if data.width * data.height < SMALL_PX {
        Compressing::Serial
    } else {
        Compressing::Parallel
    };
    write_exr(path, &image, compressing)
}

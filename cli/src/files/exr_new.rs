//! New EXR files made from planes of the program's own.

use std::path::Path;

use exr::meta::attribute::{AttributeValue, IntegerBounds};
use exr::prelude::*;
use half::f16;

use super::error::Result;
use super::exr_file::write_exr;
use super::exr_packing::Packing;
use super::exr_texts::as_text;
use super::provenance::Texts;
use super::windows::Windows;

/// A channel to write.
pub struct NewChannel<'a> {
    /// Its name.
    pub name: &'a str,
    /// One sample a pixel, row-major.
    pub samples: &'a [f32],
    /// Whether to store it as half float, which is enough for colour and not for depth.
    pub half: bool,
}

/// Writes an EXR as [`write_new`] does whose channels lie as `windows` say.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel has not one sample a pixel.
pub fn write_placed(path: &Path, windows: Windows, channels: &[NewChannel]) -> Result<()> {
    write_shaped(
        path,
        (windows, 1.0),
        channels,
        (&Texts::new(), Packing::Zip),
    )
}

/// As [`write_placed`], of pixels that are `pixel_aspect` times as wide as high, with `texts` as attributes, packed as
/// `packing` says.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel has not one sample a pixel.
pub fn write_shaped(
    path: &Path,
    (windows, pixel_aspect): (Windows, f64),
    channels: &[NewChannel],
    (texts, packing): (&Texts, Packing),
) -> Result<()> {
    let Windows { data, display } = windows;
    let mut layer = new_layer(data.width, data.height, channels);
    layer.attributes.layer_position = Vec2(data.x, data.y);
    layer.encoding.compression = packing.compression();
    for (name, text) in texts {
        let text = AttributeValue::Text(as_text(text));
        layer.attributes.other.insert(as_text(name), text);
    }
    let mut image = Image::from_layer(layer);
    image.attributes.display_window =
        IntegerBounds::new((display.x, display.y), (display.width, display.height));
    image.attributes.pixel_aspect = pixel_aspect as f32;
    write_exr(path, &image, true)
}

/// Writes a scene-linear EXR of `width` x `height` pixels, ZIP compressed, whole or not at all.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel has not one sample a pixel.
pub fn write_new(path: &Path, width: usize, height: usize, channels: &[NewChannel]) -> Result<()> {
    let layer = new_layer(width, height, channels);
    write_exr(path, &Image::from_layer(layer), true)
}

fn new_layer(
    width: usize,
    height: usize,
    channels: &[NewChannel],
) -> Layer<AnyChannels<FlatSamples>> {
    let list = channels
        .iter()
        .map(|channel| {
            assert_eq!(channel.samples.len(), width * height, "one sample a pixel");
            let samples = if channel.half {
                let halves = channel.samples.iter().map(|&s| f16::from_f32(s));
                FlatSamples::F16(halves.collect())
            } else {
                FlatSamples::F32(channel.samples.to_vec())
            };
            AnyChannel::new(channel.name, samples)
        })
        .collect();
    Layer::new(
        (width, height),
        LayerAttributes::default(),
        Encoding {
            compression: Compression::ZIP16,
            ..Encoding::FAST_LOSSLESS
        },
        AnyChannels::sort(list),
    )
}

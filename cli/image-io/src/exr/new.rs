//! New EXR files made from planes of the program's own.

use std::path::Path;

use exr::meta::attribute::{AttributeValue, IntegerBounds};
use exr::prelude::*;
use half::f16;

use crate::error::Result;
use crate::exr::facts::put_facts;
use crate::exr::file::write_exr;
use crate::exr::packing::Packing;
use crate::exr::texts::as_text;
use crate::facts::Facts;
use crate::provenance::Texts;
use crate::windows::Windows;

/// A channel to write.
pub struct NewChannel<'a> {
    /// Its name.
    pub name: &'a str,
    /// One sample a pixel, row-major.
    pub samples: &'a [f32],
    /// Whether to store it as half float, which is enough for colour and not for depth.
    pub half: bool,
}

/// What a new EXR says beside its pixels, and how it is packed.
#[derive(Default)]
pub(crate) struct Beside {
    /// Width of a pixel over its height, if not one.
    pub(crate) pixel_aspect: Option<f64>,
    /// Attributes of its own.
    pub(crate) texts: Texts,
    /// What is known of the picture.
    pub(crate) facts: Facts,
    /// ZIP if none.
    pub(crate) packing: Option<Packing>,
}

/// Writes an EXR as [`write_new`] does whose channels lie as `windows` say.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel has not one sample a pixel.
pub fn write_placed(path: &Path, windows: Windows, channels: &[NewChannel]) -> Result<()> {
    write_beside(path, windows, channels, Beside::default())
}

/// As [`write_placed`], with what there is beside the pixels.
///
/// # Errors
/// A target that cannot be written.
///
/// # Panics
/// If a channel has not one sample a pixel.
pub(crate) fn write_beside(
    path: &Path,
    windows: Windows,
    channels: &[NewChannel],
    beside: Beside,
) -> Result<()> {
    let Windows { data, display } = windows;
    let mut layer = new_layer(data.width, data.height, channels);
    layer.attributes.layer_position = Vec2(data.x, data.y);
    layer.encoding.compression = beside.packing.unwrap_or(Packing::Zip).compression();
    for (name, text) in &beside.texts {
        let text = AttributeValue::Text(as_text(text));
        layer.attributes.other.insert(as_text(name), text);
    }
    put_facts(&mut layer.attributes, &beside.facts);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window =
        IntegerBounds::new((display.x, display.y), (display.width, display.height));
    image.attributes.pixel_aspect = beside.pixel_aspect.unwrap_or(1.0) as f32;
    image.attributes.time_code = beside.facts.time_code;
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
        // As compositors read fastest; in order, so that the same picture makes the same file.
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    )
}

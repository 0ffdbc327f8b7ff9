//! Tests of all formats, on files made here.

mod common_metadata;
mod conversion;
mod dpx_files;
mod exr_attributes;
mod exr_images;
mod exr_new;
mod hostile;
mod metadata;
mod observation_sets;
mod photographs;
mod png_transfer;
mod raster_images;
mod unusual_files;

use std::path::Path;

use exr::image::{
    AnyChannel, AnyChannels, AnyImage, Blocks, Encoding, FlatSamples, Image, Layer, Levels,
};
use exr::meta::attribute::{IntegerBounds, LineOrder, Text};
use exr::prelude::{Compression, ImageAttributes, LayerAttributes, SmallVec, WritableImage};

/// Name and samples of a channel.
type Channel = (&'static str, FlatSamples);

/// Returns a part of scan lines at `position`.
fn part(
    name: Option<&str>,
    size: (usize, usize),
    position: (i32, i32),
    compression: Compression,
    channels: Vec<Channel>,
) -> Layer<AnyChannels<Levels<FlatSamples>>> {
    let list = channels
        .into_iter()
        .map(|(name, samples)| AnyChannel::new(name, Levels::Singular(samples)))
        .collect();
    let attributes = LayerAttributes {
        layer_name: name.map(Text::from),
        layer_position: position.into(),
        ..LayerAttributes::default()
    };
    Layer::new(
        size,
        attributes,
        Encoding {
            compression,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
        AnyChannels::sort(list),
    )
}

/// Returns an image whose display window, 20 x 10, differs from all data windows.
fn image(parts: Vec<Layer<AnyChannels<Levels<FlatSamples>>>>) -> AnyImage {
    Image {
        attributes: ImageAttributes::new(IntegerBounds::from_dimensions((20, 10))),
        layer_data: SmallVec::from_vec(parts),
    }
}

/// Returns floats that differ between pixels.
fn floats(count: usize) -> FlatSamples {
    FlatSamples::F32((0..count).map(|i| i as f32 * 0.37 + 0.01).collect())
}

/// Returns half floats that differ between pixels.
fn halves(count: usize) -> FlatSamples {
    FlatSamples::F16(
        (0..count)
            .map(|i| half::f16::from_f32(i as f32 * 0.37))
            .collect(),
    )
}

fn save(image: &AnyImage, path: &Path) {
    image.write().to_file(path).expect("the test's own file");
}

/// Overwrites the first occurrence of `from` in a file.
fn patch(path: &Path, from: &[u8], to: &[u8]) {
    let mut bytes = std::fs::read(path).expect("the test's own file");
    let at = bytes
        .windows(from.len())
        .position(|w| w == from)
        .expect("the bytes to patch");
    bytes[at..at + to.len()].copy_from_slice(to);
    std::fs::write(path, bytes).expect("the test's own file");
}

//! Channels of OpenEXR files, and images cut from files that a screen can show.

use std::path::Path;

use exr::prelude::*;
use image::{GenericImageView as _, RgbImage};

/// A part of a plate, px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crop {
    pub(super) left: u32,
    pub(super) top: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

/// Reads the `crop` of an image file.
pub(super) fn part_of_file(path: &Path, crop: Crop) -> std::result::Result<RgbImage, String> {
    let image = image::open(path).map_err(|why| format!("{}: {why}", path.display()))?;
    let part = image.view(crop.left, crop.top, crop.width, crop.height);
    let part = image::DynamicImage::ImageRgba8(part.to_image());
    Ok(part.to_rgb8())
}

/// Reads the `crop` of channel `name` of an OpenEXR file, row by row.
pub(super) fn part_of_channel(
    path: &Path,
    name: &str,
    crop: Crop,
) -> std::result::Result<Vec<f32>, String> {
    let image = read_first_flat_layer_from_file(path)
        .map_err(|why| format!("{}: {why}", path.display()))?;
    let layer = &image.layer_data;
    let channel = (layer.channel_data.list.iter())
        .find(|channel| channel.name.eq(name))
        .ok_or_else(|| format!("{}: has no channel {name}", path.display()))?;
    let origin = layer.attributes.layer_position;
    let samples: Vec<f32> = channel.sample_data.values_as_f32().collect();
    let width = layer.size.width();
    let row_of = |y: u32| (i64::from(y) - origin.y() as i64) as usize * width;
    let first = |y: u32| row_of(y) + (i64::from(crop.left) - origin.x() as i64) as usize;
    let rows = crop.top..crop.top + crop.height;
    Ok(rows
        .flat_map(|y| samples[first(y)..][..crop.width as usize].to_vec())
        .collect())
}

/// Copies an OpenEXR file and applies `change` to each sample of R, G and B.
pub(super) fn with_colour_changed(
    from: &Path,
    to: &Path,
    mut change: impl FnMut(f32) -> f32,
) -> std::result::Result<(), String> {
    let mut image = read_first_flat_layer_from_file(from)
        .map_err(|why| format!("{}: {why}", from.display()))?;
    for channel in &mut image.layer_data.channel_data.list {
        if !["R", "G", "B"].iter().any(|name| channel.name.eq(name)) {
            continue;
        }
        let changed = channel.sample_data.values_as_f32().map(&mut change);
        channel.sample_data = FlatSamples::F32(changed.collect());
    }
    image
        .write()
        .to_file(to)
        .map_err(|why| format!("{}: {why}", to.display()))
}

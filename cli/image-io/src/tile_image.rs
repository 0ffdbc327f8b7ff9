//! The tile of one observation as an image file.

use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Levels};
use exr::meta::attribute::{LineOrder, Text};
use exr::prelude::{Compression, LayerAttributes};
use seidel_core::tile::Tile;

use crate::error::{FileError, Result};
use crate::exr::file::{read_exr, write_exr};
use crate::flat_plate::FlatPlate;
use crate::format::{Format, detect};
use crate::limits::Limits;
use crate::tiff;

/// One channel of a tile as read, not yet checked.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plane {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) samples: Vec<f32>,
}

/// Reads the given channels of a tile, in their order. EXR channels go by their full name, in whatever
/// part; a grey PNG, TIFF or other picture stands for the only channel of a monochrome set.
pub(crate) fn read(path: &Path, channels: &[String]) -> Result<Vec<Plane>> {
    match detect(path)? {
        Format::Exr => read_exr_tile(path, channels),
        _ => read_flat_tile(path, channels),
    }
}

fn read_exr_tile(path: &Path, channels: &[String]) -> Result<Vec<Plane>> {
    let image = read_exr(path, Limits::TILE)?;
    let find = |name: &str| {
        image.layer_data.iter().find_map(|layer| {
            let list = &layer.channel_data.list;
            let channel = list.iter().find(|c| c.name.to_string() == name)?;
            let samples = match &channel.sample_data {
                Levels::Singular(samples) => samples,
                Levels::Mip { level_data, .. } => level_data.first()?,
                Levels::Rip { level_data, .. } => level_data.map_data.first()?,
            };
            Some(Plane {
                width: layer.size.width(),
                height: layer.size.height(),
                samples: match samples {
                    FlatSamples::F16(s) => s.iter().map(|v| v.to_f32()).collect(),
                    FlatSamples::F32(s) => s.clone(),
                    FlatSamples::U32(s) => s.iter().map(|&v| v as f32).collect(),
                },
            })
        })
    };
    let present = || {
        let layers = image.layer_data.iter();
        let names = layers.flat_map(|l| l.channel_data.list.iter().map(|c| c.name.to_string()));
        names.collect::<Vec<_>>()
    };
    all_or_missing(path, channels, find, present)
}

fn read_flat_tile(path: &Path, channels: &[String]) -> Result<Vec<Plane>> {
    let plate = FlatPlate::open_within(path, Limits::TILE)?;
    let find = |name: &str| {
        let grey = plate.names()[0] == "Y" && channels.len() == 1;
        let samples = plate.plane(if grey { "Y" } else { name })?;
        Some(Plane {
            width: plate.width(),
            height: plate.height(),
            samples: samples.to_vec(),
        })
    };
    all_or_missing(path, channels, find, || plate.names().to_vec())
}

fn all_or_missing(
    path: &Path,
    channels: &[String],
    find: impl Fn(&str) -> Option<Plane>,
    present: impl Fn() -> Vec<String>,
) -> Result<Vec<Plane>> {
    let mut planes = Vec::new();
    let mut missing = Vec::new();
    for name in channels {
        match find(name) {
            Some(plane) => planes.push(plane),
            None => missing.push(name.as_str()),
        }
    }
    if missing.is_empty() {
        return Ok(planes);
    }
    Err(FileError::new(
        path,
        format!("channel {}", missing.join(", ")),
        format!("is not in the tile, which has {}", present().join(", ")),
        "write the channel into the tile, or correct `channels` in the manifest",
    ))
}

/// Writes a tile, one channel each of `tiles`: float EXR, or float TIFF where the name says so.
pub(crate) fn write(path: &Path, channels: &[String], tiles: &[Tile]) -> Result<()> {
    let Some(first) = tiles.first() else {
        return Err(FileError::new(
            path,
            "channels",
            "is empty",
            "give at least one channel",
        ));
    };
    let (width, height) = (first.width(), first.height());
    if tiles
        .iter()
        .any(|t| (t.width(), t.height()) != (width, height))
        || tiles.len() != channels.len()
    {
        return Err(FileError::new(
            path,
            "channels",
            "the tiles of one observation differ in size or number from its channels",
            "give one tile a channel, all of one size",
        ));
    }
    if Format::of_name(path) == Some(Format::Tiff) {
        let planes = tiles.iter().map(|t| t.samples().to_vec()).collect();
        return tiff::write::write_float(path, width, height, channels.to_vec(), planes);
    }
    let mut list = Vec::new();
    for (name, tile) in channels.iter().zip(tiles) {
        let named = Text::new_or_none(name).filter(|n| !n.bytes().is_empty());
        let Some(named) = named else {
            return Err(FileError::new(
                path,
                format!("channel {name}"),
                "has a name that OpenEXR cannot hold",
                "use plain letters and digits",
            ));
        };
        list.push(AnyChannel::new(
            named,
            FlatSamples::F32(tile.samples().to_vec()),
        ));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(
        (width, height),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(list.into()),
    );
    write_exr(path, &Image::from_layer(layer), false)
}

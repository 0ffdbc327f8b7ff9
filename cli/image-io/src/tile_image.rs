//! The tile of one PSF observation as an image file.

use std::path::Path;

use exr::meta::attribute::Text;
use seidel_optics::tile::Tile;

use crate::error::{FileError, Result};
use crate::format::Format;
use crate::formats::exr::{NewChannel, write_channels};
use crate::formats::tiff;
use crate::image_file::ImageFile;
use crate::input::Limits;
use crate::windows::ImageWindows;

/// The samples of one channel of a tile, not yet checked.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plane {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) samples: Vec<f32>,
}

/// Reads the given channels of a tile, in their order.
///
/// EXR channels are found by their full name in any part. The grey channel of another format stands for the only
/// channel of a monochrome set.
///
/// # Errors
/// A file that cannot be read, and missing channels.
pub(crate) fn read(path: &Path, channels: &[String]) -> Result<Vec<Plane>> {
    let image = ImageFile::open(path, Limits::TILE)?;
    let names = image.channel_names();
    let is_grey = matches!(image, ImageFile::Raster(_)) && names[0] == "Y" && channels.len() == 1;
    let mut planes = Vec::new();
    let mut missing = Vec::new();
    for channel in channels {
        let found = names.iter().position(|name| name == channel);
        match if is_grey { Some(0) } else { found } {
            Some(index) => {
                let (windows, samples) = image.channel(index);
                planes.push(Plane {
                    width: windows.data.width,
                    height: windows.data.height,
                    samples,
                });
            }
            None => missing.push(channel.as_str()),
        }
    }
    if missing.is_empty() {
        return Ok(planes);
    }
    Err(FileError::new(
        path,
        format!("channel {}", missing.join(", ")),
        format!("is not in the tile, which has {}", names.join(", ")),
        "write the channel into the tile, or correct `channels` in the manifest",
    ))
}

/// Writes a tile with one channel for each of `tiles`: float TIFF if its name has that extension, else float EXR.
///
/// # Errors
/// Tiles that differ in size, names that OpenEXR does not allow, and a file that cannot be written.
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
            "do not match the tiles of an observation in number, or those differ in size",
            "give one tile per channel, all of one size",
        ));
    }
    if Format::from_path(path) == Some(tiff::FORMAT) {
        let planes = tiles.iter().map(|t| t.samples().to_vec()).collect();
        return tiff::write_float(path, width, height, planes);
    }
    let is_unnamable = |name: &&String| name.is_empty() || Text::new_or_none(name).is_none();
    if let Some(name) = channels.iter().find(is_unnamable) {
        return Err(FileError::new(
            path,
            format!("channel {name}"),
            "has a name that OpenEXR does not allow",
            "use plain letters and digits",
        ));
    }
    let mut new = Vec::new();
    for (name, tile) in channels.iter().zip(tiles) {
        let samples = tile.samples();
        new.push(NewChannel {
            name,
            samples,
            half: false,
        });
    }
    write_channels(path, ImageWindows::of_size(width, height), &new)
}

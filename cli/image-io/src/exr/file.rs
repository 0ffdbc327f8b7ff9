//! Whole OpenEXR files: read with bounds on what a header may claim, and written whole.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use exr::block::chunk::Chunk;
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::image::read::image::{LayersReader, ReadLayers};
use exr::image::read::layers::ReadChannels;
use exr::image::write::WritableImage;
use exr::image::{AnyImage, Image};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use rayon::prelude::*;

use crate::atomic::write_whole;
use crate::error::{FileError, Result};
use crate::exr::header::put_right;
use crate::guard::caught;
use crate::limits::{Limits, open};

/// Chunks that are held compressed at once while others are unpacked on all cores.
const BATCH: usize = 64;

/// Reads everything a flat EXR file holds: all parts, channels, resolution levels and attributes.
///
/// # Errors
/// A file that cannot be opened, is damaged, truncated, deep, subsampled, packed by a method that is
/// not supported, or whose header claims more pixels than the file can hold.
pub(crate) fn read_exr(path: &Path, limits: Limits) -> Result<AnyImage> {
    let (file, length) = open(path)?;
    match caught(|| read_open(path, file, length, limits)) {
        Ok(result) => result,
        Err(panic) => Err(damaged(path, &panic)),
    }
}

fn read_open(path: &Path, file: File, length: u64, limits: Limits) -> Result<AnyImage> {
    let refuse = |error: exr::error::Error| refusal(path, &error);
    let reader = block::read(BufReader::new(file), false).map_err(refuse)?;
    let meta = reader.meta_data().clone();
    check_headers(path, &meta, length, limits)?;

    let wanted = exr::image::read::read()
        .no_deep_data()
        .all_resolution_levels()
        .all_channels()
        .all_layers();
    let mut layers = wanted.create_layers_reader(&meta.headers).map_err(refuse)?;
    let mut chunks = reader
        .filter_chunks(false, |meta, tile, block| {
            layers.filter_block(meta, tile, block)
        })
        .map_err(refuse)?;
    let expected = chunks.expected_chunk_count();
    let mut places = HashSet::new();
    loop {
        let batch: Vec<Chunk> = chunks
            .by_ref()
            .take(BATCH)
            .collect::<exr::error::Result<_>>()
            .map_err(refuse)?;
        if batch.is_empty() {
            break;
        }
        // Unpacked here and not by the library's own pool, in which a panic would end the process.
        let blocks: Vec<UncompressedBlock> = batch
            .into_par_iter()
            .map(|chunk| unpack(path, chunk, &meta))
            .collect::<Result<_>>()?;
        for block in blocks {
            places.insert((
                block.index.layer,
                block.index.level,
                block.index.pixel_position,
            ));
            layers.read_block(&meta.headers, block).map_err(refuse)?;
        }
    }
    if places.len() != expected {
        return Err(damaged(
            path,
            &format!(
                "{} of {expected} blocks are missing",
                expected - places.len()
            ),
        ));
    }
    let mut attributes = meta.headers[0].shared_attributes.clone();
    for header in &meta.headers[1..] {
        // The library keeps these once for the whole file, as the format asks; some writers put them
        // on a later part only.
        let other = &header.shared_attributes;
        attributes.time_code = attributes.time_code.or(other.time_code);
        attributes.chromaticities = attributes.chromaticities.or(other.chromaticities);
        for (name, value) in &other.other {
            attributes
                .other
                .entry(name.clone())
                .or_insert_with(|| value.clone());
        }
    }
    Ok(Image {
        attributes,
        layer_data: layers.into_layers(),
    })
}

fn unpack(path: &Path, chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock> {
    match caught(|| UncompressedBlock::decompress_chunk(chunk, meta, false)) {
        Ok(result) => result.map_err(|error| refusal(path, &error)),
        Err(panic) => Err(damaged(path, &panic)),
    }
}

/// Refuses what the library would read wrongly, and sizes that would exhaust the memory.
fn check_headers(path: &Path, meta: &MetaData, length: u64, limits: Limits) -> Result<()> {
    let mut bytes = 0_u128;
    for header in &meta.headers {
        if header.deep {
            return Err(deep(path));
        }
        for channel in &header.channels.list {
            if (channel.sampling.x(), channel.sampling.y()) != (1, 1) {
                return Err(FileError::new(
                    path,
                    format!("channel {}", channel.name),
                    format!(
                        "is subsampled {}x{}",
                        channel.sampling.x(),
                        channel.sampling.y()
                    ),
                    "convert the file to full-resolution R, G, B channels first",
                ));
            }
        }
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        limits.check_sides(path, "dataWindow", width, height)?;
        bytes += pixel_bytes(header);
    }
    limits.check_bytes(path, "dataWindow", bytes, length)
}

/// An upper bound of the bytes that the pixels of a part take in memory.
fn pixel_bytes(header: &Header) -> u128 {
    use exr::meta::attribute::LevelMode;
    let sample_bytes: u128 = header
        .channels
        .list
        .iter()
        .map(|c| c.sample_type.bytes_per_sample() as u128)
        .sum();
    let levels = match header.blocks {
        BlockDescription::ScanLines => 1,
        BlockDescription::Tiles(tiles) => match tiles.level_mode {
            LevelMode::Singular => 1,
            LevelMode::MipMap => 2,
            LevelMode::RipMap => 4,
        },
    };
    header.layer_size.width() as u128 * header.layer_size.height() as u128 * sample_bytes * levels
}

fn deep(path: &Path) -> FileError {
    FileError::new(
        path,
        "",
        "holds deep pixels, which are not supported",
        "flatten it first, with a depth channel Z if the blur shall follow the depth",
    )
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is damaged or truncated ({what})"),
        "copy or render the file again",
    )
}

fn refusal(path: &Path, error: &exr::error::Error) -> FileError {
    use exr::error::Error;
    match error {
        Error::NotSupported(what) if what.contains("deep") => deep(path),
        Error::NotSupported(what) => FileError::new(
            path,
            "",
            format!("uses a feature of OpenEXR that is not supported ({what})"),
            "save it as a flat EXR with ZIP compression first",
        ),
        Error::Io(error) => FileError::io(path, "be read", error),
        Error::Invalid(what) => damaged(path, what),
        Error::Aborted => damaged(path, "reading was stopped"),
    }
}

/// Writes an EXR image whole or not at all. `parallel` packs on all cores, which small files do not
/// repay.
///
/// # Errors
/// A target that cannot be written, and attributes that the format does not allow.
pub(crate) fn write_exr<'img, L>(path: &Path, image: &'img Image<L>, parallel: bool) -> Result<()>
where
    L: exr::image::write::layers::WritableLayers<'img> + Sync,
{
    write_whole(path, |out| {
        let options = image.write();
        let options = if parallel {
            options
        } else {
            options.non_parallel()
        };
        caught(|| options.to_buffered(&mut *out))?.map_err(|error| error.to_string())?;
        let ordered = out.flush().and_then(|()| put_right(out.get_mut()));
        ordered.map_err(|error| error.to_string())
    })
}

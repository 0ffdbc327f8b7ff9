//! Reading and writing whole OpenEXR files.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use exr::block::chunk::Chunk;
use exr::block::reader::{ChunksReader, Reader};
use exr::block::{self, UncompressedBlock};
use exr::image::read::image::{LayersReader, ReadLayers};
use exr::image::read::layers::ReadChannels;
use exr::image::write::WritableImage;
use exr::image::{AnyChannels, AnyImage, FlatSamples, Image, Layers, Levels};
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::{Header, standard_names};
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::ImageAttributes;
use rayon::prelude::*;

use super::dwa;
use super::header::{RawAttribute, correct_headers, headers_end, read_headers};
use super::placeholders::insert_dropped;
use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::guard::catch_panic;
use crate::input::InputFile;

/// Number of chunks that are decompressed in parallel. More would hold more compressed chunks in memory.
const BATCH: usize = 64;

/// Reads all parts, channels, resolution levels and attributes of a flat EXR file.
///
/// # Errors
/// A file that is damaged, truncated, deep, subsampled or compressed by an unsupported method, or whose header claims
/// more pixels than the file can hold.
pub(super) fn read_exr(input: &InputFile) -> Result<AnyImage> {
    let refuse = |error: exr::error::Error| refusal(input, &error);
    let mut file = &input.file;
    let stored = read_headers(&mut file).and_then(|stored| file.rewind().map(|()| stored));
    let stored = stored.map_err(|error| input.damaged(&format!("its header: {error}")))?;
    let reader = block::read(BufReader::new(&input.file), false).map_err(refuse)?;
    let meta = reader.meta_data().clone();
    check_headers(input, &meta)?;

    let has_offsets = has_offsets(input, &meta, &stored);
    let layer_data = read_layers(input, reader, &meta, has_offsets)?;
    let mut image = Image {
        attributes: merged_attributes(&meta.headers),
        layer_data,
    };
    for ((layer, header), stored) in image.layer_data.iter_mut().zip(&meta.headers).zip(&stored) {
        for attribute in dropped(header, stored) {
            let RawAttribute { name, kind, value } = attribute;
            insert_dropped(&mut layer.attributes, name, kind, value);
        }
    }
    Ok(image)
}

/// Attributes that the library reads in flat parts and does not write.
const DROPPED: [&[u8]; 2] = [
    standard_names::DEEP_DATA_VERSION,
    standard_names::MAX_SAMPLES,
];

/// Returns the attributes of a part that the library does not write: values that it cannot read, and those that it expects in
/// other kinds of parts.
fn dropped<'a>(header: &Header, stored: &'a [RawAttribute]) -> Vec<&'a RawAttribute> {
    let kept: HashSet<Vec<u8>> = header
        .all_named_attributes()
        .map(|(name, _)| name.to_vec())
        .collect();
    let is_dropped = |own: &&RawAttribute| {
        let is_integer = own.kind == b"int";
        !kept.contains(&own.name) || is_integer && DROPPED.contains(&own.name.as_slice())
    };
    stored.iter().filter(is_dropped).collect()
}

/// The parts of a flat file.
type FlatLayers = Layers<AnyChannels<Levels<FlatSamples>>>;

/// Reads the pixels of all parts.
fn read_layers(
    input: &InputFile,
    reader: Reader<BufReader<&File>>,
    meta: &MetaData,
    has_offsets: bool,
) -> Result<FlatLayers> {
    let refuse = |error: exr::error::Error| refusal(input, &error);
    let wanted = exr::image::read::read()
        .no_deep_data()
        .all_resolution_levels()
        .all_channels()
        .all_layers();
    let mut layers = wanted.create_layers_reader(&meta.headers).map_err(refuse)?;
    if has_offsets {
        let chunks = reader.filter_chunks(false, |meta, tile, block| {
            layers.filter_block(meta, tile, block)
        });
        read_blocks(input, chunks.map_err(refuse)?, meta, &mut layers)?;
    } else {
        read_blocks(
            input,
            reader.all_chunks(false).map_err(refuse)?,
            meta,
            &mut layers,
        )?;
    }
    Ok(layers.into_layers())
}

/// Returns whether the file states where its blocks are. A writer that was stopped leaves zeros; the blocks then follow each
/// other.
fn has_offsets(input: &InputFile, meta: &MetaData, stored: &[Vec<RawAttribute>]) -> bool {
    let count: usize = meta.headers.iter().map(|header| header.chunk_count).sum();
    let mut offsets = Vec::new();
    let mut file = &input.file;
    let mut read = || {
        let place = file.stream_position()?;
        file.seek(SeekFrom::Start(headers_end(stored)))?;
        file.take(8 * count as u64).read_to_end(&mut offsets)?;
        // The library goes on reading where it was.
        file.seek(SeekFrom::Start(place))
    };
    let is_read = read().is_ok();
    let (offsets, _) = offsets.as_chunks::<8>();
    !is_read || offsets.iter().all(|offset| *offset != [0; 8])
}

/// Reads the pixels of the blocks into `layers`.
fn read_blocks<L>(
    input: &InputFile,
    mut chunks: impl ChunksReader,
    meta: &MetaData,
    layers: &mut L,
) -> Result<()>
where
    L: LayersReader,
{
    let refuse = |error: exr::error::Error| refusal(input, &error);
    let expected = chunks.expected_chunk_count();
    let mut found = HashSet::new();
    loop {
        let batch: Vec<Chunk> = chunks
            .by_ref()
            .take(BATCH)
            .collect::<exr::error::Result<_>>()
            .map_err(refuse)?;
        if batch.is_empty() {
            break;
        }
        // Not by the library's own thread pool, in which a panic would end the process.
        let blocks: Vec<UncompressedBlock> = batch
            .into_par_iter()
            .map(|chunk| decompress(input, chunk, meta))
            .collect::<Result<_>>()?;
        for block in blocks {
            found.insert((
                block.index.layer,
                block.index.level,
                block.index.pixel_position,
            ));
            layers.read_block(&meta.headers, block).map_err(refuse)?;
        }
    }
    if found.len() != expected {
        let missing = expected - found.len();
        return Err(input.damaged(&format!("{missing} of {expected} blocks are missing")));
    }
    Ok(())
}

/// Returns the attributes that all parts share. The format stores them once for the whole file, but some writers put
/// them on a later part only.
fn merged_attributes(headers: &[Header]) -> ImageAttributes {
    let mut attributes = headers[0].shared_attributes.clone();
    for Header {
        shared_attributes, ..
    } in &headers[1..]
    {
        attributes.time_code = attributes.time_code.or(shared_attributes.time_code);
        attributes.chromaticities =
            (attributes.chromaticities).or(shared_attributes.chromaticities);
        for (name, value) in &shared_attributes.other {
            let own = attributes.other.entry(name.clone());
            own.or_insert_with(|| value.clone());
        }
    }
    attributes
}

fn decompress(input: &InputFile, chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock> {
    if let Some(header) = meta.headers.get(chunk.layer_index) {
        dwa::check_chunk(header, &chunk.compressed_block).map_err(|why| input.damaged(&why))?;
    }
    match catch_panic(|| UncompressedBlock::decompress_chunk(chunk, meta, false)) {
        Ok(result) => result.map_err(|error| refusal(input, &error)),
        Err(panic) => Err(input.damaged(&panic)),
    }
}

/// Refuses headers that the library would read wrongly, and sizes that would exhaust the memory.
fn check_headers(input: &InputFile, meta: &MetaData) -> Result<()> {
    let mut bytes = 0_u128;
    for header in &meta.headers {
        // The flags of the file count too: a part that lost its type would be read as flat.
        if header.deep || meta.requirements.has_deep_data {
            return Err(deep(input));
        }
        check_attributes(input, header)?;
        for channel in &header.channels.list {
            if (channel.sampling.x(), channel.sampling.y()) != (1, 1) {
                return Err(FileError::new(
                    input.path,
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
        // Bytes are checked for all parts together below.
        input.check_size("dataWindow", width, height, 0)?;
        bytes += pixel_bytes(header);
    }
    input.check_bytes("dataWindow", bytes)
}

/// The attributes that every part has, each with its type.
const REQUIRED: [(&[u8], &str); 10] = [
    (standard_names::CHANNELS, "chlist"),
    (standard_names::CHUNKS, "int"),
    (standard_names::COMPRESSION, "compression"),
    (standard_names::BLOCK_TYPE, "string"),
    (standard_names::DATA_WINDOW, "box2i"),
    (standard_names::DISPLAY_WINDOW, "box2i"),
    (standard_names::LINE_ORDER, "lineOrder"),
    (standard_names::PIXEL_ASPECT, "float"),
    (standard_names::WINDOW_CENTER, "v2f"),
    (standard_names::WINDOW_WIDTH, "float"),
];

/// Refuses attributes that no program could read once they are written again.
fn check_attributes(input: &InputFile, header: &Header) -> Result<()> {
    let own = header.own_attributes.other.iter();
    for (name, value) in own.chain(&header.shared_attributes.other) {
        let is_text = |text: &Text| !text.bytes().is_empty() && !text.bytes().contains(&0);
        let has_type = match value {
            AttributeValue::Custom { kind, .. } => is_text(kind),
            _ => true,
        };
        if !(is_text(name) && has_type) {
            return Err(input.damaged(&format!("attribute `{name}` has no name or type")));
        }
        if let Some((_, kind)) = REQUIRED.iter().find(|(own, _)| *own == name.as_slice()) {
            return Err(FileError::new(
                input.path,
                format!("attribute {name}"),
                format!("is not of the type {kind}, which the format requires"),
                "write the file again with a program that follows the format, such as oiiotool",
            ));
        }
    }
    Ok(())
}

/// Returns an upper bound of the memory that the pixels of a part take, bytes.
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

fn deep(input: &InputFile) -> FileError {
    FileError::new(
        input.path,
        "",
        "holds deep pixels, which are not supported",
        "flatten it first, with a depth channel Z if the blur shall follow the depth",
    )
}

fn refusal(input: &InputFile, error: &exr::error::Error) -> FileError {
    use exr::error::Error;
    match error {
        Error::NotSupported(what) if what.contains("deep") => deep(input),
        Error::NotSupported(what) => {
            input.unsupported(what, "save it as a flat EXR with ZIP compression first")
        }
        Error::Io(error) => FileError::io(input.path, "be read", error),
        Error::Invalid(what) => input.damaged(what),
        Error::Aborted => input.damaged("reading was stopped"),
    }
}

/// Threads that compress an EXR file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compressing {
    /// One for each core.
    Parallel,
    /// The calling thread, which is faster for small files.
    Serial,
}

/// Writes an EXR image, whole or not at all.
///
/// # Errors
/// A target that cannot be written, and attributes that the format does not allow.
pub(crate) fn write_exr<'img, L>(
    path: &Path,
    image: &'img Image<L>,
    compressing: Compressing,
) -> Result<()>
where
    L: exr::image::write::layers::WritableLayers<'img> + Sync,
{
    write_atomically(path, |out| {
        let options = image.write();
        let options = match compressing {
            Compressing::Parallel => options,
            Compressing::Serial => options.non_parallel(),
        };
        catch_panic(|| options.to_buffered(&mut *out))?.map_err(|error| error.to_string())?;
        let corrected = out.flush().and_then(|()| correct_headers(out.get_mut()));
        corrected.map_err(|error| error.to_string())
    })
}

//! Bounds on what the chunks of DWAA and DWAB files claim.
//!
//! The `exr` library allocates the sizes that the leader of a chunk states. A failed allocation ends the process, so that
//! they are checked before it reads the chunk.

use exr::block::chunk::CompressedBlock;
use exr::meta::header::Header;
use exr::prelude::Compression;

/// Number of 64-bit integers in the leader of a chunk.
const COUNTERS: usize = 11;

/// Width and height of the blocks of the cosine transform, pixels.
const BLOCK_PX: usize = 8;

/// Coefficients of a block beside its mean.
const AC_OF_BLOCK: usize = BLOCK_PX * BLOCK_PX - 1;

/// Largest size of run-length encoded bytes over that of the bytes: a run of one takes two.
const RUN_LENGTH_RATIO: usize = 2;

/// Extra bytes that encoders may reserve for run lengths and compression.
const SLACK_BYTES: usize = 1024;

/// Checks the leader of a chunk of `header`'s part, if that part is compressed by DWAA or DWAB.
///
/// # Errors
/// The first size that is larger than the pixels of the chunk, or than the chunk itself.
pub(super) fn check_chunk(header: &Header, block: &CompressedBlock) -> Result<(), String> {
    if !matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    ) {
        return Ok(());
    }
    let bytes = match block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        // Deep data is refused by its header.
        _ => return Ok(()),
    };
    // The library refuses chunks that are shorter, and those beyond the image. Uncompressed pixels have no leader.
    let Some(leader) = leader(bytes) else {
        return Ok(());
    };
    let Some(most) = Largest::of(header, block) else {
        return Ok(());
    };
    if bytes.len() == most.pixel_bytes {
        return Ok(());
    }
    let [
        _version,
        unknown,
        unknown_compressed,
        ac_compressed,
        dc_compressed,
        rle_compressed,
        rle_encoded,
        rle,
        ac_count,
        dc_count,
        _ac_compression,
    ] = leader;
    let run_lengths = RUN_LENGTH_RATIO * most.pixel_bytes + SLACK_BYTES;
    let claims = [
        ("unknown_uncompressed_size", unknown, most.pixel_bytes),
        ("unknown_compressed_size", unknown_compressed, bytes.len()),
        ("ac_compressed_size", ac_compressed, bytes.len()),
        ("dc_compressed_size", dc_compressed, bytes.len()),
        ("rle_compressed_size", rle_compressed, bytes.len()),
        ("rle_uncompressed_size", rle_encoded, run_lengths),
        ("rle_raw_size", rle, most.pixel_bytes),
        ("total_ac_count", ac_count, most.ac_count),
        ("total_dc_count", dc_count, most.dc_count),
    ];
    match claims.iter().find(|(_, claim, most)| *claim > *most as u64) {
        Some((name, claim, most)) => Err(format!(
            "{name} of a DWA chunk is {claim}, of which its pixels have at most {most}"
        )),
        None => Ok(()),
    }
}

/// Returns the counters at the start of a chunk, or `None` if it is shorter.
fn leader(bytes: &[u8]) -> Option<[u64; COUNTERS]> {
    let mut counters = [0; COUNTERS];
    let (words, _) = bytes.as_chunks::<8>();
    for (counter, word) in counters.iter_mut().zip(words) {
        *counter = u64::from_le_bytes(*word);
    }
    (words.len() >= COUNTERS).then_some(counters)
}

/// The largest sizes that the pixels of a chunk can have.
struct Largest {
    /// Bytes of uncompressed pixels.
    pixel_bytes: usize,
    /// Coefficients beside the means, of all channels.
    ac_count: usize,
    /// Means of blocks, of all channels.
    dc_count: usize,
}

impl Largest {
    /// Returns the largest sizes of `block`, or `None` if it lies beyond the image.
    fn of(header: &Header, block: &CompressedBlock) -> Option<Self> {
        let tile = header.get_block_data_indices(block).ok()?;
        let pixels = header.get_absolute_block_pixel_coordinates(tile).ok()?;
        let (width, height) = (pixels.size.width(), pixels.size.height());
        let channels = &header.channels.list;
        let bytes = channels.iter().map(|c| c.sample_type.bytes_per_sample());
        let blocks = width.div_ceil(BLOCK_PX) * height.div_ceil(BLOCK_PX) * channels.len();
        Some(Self {
            pixel_bytes: width * height * bytes.sum::<usize>(),
            ac_count: AC_OF_BLOCK * blocks,
            dc_count: blocks,
        })
    }
}

//! The ancillary chunks of a PNG file, and which of them stay valid when the image is written again.

use std::io::{Read, Seek, SeekFrom};

/// The ancillary chunks of a file.
pub(super) struct AncillaryChunks {
    pub(super) chunks: Vec<Chunk>,
    /// Whether the file is animated.
    pub(super) is_animated: bool,
}

/// Differences of an image to the file that its chunks come from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Changes {
    /// Whether samples have other values.
    pub(super) samples: bool,
    /// Whether samples were expanded from a palette or from fewer than eight bits.
    pub(super) expanded: bool,
}

/// An ancillary chunk.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chunk {
    name: [u8; 4],
    data: Vec<u8>,
    follows_pixels: bool,
}

/// Chunks that state the colour space of the samples (PNG, third edition, section 11.3.2).
const COLOUR_SPACE: [&[u8; 4]; 7] = [
    b"cHRM", b"cICP", b"cLLI", b"gAMA", b"iCCP", b"mDCV", b"sRGB",
];

/// The ICC profile.
pub(super) const ICC_PROFILE: [u8; 4] = *b"iCCP";

/// Ancillary chunks that are read separately (texts) or belong to the stored pixels (palettes).
const EXCLUDED: [&[u8; 4]; 5] = [b"tEXt", b"zTXt", b"iTXt", b"tRNS", b"hIST"];

/// The chunks of an animation.
const ANIMATION: [&[u8; 4]; 3] = [b"acTL", b"fcTL", b"fdAT"];

/// Length of the signature before the first chunk, bytes.
const SIGNATURE_BYTES: u64 = 8;

/// Returns the ancillary chunks of a file of `length` bytes up to the first damage.
pub(super) fn read(file: &mut (impl Read + Seek), length: u64) -> AncillaryChunks {
    let mut chunks = Vec::new();
    let (mut is_animated, mut follows_pixels) = (false, false);
    let mut at = SIGNATURE_BYTES;
    while let Some((name, size)) = read_header(file, at) {
        let end = at + 12 + u64::from(size);
        if end > length || &name == b"IEND" {
            break;
        }
        follows_pixels |= &name == b"IDAT";
        is_animated |= ANIMATION.contains(&&name);
        let is_ancillary = name[0].is_ascii_lowercase();
        if is_ancillary && !EXCLUDED.contains(&&name) && !ANIMATION.contains(&&name) {
            // The checksum covers the name too.
            let mut bytes = vec![0; size as usize + 8];
            if file.seek(SeekFrom::Start(at + 4)).is_err() || file.read_exact(&mut bytes).is_err() {
                break;
            }
            let checksum = bytes.split_off(size as usize + 4);
            if crc32fast::hash(&bytes).to_be_bytes()[..] == checksum[..] {
                let data = bytes.split_off(4);
                chunks.push(Chunk {
                    name,
                    data,
                    follows_pixels,
                });
            }
        }
        at = end;
    }
    AncillaryChunks {
        chunks,
        is_animated,
    }
}

/// Returns the name and size of the chunk at an offset in a file.
fn read_header(file: &mut (impl Read + Seek), at: u64) -> Option<([u8; 4], u32)> {
    file.seek(SeekFrom::Start(at)).ok()?;
    let mut header = [0; 8];
    file.read_exact(&mut header).ok()?;
    let [a, b, c, d, name @ ..] = header;
    let is_name = name.iter().all(u8::is_ascii_alphabetic);
    is_name.then_some((name, u32::from_be_bytes([a, b, c, d])))
}

impl Chunk {
    /// Returns the name.
    pub(super) fn name(&self) -> [u8; 4] {
        self.name
    }

    /// Returns the name as text.
    pub(super) fn name_text(&self) -> String {
        self.name.iter().copied().map(char::from).collect()
    }

    /// Returns the data.
    pub(super) fn data(&self) -> &[u8] {
        &self.data
    }

    /// Returns whether the chunk follows the pixels in the file.
    pub(super) fn follows_pixels(&self) -> bool {
        self.follows_pixels
    }

    /// Returns whether the chunk states the colour space of the samples.
    pub(super) fn is_colour_space(&self) -> bool {
        COLOUR_SPACE.contains(&&self.name)
    }

    /// Returns whether the chunk is still valid when the image is written again after these changes.
    ///
    /// Chunks whose last letter is a small one may be copied to a changed image; others only to an unchanged one.
    pub(super) fn is_valid(&self, changes: Changes) -> bool {
        match &self.name {
            b"bKGD" => !changes.expanded,
            b"sBIT" => !changes.expanded && !changes.samples,
            _ => self.is_colour_space() || self.name[3].is_ascii_lowercase() || !changes.samples,
        }
    }
}

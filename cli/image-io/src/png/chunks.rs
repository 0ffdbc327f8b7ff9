//! The chunks of a PNG file beside its pixels and texts: which there are, and which still hold for a picture written anew.

use std::io::{Read, Seek, SeekFrom};

/// A chunk as it lies in a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chunk {
    name: [u8; 4],
    data: Vec<u8>,
    /// Whether it stands behind the pixels.
    behind: bool,
}

/// Those that say what codes are as colour (PNG, third edition, section 11.3.2).
const COLOUR: [&[u8; 4]; 7] = [
    b"cHRM", b"cICP", b"cLLI", b"gAMA", b"iCCP", b"mDCV", b"sRGB",
];

/// The colour profile.
pub(crate) const PROFILE: [u8; 4] = *b"iCCP";

/// Ancillary chunks that are kept otherwise or are part of how pixels are stored: texts, and what belongs to a palette.
const NOT_CARRIED: [&[u8; 4]; 5] = [b"tEXt", b"zTXt", b"iTXt", b"tRNS", b"hIST"];

/// The chunks of an animation.
const ANIMATION: [&[u8; 4]; 3] = [b"acTL", b"fcTL", b"fdAT"];

/// Bytes of a file before its first chunk.
const SIGNATURE: u64 = 8;

/// The chunks of a file that are not the picture itself, up to where it is damaged; and whether it is animated.
pub(crate) fn read(file: &mut (impl Read + Seek), length: u64) -> (Vec<Chunk>, bool) {
    let (mut chunks, mut animated, mut behind) = (Vec::new(), false, false);
    let mut at = SIGNATURE;
    while let Some((name, size)) = head(file, at) {
        let end = at + 12 + u64::from(size);
        if end > length || &name == b"IEND" {
            break;
        }
        behind |= &name == b"IDAT";
        animated |= ANIMATION.contains(&&name);
        let ancillary = name[0].is_ascii_lowercase();
        let carried = ancillary && !NOT_CARRIED.contains(&&name) && !ANIMATION.contains(&&name);
        if carried {
            // The checksum is of the name too.
            let mut bytes = vec![0; size as usize + 8];
            if file.seek(SeekFrom::Start(at + 4)).is_err() || file.read_exact(&mut bytes).is_err() {
                break;
            }
            let stated = bytes.split_off(size as usize + 4);
            if crc32fast::hash(&bytes).to_be_bytes()[..] == stated[..] {
                let data = bytes.split_off(4);
                chunks.push(Chunk { name, data, behind });
            }
        }
        at = end;
    }
    (chunks, animated)
}

/// Name and size of the chunk that begins at a place in a file.
fn head(file: &mut (impl Read + Seek), at: u64) -> Option<([u8; 4], u32)> {
    file.seek(SeekFrom::Start(at)).ok()?;
    let mut head = [0; 8];
    file.read_exact(&mut head).ok()?;
    let [a, b, c, d, name @ ..] = head;
    let named = name.iter().all(u8::is_ascii_alphabetic);
    named.then_some((name, u32::from_be_bytes([a, b, c, d])))
}

impl Chunk {
    /// Its name.
    pub(crate) fn name(&self) -> [u8; 4] {
        self.name
    }

    /// Its name, to be read.
    pub(crate) fn in_letters(&self) -> String {
        self.name.iter().copied().map(char::from).collect()
    }

    /// What it holds.
    pub(crate) fn data(&self) -> &[u8] {
        &self.data
    }

    /// Whether it stands behind the pixels.
    pub(crate) fn is_behind(&self) -> bool {
        self.behind
    }

    /// Whether it says what codes are as colour.
    pub(crate) fn is_colour(&self) -> bool {
        COLOUR.contains(&&self.name)
    }

    /// Whether it holds for a picture written anew, of which samples have `changed` or not and whose kind and bits are
    /// `as_read` or not. A small last letter is the format's own sign for that; others hold where nothing has changed.
    pub(crate) fn holds(&self, changed: bool, as_read: bool) -> bool {
        match &self.name {
            b"bKGD" => as_read,
            b"sBIT" => as_read && !changed,
            _ => self.is_colour() || self.name[3].is_ascii_lowercase() || !changed,
        }
    }
}

//! Mutations of PNG chunks with correct checksums, so that they reach the decoder.

use super::integers;
use crate::rng::Rng;

const SIGNATURE: usize = 8;

/// A chunk: its type and its data.
struct Chunk {
    name: [u8; 4],
    data: Vec<u8>,
}

/// Changes the data of a chunk.
pub(crate) fn change_data(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |chunks, rng| {
        let at = rng.below(chunks.len());
        let data = &mut chunks[at].data;
        match rng.below(5) {
            0 => data.truncate(rng.below(data.len())),
            1 => data.extend((0..rng.below(300)).map(|k| k as u8)),
            _ => integers::overwrite_within(data, rng),
        }
    });
}

/// Changes a field of the header.
pub(crate) fn change_header(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |chunks, rng| {
        let data = &mut chunks[0].data;
        let fields = [0..4, 4..8, 8..9, 9..10, 10..11, 11..12, 12..13];
        let field = rng.pick(&fields).clone();
        if let Some(field) = data.get_mut(field) {
            if field.len() == 1 {
                field[0] = *rng.pick(&[0, 1, 2, 3, 4, 6, 8, 16, 255]);
            } else {
                integers::put(field, rng);
            }
        }
    });
}

/// Removes a chunk.
pub(crate) fn drop_chunk(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |chunks, rng| {
        chunks.remove(rng.below(chunks.len()));
    });
}

/// Repeats a chunk.
pub(crate) fn duplicate_chunk(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |chunks, rng| {
        let at = rng.below(chunks.len());
        let (name, data) = (chunks[at].name, chunks[at].data.clone());
        let to = rng.below(chunks.len() + 1);
        chunks.insert(to, Chunk { name, data });
    });
}

/// Exchanges two chunks.
pub(crate) fn swap_chunks(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |chunks, rng| {
        let (a, b) = (rng.below(chunks.len()), rng.below(chunks.len()));
        chunks.swap(a, b);
    });
}

/// Inserts an ancillary chunk, empty, short or long.
pub(crate) fn insert_chunk(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |chunks, rng| {
        let names = [
            *b"gAMA", *b"cHRM", *b"iCCP", *b"sRGB", *b"tEXt", *b"zTXt", *b"iTXt", *b"PLTE",
            *b"tRNS", *b"pHYs", *b"acTL", *b"fcTL", *b"fdAT", *b"eXIf", *b"cICP", *b"sBIT",
        ];
        let name = *rng.pick(&names);
        let length = *rng.pick(&[0, 1, 4, 9, 26, 32, 700]);
        let data = (0..length).map(|_| rng.next() as u8).collect();
        let to = rng.below(chunks.len() + 1);
        chunks.insert(to, Chunk { name, data });
    });
}

/// Changes the length of a chunk without its data.
pub(crate) fn change_length(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let mut starts = Vec::new();
    let mut at = SIGNATURE;
    while let Some(length) = length_at(bytes, at) {
        starts.push(at);
        at += 12 + length;
    }
    if starts.is_empty() {
        return;
    }
    let at = *rng.pick(&starts);
    integers::put(&mut bytes[at..at + 4], rng);
}

fn length_at(bytes: &[u8], at: usize) -> Option<usize> {
    let field: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
    let length = u32::from_be_bytes(field) as usize;
    bytes.get(at + 8..at + 12 + length).map(|_| length)
}

/// Edits the chunks of a file and writes them again with their lengths and checksums.
fn edit(bytes: &mut Vec<u8>, rng: &mut Rng, change: impl FnOnce(&mut Vec<Chunk>, &mut Rng)) {
    let mut chunks = Vec::new();
    let mut at = SIGNATURE;
    while let Some(length) = length_at(bytes, at) {
        let data = bytes[at + 8..at + 8 + length].to_vec();
        let name = [bytes[at + 4], bytes[at + 5], bytes[at + 6], bytes[at + 7]];
        chunks.push(Chunk { name, data });
        at += 12 + length;
    }
    if chunks.is_empty() {
        return;
    }
    change(&mut chunks, rng);
    bytes.truncate(SIGNATURE);
    for chunk in chunks {
        bytes.extend((chunk.data.len() as u32).to_be_bytes());
        let body = [&chunk.name[..], &chunk.data].concat();
        bytes.extend(&body);
        bytes.extend(crc32fast::hash(&body).to_be_bytes());
    }
}

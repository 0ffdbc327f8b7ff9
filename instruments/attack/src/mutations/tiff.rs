//! Mutations of the directories of TIFF and DNG files.

use super::integers;
use crate::rng::Rng;

/// Length of an entry of a directory, bytes.
const ENTRY: usize = 12;

/// Most entries of a directory that are looked at.
const MAX_ENTRIES: usize = 400;

/// Tags that decide how a file is read, of TIFF and DNG.
const TAGS: [u16; 34] = [
    254, 256, 257, 258, 259, 262, 266, 273, 274, 277, 278, 279, 284, 317, 320, 322, 323, 324, 325,
    330, 338, 339, 33421, 33422, 34665, 34675, 50706, 50712, 50713, 50714, 50717, 50829, 51022,
    51041,
];

/// Changes the value or offset of an entry.
pub(crate) fn change_value(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change_field(bytes, rng, 8, 4);
}

/// Changes the number of values of an entry.
pub(crate) fn change_count(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change_field(bytes, rng, 4, 4);
}

/// Changes the type of an entry.
pub(crate) fn change_type(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let is_little = bytes.first() == Some(&b'I');
    if let Some(at) = entry(bytes, rng) {
        let kind = rng.below(20) as u16;
        put16(bytes, at + 2, kind, is_little);
    }
}

/// Changes the tag of an entry.
pub(crate) fn change_tag(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let is_little = bytes.first() == Some(&b'I');
    if let Some(at) = entry(bytes, rng) {
        let tag = *rng.pick(&TAGS);
        put16(bytes, at, tag, is_little);
    }
}

/// Exchanges the values of two entries.
pub(crate) fn swap_entries(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    if let (Some(a), Some(b)) = (entry(bytes, rng), entry(bytes, rng)) {
        for k in 2..ENTRY {
            bytes.swap(a + k, b + k);
        }
    }
}

/// Changes the offset of the next directory, also to a directory that was read before.
pub(crate) fn link_directory(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let entries = entries(bytes);
    let (Some(first), Some(last)) = (entries.first(), entries.last()) else {
        return;
    };
    let (start, end) = (first - 2, last + ENTRY);
    let is_little = bytes.first() == Some(&b'I');
    if let Some(field) = bytes.get_mut(end..end + 4) {
        if rng.once_in(2) {
            integers::put(field, rng);
        } else {
            let start = start as u32;
            let link = if is_little {
                start.to_le_bytes()
            } else {
                start.to_be_bytes()
            };
            field.copy_from_slice(&link);
        }
    }
}

fn change_field(bytes: &mut [u8], rng: &mut Rng, offset: usize, size: usize) {
    if let Some(at) = entry(bytes, rng)
        && let Some(field) = bytes.get_mut(at + offset..at + offset + size)
    {
        // Short values take the first half of the field.
        let half = if rng.once_in(2) { size / 2 } else { size };
        integers::put(&mut field[..half], rng);
    }
}

fn put16(bytes: &mut [u8], at: usize, value: u16, is_little: bool) {
    let value = if is_little {
        value.to_le_bytes()
    } else {
        value.to_be_bytes()
    };
    if let Some(field) = bytes.get_mut(at..at + 2) {
        field.copy_from_slice(&value);
    }
}

fn entry(bytes: &[u8], rng: &mut Rng) -> Option<usize> {
    let entries = entries(bytes);
    (!entries.is_empty()).then(|| *rng.pick(&entries))
}

/// Returns the offsets of the entries of the first directory.
fn entries(bytes: &[u8]) -> Vec<usize> {
    let is_little = bytes.first() == Some(&b'I');
    let number = |at: usize, size: usize| -> Option<usize> {
        let field = bytes.get(at..at.checked_add(size)?)?;
        let byte = |k: usize| usize::from(field[if is_little { size - 1 - k } else { k }]);
        Some((0..size).fold(0, |sum, k| sum << 8 | byte(k)))
    };
    let Some(start) = number(4, 4) else {
        return Vec::new();
    };
    let count = number(start, 2).unwrap_or(0).min(MAX_ENTRIES);
    let entry = (0..count).map(|k| start + 2 + k * ENTRY);
    entry.take_while(|at| at + ENTRY <= bytes.len()).collect()
}

//! Mutations of OpenEXR headers, chunk tables and chunks. Everything else stays consistent: attributes that change their
//! length move the chunks, and the offsets of the chunk table follow.

mod layout;

use super::{bytes as any, integers};
use crate::rng::Rng;

use layout::{Attribute, Layout};

/// Types of attributes.
const TYPES: [&str; 16] = [
    "box2i",
    "box2f",
    "chlist",
    "compression",
    "double",
    "float",
    "int",
    "keycode",
    "lineOrder",
    "m44f",
    "preview",
    "rational",
    "string",
    "stringvector",
    "tiledesc",
    "v2f",
];

/// Names that decide how a file is read.
const NAMES: [&str; 14] = [
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "tiles",
    "type",
    "name",
    "chunkCount",
    "view",
    "version",
    "maxSamplesPerPixel",
];

/// Changes the value of an attribute.
pub(crate) fn change_value(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |attribute, rng| {
        let value = &mut attribute.value;
        match rng.below(8) {
            0 => value.truncate(rng.below(value.len())),
            1 => value.extend((0..rng.below(40)).map(|k| 65 + k as u8 % 26)),
            2 if !value.is_empty() => {
                let at = rng.below(value.len());
                value[at] = rng.next() as u8;
            }
            3 => put_float(value, rng),
            _ => put_field(value, rng),
        }
    });
}

/// Changes the type of an attribute.
pub(crate) fn change_type(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |attribute, rng| {
        attribute.kind = rng.pick(&TYPES).as_bytes().to_vec();
    });
}

/// Changes the name of an attribute: to a known one, one with other characters, or a long one.
pub(crate) fn change_name(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |attribute, rng| match rng.below(4) {
        0 => attribute.name = rng.pick(&NAMES).as_bytes().to_vec(),
        1 => attribute.name.extend("\u{1b}[2J\u{e9}".bytes()),
        2 => attribute.name = b"x".repeat(*rng.pick(&[1, 31, 32, 255, 256, 3000])),
        _ => attribute.name.push(0x80 | rng.next() as u8),
    });
}

/// Changes the length of a value without the value.
pub(crate) fn change_size(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit(bytes, rng, |attribute, rng| {
        let mut size = (attribute.value.len() as i32).to_le_bytes();
        integers::put(&mut size, rng);
        attribute.size = i32::from_le_bytes(size);
    });
}

/// Removes an attribute.
pub(crate) fn drop_attribute(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit_list(bytes, rng, |list, at, _| {
        list.remove(at);
    });
}

/// Repeats an attribute, sometimes often.
pub(crate) fn duplicate_attribute(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit_list(bytes, rng, |list, at, rng| {
        let copy = list[at].clone();
        let count = if rng.once_in(10) { 300 } else { 1 };
        list.extend(std::iter::repeat_n(copy, count));
    });
}

/// Gives an attribute the value of another.
pub(crate) fn swap_attribute(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    edit_list(bytes, rng, |list, at, rng| {
        let from = rng.below(list.len());
        list[at].value = list[from].value.clone();
        list[at].size = list[from].size;
    });
}

/// Changes an offset of the chunk table: a hostile integer, or another chunk.
pub(crate) fn change_offset(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let Some(layout) = Layout::read(bytes) else {
        return;
    };
    let table = layout.table..layout.chunks.min(bytes.len());
    let count = table.len() / 8;
    if count == 0 {
        return;
    }
    let at = table.start + 8 * rng.below(count);
    if rng.once_in(2) {
        let from = table.start + 8 * rng.below(count);
        bytes.copy_within(from..from + 8, at);
    } else {
        integers::put(&mut bytes[at..at + 8], rng);
    }
}

/// Changes an integer at the head of a chunk: part, place or length.
pub(crate) fn change_chunk(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let Some(at) = chunk(bytes, rng) else {
        return;
    };
    let at = at + 4 * rng.below(6);
    if let Some(field) = bytes.get_mut(at..at + 4) {
        integers::put(field, rng);
    }
}

/// Changes the data of a chunk, mostly at its start, where compressions have their counters.
pub(crate) fn change_chunk_data(bytes: &mut Vec<u8>, rng: &mut Rng, other: &[u8]) {
    let Some(at) = chunk(bytes, rng) else {
        return;
    };
    let start = (at + 8).min(bytes.len());
    let end = if rng.once_in(3) {
        bytes.len()
    } else {
        (start + 110).min(bytes.len())
    };
    if rng.once_in(3) {
        let mut part = bytes[start..end].to_vec();
        any::flip_bits(&mut part, rng, other);
        bytes[start..end].copy_from_slice(&part);
    } else {
        integers::overwrite_within(&mut bytes[start..end], rng);
    }
}

/// Changes a flag of the version field.
pub(crate) fn change_version(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    if bytes.len() > 8 {
        bytes[5] ^= 1 << (1 + rng.below(4));
    }
}

/// Writes an integer into a value at a multiple of four, or a byte.
fn put_field(value: &mut [u8], rng: &mut Rng) {
    if value.len() < 4 {
        integers::put(value, rng);
        return;
    }
    let at = 4 * rng.below(value.len() / 4);
    integers::put(&mut value[at..at + 4], rng);
}

/// Writes a float that breaks arithmetic into a value.
fn put_float(value: &mut [u8], rng: &mut Rng) {
    let floats = [
        0.0,
        -0.0,
        -1.0,
        1e-40,
        1e38,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
        1e-6,
        1e6,
    ];
    if value.len() >= 4 {
        let at = 4 * rng.below(value.len() / 4);
        value[at..at + 4].copy_from_slice(&rng.pick(&floats).to_le_bytes());
    }
}

/// Returns the offset of a chunk that the table names.
fn chunk(bytes: &[u8], rng: &mut Rng) -> Option<usize> {
    let layout = Layout::read(bytes)?;
    let count = layout.chunks.checked_sub(layout.table)? / 8;
    let at = layout.table + 8 * rng.below(count);
    let field: [u8; 8] = bytes.get(at..at + 8)?.try_into().ok()?;
    usize::try_from(u64::from_le_bytes(field))
        .ok()
        .filter(|at| *at < bytes.len())
}

fn edit(bytes: &mut Vec<u8>, rng: &mut Rng, change: impl FnOnce(&mut Attribute, &mut Rng)) {
    edit_list(bytes, rng, |list, at, rng| change(&mut list[at], rng));
}

/// Edits the attributes of one part.
fn edit_list(
    bytes: &mut Vec<u8>,
    rng: &mut Rng,
    change: impl FnOnce(&mut Vec<Attribute>, usize, &mut Rng),
) {
    let Some(mut layout) = Layout::read(bytes) else {
        return;
    };
    let part = rng.below(layout.parts.len());
    let list = &mut layout.parts[part];
    if list.is_empty() {
        return;
    }
    let at = rng.below(list.len());
    change(list, at, rng);
    *bytes = layout.write(bytes);
}

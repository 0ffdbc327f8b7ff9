//! Integers that break arithmetic, at fields of binary headers.

use crate::rng::Rng;

/// Length of the part of a file that counts as its header.
const HEADER: usize = 900;

const HOSTILE: [u64; 26] = [
    0,
    1,
    2,
    3,
    7,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    100_000,
    0x00ff_ffff,
    0x7fff_fffe,
    0x7fff_ffff,
    0x8000_0000,
    0x8000_0001,
    0xffff_fffe,
    0xffff_ffff,
    0x1_0000_0000,
    1 << 40,
    1 << 62,
    i64::MAX as u64,
    u64::MAX,
];

/// Overwrites integers near the start of a file.
pub(crate) fn overwrite_in_header(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let end = bytes.len().min(HEADER);
    overwrite_within(&mut bytes[..end], rng);
}

/// Overwrites integers anywhere.
pub(crate) fn overwrite_anywhere(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    overwrite_within(bytes, rng);
}

/// Overwrites an integer of 1, 2, 4 or 8 bytes by a hostile one, or changes it a little.
pub(crate) fn overwrite_within(bytes: &mut [u8], rng: &mut Rng) {
    let size = *rng.pick(&[1, 2, 2, 4, 4, 4, 8]);
    if bytes.len() < size {
        return;
    }
    let mut at = rng.below(bytes.len() - size + 1);
    if rng.once_in(2) {
        at -= at % size;
    }
    let field = &mut bytes[at..at + size];
    put(field, rng);
}

/// Writes a hostile integer into a field of 1 to 8 bytes.
pub(crate) fn put(field: &mut [u8], rng: &mut Rng) {
    let size = field.len().min(8);
    let mut old = [0; 8];
    old[..size].copy_from_slice(&field[..size]);
    let is_little = !rng.once_in(3);
    let value = match rng.below(4) {
        0 => {
            let step = rng.below(9) as u64;
            u64::from_le_bytes(old).wrapping_add(step).wrapping_sub(4)
        }
        1 => rng.next() >> rng.below(64),
        _ => *rng.pick(&HOSTILE),
    };
    let encoded = value.to_le_bytes();
    for (k, byte) in field.iter_mut().take(size).enumerate() {
        *byte = encoded[if is_little { k } else { size - 1 - k }];
    }
}

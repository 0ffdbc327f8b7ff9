//! Mutations of bytes without regard to their meaning.

use crate::rng::Rng;

/// Longest range that is repeated, removed or appended.
const LONGEST: usize = 4096;

/// Flips one to eight bits.
pub(crate) fn flip_bits(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    if bytes.is_empty() {
        return;
    }
    for _ in 0..=rng.below(8) {
        let at = rng.below(bytes.len());
        bytes[at] ^= 1 << rng.below(8);
    }
}

/// Overwrites a range by random bytes or by one byte.
pub(crate) fn overwrite(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let range = range(bytes, rng);
    let constant = rng.once_in(2).then(|| *rng.pick(&[0, 0xff, 0x7f, 0x80]));
    for byte in &mut bytes[range] {
        *byte = constant.unwrap_or_else(|| rng.next() as u8);
    }
}

/// Cuts the end off.
pub(crate) fn truncate(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    bytes.truncate(rng.below(bytes.len()));
}

/// Appends random bytes.
pub(crate) fn grow(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    for _ in 0..rng.below(LONGEST) {
        bytes.push(rng.next() as u8);
    }
}

/// Joins the beginning of one seed to the end of another, or copies a range.
pub(crate) fn splice(bytes: &mut Vec<u8>, rng: &mut Rng, other: &[u8]) {
    if rng.once_in(3) {
        bytes.truncate(rng.below(bytes.len()));
        bytes.extend_from_slice(&other[rng.below(other.len())..]);
        return;
    }
    let from = range(other, rng);
    let at = rng.below(bytes.len());
    let length = from.len().min(bytes.len() - at);
    bytes[at..at + length].copy_from_slice(&other[from.start..from.start + length]);
}

/// Inserts a copy of a range.
pub(crate) fn repeat(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let range = range(bytes, rng);
    let copy = bytes[range].to_vec();
    let at = rng.below(bytes.len() + 1);
    bytes.splice(at..at, copy);
}

/// Removes a range.
pub(crate) fn remove(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let range = range(bytes, rng);
    bytes.drain(range);
}

/// Picks a range, mostly a short one.
fn range(bytes: &[u8], rng: &mut Rng) -> std::ops::Range<usize> {
    let start = rng.below(bytes.len());
    let longest = *rng.pick(&[4, 16, 64, LONGEST]);
    start..(start + rng.below(longest)).min(bytes.len())
}

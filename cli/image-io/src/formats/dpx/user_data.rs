//! Provenance in the user data of a DPX file.

use super::byte_order::ByteOrder;
use super::header::{HEADER_BYTES, set_offset, set_user_data_length, user_data_length};
use crate::metadata::TextAttributes;
use crate::provenance::header_lines;

/// The user identification: the first 32 bytes of the user data.
const IDENTIFICATION: &[u8; 32] = b"Seidel\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// Returns the user data among the bytes before the pixels.
fn user_data(start: &[u8], order: ByteOrder) -> &[u8] {
    let end = HEADER_BYTES.saturating_add(user_data_length(start, order));
    &start[HEADER_BYTES..end.min(start.len())]
}

/// Returns the provenance among the bytes before the pixels.
pub(super) fn texts(start: &[u8], order: ByteOrder) -> TextAttributes {
    let own = user_data(start, order).strip_prefix(IDENTIFICATION);
    let lines = own.into_iter().flat_map(|own| own.split(|&b| b == b'\n'));
    header_lines::texts(lines)
}

/// Returns whether another program has written data after the header.
pub(super) fn is_foreign(start: &[u8], order: ByteOrder) -> bool {
    let user_data = user_data(start, order);
    let beyond = &start[HEADER_BYTES + user_data.len()..];
    let is_other = !user_data.is_empty() && !user_data.starts_with(IDENTIFICATION);
    // Unused bytes are zeros or ones.
    is_other || beyond.iter().any(|&b| b != 0 && b != 0xff)
}

/// Returns the bytes before the pixels with their provenance replaced by that of `texts`. They grow if necessary, and
/// are unchanged if they hold data of another program.
pub(super) fn with_texts(start: &[u8], order: ByteOrder, texts: &TextAttributes) -> Vec<u8> {
    let lines = header_lines::lines(texts);
    if is_foreign(start, order) || (lines.is_empty() && user_data(start, order).is_empty()) {
        return start.to_vec();
    }
    let mut data = IDENTIFICATION.to_vec();
    for line in &lines {
        data.extend(line.as_bytes());
        data.push(b'\n');
    }
    let mut new = start[..HEADER_BYTES].to_vec();
    set_user_data_length(&mut new, order, data.len());
    new.extend(data);
    let end = HEADER_BYTES + user_data(start, order).len();
    new.resize(new.len().next_multiple_of(4).max(end), 0);
    let rest = start.get(new.len()..).unwrap_or_default();
    new.extend(rest);
    let length = new.len();
    set_offset(&mut new, order, length);
    new
}

//! Texts of ours in the user data of a DPX file.

use super::header::{HEADER, set_offset, set_user_data, user_data};
use crate::provenance::Texts;
use crate::text_lines;

/// Who the user data are of, in the 32 bytes that they begin with.
const IDENTIFICATION: &[u8; 32] = b"Seidel\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// The user data among the bytes before the pixels; empty where there are none.
fn stated(lead: &[u8], big_endian: bool) -> &[u8] {
    let end = HEADER.saturating_add(user_data(lead, big_endian));
    &lead[HEADER..end.min(lead.len())]
}

/// The texts of ours that a file holds before its pixels.
pub(crate) fn texts(lead: &[u8], big_endian: bool) -> Texts {
    let own = stated(lead, big_endian).strip_prefix(IDENTIFICATION);
    let lines = own.into_iter().flat_map(|own| own.split(|&b| b == b'\n'));
    text_lines::texts(lines)
}

/// Whether there is something of others where our texts would stand.
pub(crate) fn is_taken(lead: &[u8], big_endian: bool) -> bool {
    let stated = stated(lead, big_endian);
    let beyond = &lead[HEADER + stated.len()..];
    let foreign = !stated.is_empty() && !stated.starts_with(IDENTIFICATION);
    // Nothing is written as zeros or as ones.
    foreign || beyond.iter().any(|&b| b != 0 && b != 0xff)
}

/// The bytes before the pixels with `texts` in place of those that they hold. They grow where there is no room, and stay
/// as they are where it is taken.
pub(crate) fn with_texts(lead: &[u8], big_endian: bool, texts: &Texts) -> Vec<u8> {
    let lines = text_lines::lines(texts);
    if is_taken(lead, big_endian) || (lines.is_empty() && stated(lead, big_endian).is_empty()) {
        return lead.to_vec();
    }
    let mut data = IDENTIFICATION.to_vec();
    for line in &lines {
        data.extend(line.as_bytes());
        data.push(b'\n');
    }
    let mut new = lead[..HEADER].to_vec();
    set_user_data(&mut new, big_endian, data.len());
    new.extend(data);
    let end = HEADER + stated(lead, big_endian).len();
    new.resize(new.len().next_multiple_of(4).max(end), 0);
    let rest = lead.get(new.len()..).unwrap_or_default();
    new.extend(rest);
    let length = new.len();
    set_offset(&mut new, big_endian, length);
    new
}

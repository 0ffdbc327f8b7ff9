//! Texts of ours in the user data of a DPX file.

use super::header::{HEADER, set_offset, set_user_data, user_data};
use crate::files::provenance::Texts;
use crate::files::text_lines::{lines, text};

/// Who the user data are of, in the 32 bytes that they begin with.
const IDENTIFICATION: &[u8; 32] = b"Seidel\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// The user data among the bytes before the pixels; empty where there are none.
fn stated(lead: &[u8], big_endian: bool) -> &[u8] {
    let end = HEADER.saturating_add(user_data(lead, big_endian));
    &lead[HEADER..end.min(lead.len())]
}

/// The texts of ours that a file holds before its pixels.
pub(super) fn texts(lead: &[u8], big_endian: bool) -> Texts {
    let own = stated(lead, big_endian).strip_prefix(IDENTIFICATION);
    let lines = own.into_iter().flat_map(|own| own.split(|&b| b == b'\n'));
    lines.filter_map(text).collect()
}

/// Whether there is something of others where our texts would stand.
pub(super) fn is_taken(lead: &[u8], big_endian: bool) -> bool {
    let stated = stated(lead, big_endian);
    let beyond = &lead[HEADER + stated.len()..];
    let foreign = !stated.is_empty() && !stated.starts_with(IDENTIFICATION);
    foreign || beyond.iter().any(|&b| b != 0)
}

/// The bytes before the pixels with `texts` in place of those that they hold. They grow where there is no room, and stay
/// as they are where it is taken.
pub(super) fn with_texts(lead: &[u8], big_endian: bool, texts: &Texts) -> Vec<u8> {
    let lines = lines(texts);
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
    let length = new.len().next_multiple_of(4).max(lead.len());
    new.resize(length, 0);
    set_offset(&mut new, big_endian, length);
    new
}

//! JSON and other text files, read with a limit of their size.

use std::io::{Read, Write};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::input::open_file;

/// Limit of the length of text files, bytes: far above any real manifest or profile.
pub const TEXT_LIMIT_BYTES: u64 = 256 * 1024 * 1024;

/// The byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads a text file of at most `limit_bytes`, without the byte order mark that some editors write first.
///
/// # Errors
/// A file that cannot be read, is longer, or is not UTF-8.
pub fn read_text(path: &Path, limit_bytes: u64) -> Result<String> {
    let mut bytes = read_bytes(path, limit_bytes)?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    String::from_utf8(bytes).map_err(|error| {
        FileError::new(
            path,
            "",
            format!(
                "is not UTF-8 text (byte {})",
                error.utf8_error().valid_up_to()
            ),
            "save it as plain UTF-8 text",
        )
    })
}

/// Reads a whole file of at most `limit_bytes`.
///
/// # Errors
/// A file that cannot be read or is longer.
pub fn read_bytes(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    let unreadable = |error: &std::io::Error| FileError::io(path, "be read", error);
    let file = open_file(path)?;
    let mut bytes = Vec::new();
    // One byte more than allowed, which shows an excess even if the length of the file is unknown.
    file.take(limit_bytes.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|e| unreadable(&e))?;
    if bytes.len() as u64 > limit_bytes {
        return Err(FileError::new(
            path,
            "",
            format!("is longer than {limit_bytes} bytes"),
            "check that it is the right file",
        ));
    }
    Ok(bytes)
}

/// Reads a JSON file.
///
/// # Errors
/// Those of [`read_text`], and JSON that does not parse, with its line and column.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    parse_json(path, &read_text(path, TEXT_LIMIT_BYTES)?)
}

/// Parses the text of the JSON file `path`, whose name is used in messages only.
///
/// # Errors
/// JSON that does not parse, with its line and column.
pub fn parse_json<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T> {
    // A byte order mark, which some editors write but JSON does not allow.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        FileError::new(
            path,
            format!("line {}, column {}", error.line(), error.column()),
            format!(
                "is not valid: {}",
                message.strip_suffix(&place).unwrap_or(&message)
            ),
            "correct the file there",
        )
    })
}

/// Reads a key that is there: null is a value of its own, not a missing key.
pub(crate) fn present<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// Writes `value` as indented JSON with a final newline, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_atomically(path, |out| -> std::io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, value)?;
        out.write_all(b"\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_state_line_and_column_and_values_round_trip() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a.json");
        std::fs::write(&path, "{\n \"a\": 1,\n}").expect("writes");
        let error = read_json::<serde_json::Value>(&path).expect_err("trailing comma");
        assert!(error.to_string().contains("line 3, column 1"), "{error}");
        write_json(&path, &serde_json::json!({"a": [1.5, null]})).expect("writes");
        let back: serde_json::Value = read_json(&path).expect("reads");
        assert_eq!(back["a"][0], 1.5);
    }

    #[test]
    fn long_missing_and_binary_files_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a.json");
        assert!(read_text(&path, 10).is_err());
        std::fs::write(&path, "0123456789").expect("writes");
        assert_eq!(read_text(&path, 10).expect("fits"), "0123456789");
        assert!(read_text(&path, 9).is_err());
        std::fs::write(&path, [b'a', 0xff]).expect("writes");
        let error = read_text(&path, 10).expect_err("not text");
        assert!(error.to_string().contains("byte 1"), "{error}");
    }
}

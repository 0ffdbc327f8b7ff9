//! Corrections to the headers that the `exr` library writes.
//!
//! Attributes are sorted by name, as OpenEXR writes them, so that the same image makes the same file. Attributes
//! that were written under placeholders (`placeholders`) get their real names and types.

use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};

use super::placeholders::restored;

/// Offset of the first header, bytes: after magic number, version and flags.
const FIRST_HEADER: u64 = 8;
/// The flag of files with several parts.
const MULTI_PART: u32 = 1 << 12;

/// An attribute as it is stored.
pub(super) struct RawAttribute {
    pub(super) name: Vec<u8>,
    pub(super) kind: Vec<u8>,
    pub(super) value: Vec<u8>,
}

impl RawAttribute {
    /// Reads an attribute; `None` at the end of a header.
    fn read(read: &mut impl Read) -> io::Result<Option<Self>> {
        let name = read_text(read)?;
        if name.is_empty() {
            return Ok(None);
        }
        let kind = read_text(read)?;
        let mut size = [0; 4];
        read.read_exact(&mut size)?;
        let length = u64::from(u32::from_le_bytes(size));
        let mut value = Vec::new();
        if read.take(length).read_to_end(&mut value)? as u64 != length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(Some(Self { name, kind, value }))
    }

    /// Returns its name and all of its bytes, as they are to be stored.
    fn restored(&self) -> (Vec<u8>, Vec<u8>) {
        let (name, kind) = restored(&self.name, &self.kind);
        let size = (self.value.len() as u32).to_le_bytes();
        let bytes = [name, &[0], kind, &[0], &size, &self.value].concat();
        (name.to_vec(), bytes)
    }
}

/// Reads the attributes of all headers of a file.
///
/// # Errors
/// A file that cannot be read, or that ends within a header.
pub(super) fn read_headers(file: &mut (impl Read + Seek)) -> io::Result<Vec<Vec<RawAttribute>>> {
    let is_multi_part = flags(file)? & MULTI_PART != 0;
    let mut read = BufReader::new(file);
    let mut headers = Vec::new();
    loop {
        let mut attributes = Vec::new();
        while let Some(attribute) = RawAttribute::read(&mut read)? {
            attributes.push(attribute);
        }
        // An empty header ends those of several parts.
        if is_multi_part && attributes.is_empty() {
            return Ok(headers);
        }
        headers.push(attributes);
        if !is_multi_part {
            return Ok(headers);
        }
    }
}

/// Returns the offset of the first byte behind `headers`, which is where the offsets of the blocks are.
pub(super) fn headers_end(headers: &[Vec<RawAttribute>]) -> u64 {
    let size = |own: &RawAttribute| own.name.len() + own.kind.len() + own.value.len() + 6;
    let all = headers
        .iter()
        .map(|own| own.iter().map(size).sum::<usize>() + 1);
    let end = usize::from(headers.len() > 1);
    FIRST_HEADER + (all.sum::<usize>() + end) as u64
}

/// Corrects all headers of a file that was just written.
///
/// # Errors
/// A file that cannot be read and written, or that ends within a header.
pub(super) fn correct_headers(file: &mut (impl Read + Write + Seek)) -> io::Result<()> {
    let headers = read_headers(file)?;
    let is_multi_part = flags(file)? & MULTI_PART != 0;
    let mut sorted = Vec::new();
    for header in headers {
        let mut attributes: Vec<_> = header.iter().map(RawAttribute::restored).collect();
        attributes.sort();
        sorted.extend(attributes.into_iter().flat_map(|(_, bytes)| bytes));
        sorted.push(0);
    }
    if is_multi_part {
        sorted.push(0);
    }
    file.seek(SeekFrom::Start(FIRST_HEADER))?;
    file.write_all(&sorted)?;
    file.seek(SeekFrom::End(0))?;
    Ok(())
}

/// Returns version and flags of a file.
fn flags(file: &mut (impl Read + Seek)) -> io::Result<u32> {
    file.seek(SeekFrom::Start(4))?;
    let mut flags = [0; 4];
    file.read_exact(&mut flags)?;
    Ok(u32::from_le_bytes(flags))
}

/// Reads the bytes up to a zero, without it.
fn read_text(read: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    loop {
        let mut byte = [0];
        read.read_exact(&mut byte)?;
        if byte[0] == 0 {
            return Ok(text);
        }
        text.push(byte[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn attribute(name: &str, value: &[u8]) -> Vec<u8> {
        let size = (value.len() as u32).to_le_bytes();
        [name.as_bytes(), b"\0string\0", &size, value].concat()
    }

    fn sorted(file: Vec<u8>) -> io::Result<Vec<u8>> {
        let mut file = Cursor::new(file);
        correct_headers(&mut file)?;
        Ok(file.into_inner())
    }

    #[test]
    fn attributes_of_every_part_are_sorted_and_pixels_are_unchanged() {
        let (a, b, c) = (
            attribute("a", b"1\0"),
            attribute("b", b""),
            attribute("c", b"33"),
        );
        let start = |flags: u32| [&[0x76, 0x2f, 0x31, 1][..], &(2 | flags).to_le_bytes()].concat();
        let one = [&start(0)[..], &c, &a, &b, &[0], b"pixels"].concat();
        let wanted = [&start(0)[..], &a, &b, &c, &[0], b"pixels"].concat();
        assert_eq!(sorted(one).expect("sound"), wanted);
        let many = [&start(MULTI_PART)[..], &b, &a, &[0], &c, &a, &[0, 0], b"p"].concat();
        let wanted = [&start(MULTI_PART)[..], &a, &b, &[0], &a, &c, &[0, 0], b"p"].concat();
        assert_eq!(sorted(many).expect("sound"), wanted);
        assert!(sorted([&start(0)[..], &a].concat()).is_err());
    }
}

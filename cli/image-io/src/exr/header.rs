//! Headers of EXR files as the format has them, where the library writes them otherwise: attributes by name, as OpenEXR
//! itself has them, so that the same picture makes the same file, and key codes.

use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};

use crate::exr::key_code::unveiled;

/// Bytes before the first header: magic number, version and flags.
const START: u64 = 8;
/// The flag of files with several parts.
const MULTI_PART: u32 = 1 << 12;

/// Puts all headers of a file that was just written right.
///
/// # Errors
/// A file that cannot be read and written, or that ends within a header.
pub(crate) fn put_right(file: &mut (impl Read + Write + Seek)) -> io::Result<()> {
    file.seek(SeekFrom::Start(4))?;
    let mut flags = [0; 4];
    file.read_exact(&mut flags)?;
    let several = u32::from_le_bytes(flags) & MULTI_PART != 0;
    let mut sorted = Vec::new();
    let mut read = BufReader::new(&mut *file);
    loop {
        let mut attributes = Vec::new();
        loop {
            let (name, whole) = attribute(&mut read)?;
            if name.is_empty() {
                break;
            }
            attributes.push((name, whole));
        }
        let last = attributes.is_empty();
        attributes.sort();
        sorted.extend(attributes.into_iter().flat_map(|(_, whole)| whole));
        sorted.push(0);
        if last || !several {
            break;
        }
    }
    drop(read);
    file.seek(SeekFrom::Start(START))?;
    file.write_all(&sorted)?;
    file.seek(SeekFrom::End(0))?;
    Ok(())
}

/// The next attribute: its name, and all of its bytes; an empty name at the end of a header.
fn attribute(read: &mut impl Read) -> io::Result<(Vec<u8>, Vec<u8>)> {
    let name = word(read)?;
    if name.is_empty() {
        return Ok((name, vec![0]));
    }
    let kind = word(read)?;
    let mut size = [0; 4];
    read.read_exact(&mut size)?;
    let length = u64::from(u32::from_le_bytes(size));
    let mut value = Vec::new();
    if read.take(length).read_to_end(&mut value)? as u64 != length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let (name, kind) = unveiled(&name, &kind);
    let whole = [name, &[0], kind, &[0], &size, &value].concat();
    Ok((name.to_vec(), whole))
}

/// The bytes up to a zero, without it.
fn word(read: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut word = Vec::new();
    loop {
        let mut byte = [0];
        read.read_exact(&mut byte)?;
        if byte[0] == 0 {
            return Ok(word);
        }
        word.push(byte[0]);
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
        put_right(&mut file)?;
        Ok(file.into_inner())
    }

    #[test]
    fn attributes_of_every_part_are_sorted_and_pixels_stay() {
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

//! Directories of TIFF files, for DNG. The crate `tiff` opens no file whose first image is a colour filter mosaic.

use std::path::Path;

use crate::error::{FileError, Result};

/// Entries of one directory, and directories of one file, that are read.
const MAX_ENTRIES: usize = 4096;
const MAX_DIRECTORIES: usize = 64;
/// Values of one entry that are read.
const MAX_VALUES: usize = 1 << 20;

/// A TIFF file in memory.
pub(super) struct TiffBytes<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: &'a [u8],
    pub(super) big_endian: bool,
}

/// The entries of a directory: tag and values.
pub(super) struct Directory {
    entries: Vec<(u16, Vec<f64>)>,
}

impl Directory {
    /// Returns the values of `tag`; empty if it is missing.
    pub(super) fn values(&self, tag: u16) -> &[f64] {
        let found = self.entries.iter().find(|(t, _)| *t == tag);
        found.map_or(&[], |(_, values)| values)
    }

    /// Returns the first value of `tag`.
    pub(super) fn value(&self, tag: u16) -> Option<f64> {
        self.values(tag).first().copied()
    }

    /// Returns the text of `tag` without its padding; `None` if it is missing or empty.
    pub(super) fn text(&self, tag: u16) -> Option<String> {
        let bytes = self.values(tag).iter().map(|v| *v as u8);
        let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
        let text = String::from_utf8_lossy(&bytes).trim().to_owned();
        (!text.is_empty()).then_some(text)
    }

    /// Returns the first value of `tag` as a whole number that is not negative, or `other`.
    pub(super) fn whole(&self, tag: u16, other: usize) -> usize {
        self.value(tag).map_or(other, |v| v as usize)
    }
}

impl<'a> TiffBytes<'a> {
    /// Opens a classic TIFF file.
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self {
            path,
            bytes,
            big_endian: bytes.starts_with(b"MM"),
        }
    }

    /// Returns the error of damage.
    pub(super) fn damaged(&self, problem: &str) -> FileError {
        FileError::damaged(self.path, problem)
    }

    /// Returns `length` bytes at `offset`.
    pub(super) fn slice(&self, offset: usize, length: usize) -> Result<&'a [u8]> {
        let end = offset.checked_add(length);
        end.and_then(|end| self.bytes.get(offset..end))
            .ok_or_else(|| self.damaged("an offset lies beyond its end"))
    }

    fn number(&self, offset: usize, length: usize) -> Result<u64> {
        let bytes = self.slice(offset, length)?;
        let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Ok(if self.big_endian {
            bytes.iter().fold(0, join)
        } else {
            bytes.iter().rev().fold(0, join)
        })
    }

    /// Returns every directory: those in the main chain, and the sub-images of each.
    pub(super) fn directories(&self) -> Result<Vec<Directory>> {
        const SUB_IMAGES: u16 = 330;
        let mut found = Vec::new();
        let mut offsets = vec![self.number(4, 4)? as usize];
        let mut seen = Vec::new();
        while let Some(offset) = offsets.pop() {
            if offset == 0 || seen.contains(&offset) || found.len() >= MAX_DIRECTORIES {
                continue;
            }
            seen.push(offset);
            let directory = self.directory(offset)?;
            let count = self.number(offset, 2)? as usize;
            let next = self.number(offset + 2 + 12 * count, 4).unwrap_or(0) as usize;
            offsets.push(next);
            let subs = directory.values(SUB_IMAGES);
            offsets.extend(subs.iter().take(MAX_DIRECTORIES).map(|v| *v as usize));
            found.push(directory);
        }
        Ok(found)
    }

    /// Returns the directory at `offset`.
    pub(super) fn directory(&self, offset: usize) -> Result<Directory> {
        let count = self.number(offset, 2)? as usize;
        if count > MAX_ENTRIES {
            return Err(self.damaged("a directory has too many entries"));
        }
        let mut entries = Vec::new();
        for k in 0..count {
            let at = offset + 2 + 12 * k;
            let tag = self.number(at, 2)? as u16;
            entries.push((tag, self.entry(at)?));
        }
        Ok(Directory { entries })
    }

    /// Returns the values of the entry at `at`, the bytes of a text; empty for unknown types.
    fn entry(&self, at: usize) -> Result<Vec<f64>> {
        let kind = self.number(at + 2, 2)?;
        let count = self.number(at + 4, 4)? as usize;
        let size = match kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 => 8,
            _ => return Ok(Vec::new()),
        };
        if count > MAX_VALUES {
            return Ok(Vec::new());
        }
        let start = if count * size <= 4 {
            at + 8
        } else {
            self.number(at + 8, 4)? as usize
        };
        self.slice(start, count * size)?;
        (0..count)
            .map(|k| {
                let at = start + k * size;
                Ok(match kind {
                    6 => f64::from(self.number(at, 1)? as u8 as i8),
                    8 => f64::from(self.number(at, 2)? as u16 as i16),
                    9 => f64::from(self.number(at, 4)? as u32 as i32),
                    5 => self.number(at, 4)? as f64 / (self.number(at + 4, 4)? as f64),
                    10 => {
                        let part = |at| Ok::<_, FileError>(self.number(at, 4)? as u32 as i32);
                        f64::from(part(at)?) / f64::from(part(at + 4)?)
                    }
                    11 => f64::from(f32::from_bits(self.number(at, 4)? as u32)),
                    12 => f64::from_bits(self.number(at, 8)?),
                    _ => self.number(at, size)? as f64,
                })
            })
            .collect()
    }
}

//! PGM (Netpbm, binary): what `dcraw -D -4` writes.

use std::path::Path;

use super::{PhotographFile, PhotographOptions, SensorPlane, check_size};
use crate::error::{FileError, Result};

/// Reads a binary PGM file.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    options: &PhotographOptions,
) -> Result<PhotographFile> {
    let damaged = |problem: &str| FileError::damaged(path, problem);
    let mut at = 2;
    let mut numbers = [0_usize; 3];
    for number in &mut numbers {
        while let Some(byte) = bytes.get(at) {
            match byte {
                b'#' => at += bytes[at..].iter().take_while(|b| **b != b'\n').count(),
                b if b.is_ascii_whitespace() => at += 1,
                _ => break,
            }
        }
        let digits = bytes[at.min(bytes.len())..]
            .iter()
            .take_while(|b| b.is_ascii_digit());
        let digits: Vec<u8> = digits.take(10).copied().collect();
        let text = std::str::from_utf8(&digits).unwrap_or_default();
        *number = text
            .parse()
            .map_err(|_| damaged("its header is not that of a PGM file"))?;
        at += digits.len();
    }
    // One white-space character ends the header.
    at += 1;
    let [width, height, largest] = numbers;
    check_size(path, width, height, bytes.len())?;
    if !(1..=65535).contains(&largest) {
        return Err(damaged("its largest value is not between 1 and 65535"));
    }
    let size = if largest > 255 { 2 } else { 1 };
    let data = bytes
        .get(at..at + width * height * size)
        .ok_or_else(|| damaged("pixels are missing"))?;
    let samples = if size == 2 {
        let pairs = data.chunks_exact(2);
        pairs
            .map(|p| f32::from(u16::from_be_bytes([p[0], p[1]])))
            .collect()
    } else {
        data.iter().map(|b| f32::from(*b)).collect()
    };
    let plane = SensorPlane {
        width,
        height,
        samples,
        full_scale: largest as f32,
    };
    plane.into_photograph(path, options)
}

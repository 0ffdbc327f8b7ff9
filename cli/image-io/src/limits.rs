//! How much an image file may unpack to, so that a damaged header cannot exhaust the memory.

use std::fs::File;
use std::path::Path;

use crate::error::{FileError, Result};

/// Bounds on the size that an image header may claim.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Largest width and height, pixels.
    pub(crate) side_px: usize,
    /// Bytes of pixels that are always allowed, however small the file.
    pub(crate) free_bytes: u64,
}

/// Opens a file for reading; and its length in bytes, against which its header's claims are held.
pub(crate) fn open(path: &Path) -> Result<(File, u64)> {
    let file = File::open(path).map_err(|e| FileError::io(path, "be opened", &e))?;
    let length = file
        .metadata()
        .map_err(|e| FileError::io(path, "be read", &e))?
        .len();
    Ok((file, length))
}

/// How many times its own length a file may unpack to: over what deflate reaches (1032), so that only
/// a damaged or hostile header is refused.
const MAX_RATIO: u64 = 4096;

impl Limits {
    /// For plates and depth passes.
    pub(crate) const PLATE: Self = Self {
        side_px: 1 << 18,
        free_bytes: 256 << 20,
    };
    /// For the tile of one PSF, which is small.
    pub(crate) const TILE: Self = Self {
        side_px: 1 << 12,
        free_bytes: 256 << 20,
    };

    /// Checks one picture's size; `field` is what the format calls it.
    pub(crate) fn check_sides(
        self,
        path: &Path,
        field: &str,
        width: usize,
        height: usize,
    ) -> Result<()> {
        if width == 0 || height == 0 || width > self.side_px || height > self.side_px {
            return Err(FileError::new(
                path,
                field,
                format!("claims {width} x {height} pixels"),
                format!("a file with 1 to {} pixels a side is needed", self.side_px),
            ));
        }
        Ok(())
    }

    /// Checks the bytes that all pixels of a file of `length` bytes will take.
    pub(crate) fn check_bytes(
        self,
        path: &Path,
        field: &str,
        bytes: u128,
        length: u64,
    ) -> Result<()> {
        let plausible = self.free_bytes.max(length.saturating_mul(MAX_RATIO));
        // Asked for and given back, because a refusal later on would end the process.
        let allocable = usize::try_from(bytes)
            .is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
        if bytes > u128::from(plausible) || !allocable {
            return Err(FileError::new(
                path,
                field,
                format!("claims {bytes} bytes of pixels in a file of {length} bytes"),
                "check the file: it is damaged, or too large for this machine",
            ));
        }
        Ok(())
    }
}

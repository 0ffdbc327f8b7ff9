//! Input files, and bounds on the sizes that their headers may claim.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{FileError, Result};
use crate::format::Format;
use crate::guard::catch_panic;

/// Bounds on the size that an image header may claim, so that a damaged one cannot exhaust the memory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Largest width and height, pixels.
    pub(crate) side_px: usize,
    /// Bytes of pixels that are always allowed, however small the file.
    pub(crate) free_bytes: u64,
}

/// Largest ratio of the unpacked size to the length of a file. Deflate reaches 1032, so only a damaged or hostile header is
/// refused.
const MAX_RATIO: u64 = 4096;

impl Limits {
    /// The limits of plates and depth passes.
    pub(crate) const PLATE: Self = Self {
        side_px: 1 << 18,
        free_bytes: 256 << 20,
    };
    /// The limits of the tile of one PSF, which is small.
    pub(crate) const TILE: Self = Self {
        side_px: 1 << 12,
        free_bytes: 256 << 20,
    };

    /// Checks the size of an image; `field` is its name in the format.
    ///
    /// # Errors
    /// An empty image, and one that is too wide or high.
    pub(crate) fn check_size(
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
                format!(
                    "give a file of 1 to {} pixels in width and height",
                    self.side_px
                ),
            ));
        }
        Ok(())
    }

    /// Checks the bytes that the pixels of a file of `length` bytes take in memory.
    ///
    /// # Errors
    /// More than the file can hold, or than can be allocated.
    pub(crate) fn check_bytes(
        self,
        path: &Path,
        field: &str,
        bytes: u128,
        length: u64,
    ) -> Result<()> {
        let plausible = self.free_bytes.max(length.saturating_mul(MAX_RATIO));
        // A trial allocation: one that fails later would end the process.
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

/// Opens a file for reading.
///
/// # Errors
/// A file that cannot be opened, and a pipe or device: opening a pipe waits for its writer, perhaps for ever, and a device may
/// have no end.
pub(crate) fn open_file(path: &Path) -> Result<File> {
    let unreadable = |e: std::io::Error| FileError::io(path, "be read", &e);
    let kind = std::fs::metadata(path).map_err(unreadable)?.file_type();
    if !(kind.is_file() || kind.is_dir()) {
        return Err(FileError::new(
            path,
            "",
            "is a pipe or a device, not a file",
            "save its content in a file and give that",
        ));
    }
    File::open(path).map_err(unreadable)
}

/// An image file that is open for reading.
pub(crate) struct InputFile<'a> {
    pub(crate) path: &'a Path,
    pub(crate) file: File,
    /// Length of the file, bytes.
    pub(crate) length: u64,
    pub(crate) format: Format,
    limits: Limits,
}

impl<'a> InputFile<'a> {
    /// Opens a file of format `format`.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub(crate) fn open(path: &'a Path, format: Format, limits: Limits) -> Result<Self> {
        let file = open_file(path)?;
        let length = file
            .metadata()
            .map_err(|e| FileError::io(path, "be read", &e))?
            .len();
        Ok(Self {
            path,
            file,
            length,
            format,
            limits,
        })
    }

    /// Runs a decoder. Its panic becomes an error about the file.
    ///
    /// # Errors
    /// Those of the decoder.
    pub(crate) fn guarded<T>(&self, decode: impl FnOnce(&Self) -> Result<T>) -> Result<T> {
        match catch_panic(|| decode(self)) {
            Ok(result) => result,
            Err(panic) => Err(self.damaged(&panic)),
        }
    }

    /// Reads the whole file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn read_all(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        (&self.file)
            .read_to_end(&mut bytes)
            .map_err(|e| FileError::io(self.path, "be read", &e))?;
        Ok(bytes)
    }

    /// Checks the size that the header states in `field`, and that the pixels fit into memory at
    /// `bytes_per_pixel` including all copies that the decoder makes.
    ///
    /// # Errors
    /// Those of [`Limits::check_size`] and [`Limits::check_bytes`].
    pub(crate) fn check_size(
        &self,
        field: &str,
        width: usize,
        height: usize,
        bytes_per_pixel: usize,
    ) -> Result<()> {
        self.limits.check_size(self.path, field, width, height)?;
        let bytes = width as u128 * height as u128 * bytes_per_pixel as u128;
        self.check_bytes(field, bytes)
    }

    /// Checks the bytes that all pixels take in memory.
    ///
    /// # Errors
    /// Those of [`Limits::check_bytes`].
    pub(crate) fn check_bytes(&self, field: &str, bytes: u128) -> Result<()> {
        self.limits
            .check_bytes(self.path, field, bytes, self.length)
    }

    /// Returns the error of a damaged file.
    pub(crate) fn damaged(&self, problem: &str) -> FileError {
        FileError::damaged(self.path, problem)
    }

    /// Returns the error of a file that uses an unsupported `feature` of its format.
    pub(crate) fn unsupported(&self, feature: &str, remedy: &str) -> FileError {
        FileError::new(
            self.path,
            "",
            format!(
                "uses a feature of {} that is not supported ({feature})",
                self.format
            ),
            remedy,
        )
    }
}

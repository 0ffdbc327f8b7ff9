//! Pictures that the program draws itself, written as PNG.

use std::path::Path;

use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

use crate::atomic::write_whole;
use crate::error::{FileError, Result};

/// Writes `picture` as an 8-bit PNG, whole or not at all.
///
/// # Errors
/// A name that does not end in `.png`, and a target that cannot be written.
pub fn write_png(path: &Path, picture: &RgbImage) -> Result<()> {
    let is_png = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if !is_png {
        return Err(FileError::new(
            path,
            "",
            "is not named as a PNG file",
            "give a name that ends in .png",
        ));
    }
    // Enlarged pixels repeat line by line: the filter that takes the line above away halves the file.
    let (effort, filter) = (CompressionType::Default, FilterType::Up);
    write_whole(path, |out| {
        picture.write_with_encoder(PngEncoder::new_with_quality(out, effort, filter))
    })
}

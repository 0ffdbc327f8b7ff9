//! JPEG files, which are read only: 8 bits, grey or RGB.

use std::io::{Cursor, Read};
use std::path::Path;

use image::codecs::jpeg::JpegDecoder;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageError};

use crate::error::{FileError, Result};
use crate::flat_plate::{Container, FlatPlate, SampleDepth, names};
use crate::guard::caught;
use crate::limits::{Limits, open};

/// Reads a JPEG file.
pub(crate) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (mut file, length) = open(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(|e| FileError::io(path, "be read", &e))?;
    check_frame(path, &bytes)?;
    let refuse = |error: ImageError| damaged(path, &error.to_string());
    let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    limits.check_sides(path, "SOF", width, height)?;
    let total = decoder.total_bytes();
    limits.check_bytes(path, "SOF", u128::from(total) * 5, length)?;
    let colour = match decoder.color_type() {
        ColorType::L8 => false,
        ColorType::Rgb8 => true,
        other => return Err(unsupported(path, &format!("{other:?} samples"))),
    };
    let icc = decoder.icc_profile().map_err(refuse)?;
    let exif = decoder.exif_metadata().is_ok_and(|exif| exif.is_some());
    // A camera's note that does not read turns nothing.
    let turned = decoder
        .orientation()
        .is_ok_and(|turn| turn != Orientation::NoTransforms);
    let mut data = vec![0; total as usize];
    decoder.read_image(&mut data).map_err(refuse)?;
    let names = names(colour, false);
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Jpeg { icc, exif, turned },
        depth: SampleDepth::U8,
        width,
        height,
        planes: FlatPlate::planes_of(&data, names.len(), |s| f32::from(s) / 255.0),
        names,
        texts: Vec::new(),
        changed: false,
        notes: Vec::new(),
    })
}

/// Refuses what the decoder would turn into something else without a word: CMYK into RGB, and what is missing of a
/// truncated file into grey.
fn check_frame(path: &Path, bytes: &[u8]) -> Result<()> {
    let truncated = || damaged(path, "it is truncated");
    let mut at = 2;
    loop {
        let Some(&[0xff, marker]) = bytes.get(at..at + 2) else {
            return Err(damaged(path, "a segment does not begin with a marker"));
        };
        at += 2;
        let segment = match marker {
            // Fill before a marker.
            0xff => {
                at -= 1;
                continue;
            }
            // Markers without a segment.
            0x01 | 0xd0..=0xd8 => continue,
            0xd9 => return Err(truncated()),
            _ => bytes.get(at..at + 2).ok_or_else(truncated)?,
        };
        let length = usize::from(u16::from_be_bytes([segment[0], segment[1]]));
        let segment = bytes.get(at + 2..at + length).ok_or_else(truncated)?;
        match (marker, segment) {
            // Tables and reserved markers among those of frames.
            (0xc4 | 0xc8 | 0xcc, _) => {}
            (0xc0..=0xcf, [precision, _, _, _, _, components, ..]) => {
                if *components == 4 {
                    return Err(unsupported(path, "CMYK"));
                }
                if *precision != 8 {
                    return Err(unsupported(path, &format!("{precision} bits a sample")));
                }
            }
            // The scan: what follows is coded, where only an end is an end.
            (0xda, _) => {
                let rest = &bytes[at..];
                let ends = rest.windows(2).any(|pair| pair == [0xff, 0xd9]);
                return if ends { Ok(()) } else { Err(truncated()) };
            }
            _ => {}
        }
        at += length;
    }
}

fn unsupported(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is a JPEG of a kind that is not supported ({what})"),
        "save it as 8-bit RGB or grey, better as TIFF or PNG",
    )
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is no readable JPEG ({what})"),
        "save or copy the file again",
    )
}

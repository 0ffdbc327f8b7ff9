//! PNG files, 8 and 16 bit.

use std::io::BufReader;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError};

use super::atomic::write_whole;
use super::error::{FileError, Result};
use super::flat_plate::{Container, FlatPlate, SampleDepth, names, to_u8, to_u16};
use super::guard::caught;
use super::limits::{Limits, open};

/// Reads a PNG file.
pub(super) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (file, length) = open(path)?;
    let refuse = |error: ImageError| match error {
        ImageError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            FileError::io(path, "be read", &error)
        }
        error => damaged(path, &error.to_string()),
    };
    let mut decoder = PngDecoder::new(BufReader::new(file)).map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    limits.check_sides(path, "IHDR", width, height)?;
    // Beside the bytes of the decoder come the planes, at most four times as large.
    let bytes = decoder.total_bytes();
    limits.check_bytes(path, "IHDR", u128::from(bytes) * 5, length)?;
    let kind = decoder.color_type();
    let icc = decoder.icc_profile().map_err(refuse)?;
    let mut data = vec![0_u8; bytes as usize];
    decoder.read_image(&mut data).map_err(refuse)?;

    let (depth, colour, alpha) = match kind {
        ColorType::L8 => (SampleDepth::U8, false, false),
        ColorType::La8 => (SampleDepth::U8, false, true),
        ColorType::Rgb8 => (SampleDepth::U8, true, false),
        ColorType::Rgba8 => (SampleDepth::U8, true, true),
        ColorType::L16 => (SampleDepth::U16, false, false),
        ColorType::La16 => (SampleDepth::U16, false, true),
        ColorType::Rgb16 => (SampleDepth::U16, true, false),
        ColorType::Rgba16 => (SampleDepth::U16, true, true),
        other => {
            return Err(FileError::new(
                path,
                "",
                format!("stores {other:?} samples, which PNG should not"),
                "save it as 8- or 16-bit PNG",
            ));
        }
    };
    let names = names(colour, alpha);
    let planes = match depth {
        SampleDepth::U8 => FlatPlate::planes_of(&data, names.len(), |s| f32::from(s) / 255.0),
        _ => {
            let samples: Vec<u16> = data
                .chunks_exact(2)
                .map(|pair| u16::from_ne_bytes([pair[0], pair[1]]))
                .collect();
            FlatPlate::planes_of(&samples, names.len(), |s| f32::from(s) / 65535.0)
        }
    };
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Png { icc },
        depth,
        width,
        height,
        names,
        planes,
    })
}

/// Writes a PNG file whole or not at all.
pub(super) fn write(path: &Path, plate: &FlatPlate, icc: Option<&[u8]>) -> Result<()> {
    let (width, height) = (plate.width as u32, plate.height as u32);
    let (data, kind) = if plate.depth == SampleDepth::U8 {
        let kind = match plate.planes.len() {
            1 => ExtendedColorType::L8,
            2 => ExtendedColorType::La8,
            3 => ExtendedColorType::Rgb8,
            _ => ExtendedColorType::Rgba8,
        };
        (plate.interleaved(to_u8), kind)
    } else {
        let kind = match plate.planes.len() {
            1 => ExtendedColorType::L16,
            2 => ExtendedColorType::La16,
            3 => ExtendedColorType::Rgb16,
            _ => ExtendedColorType::Rgba16,
        };
        let samples = plate.interleaved(|code| to_u16(code).to_ne_bytes());
        (samples.concat(), kind)
    };
    write_whole(path, |out| {
        let mut encoder =
            PngEncoder::new_with_quality(out, CompressionType::Default, FilterType::Adaptive);
        if let Some(icc) = icc {
            encoder
                .set_icc_profile(icc.to_vec())
                .map_err(|e| e.to_string())?;
        }
        encoder
            .write_image(&data, width, height, kind)
            .map_err(|e| e.to_string())
    })
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is no readable PNG ({what})"),
        "save or copy the file again",
    )
}

//! PNG files, 8 and 16 bit.

use std::borrow::Cow;
use std::io::BufReader;
use std::path::Path;

use png::text_metadata::{ITXtChunk, TEXtChunk, ZTXtChunk};
use png::{
    BitDepth, ColorType, Decoder, DecodingError, Encoder, EncodingError, Info, Transformations,
};

use super::atomic::write_whole;
use super::error::{FileError, Result};
use super::flat_plate::{Container, FlatPlate, SampleDepth, names, to_u8, to_u16};
use super::guard::caught;
use super::limits::{Limits, open};
use super::provenance::Texts;

/// Most bytes that a packed text may unpack to.
const TEXT_LIMIT: usize = 16 << 20;

/// Reads a PNG file.
pub(super) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (file, length) = open(path)?;
    let refuse = |error: DecodingError| match error {
        DecodingError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            FileError::io(path, "be read", &error)
        }
        error => damaged(path, &error.to_string()),
    };
    let mut decoder = Decoder::new(BufReader::new(file));
    // Palettes and fewer bits than eight become what is used here.
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(refuse)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    limits.check_sides(path, "IHDR", width, height)?;
    let (kind, bits) = reader.output_color_type();
    let (colour, alpha) = match kind {
        ColorType::Grayscale => (false, false),
        ColorType::GrayscaleAlpha => (false, true),
        ColorType::Rgb | ColorType::Indexed => (true, false),
        ColorType::Rgba => (true, true),
    };
    let names = names(colour, alpha);
    let depth = match bits {
        BitDepth::Sixteen => SampleDepth::U16,
        _ => SampleDepth::U8,
    };
    // Beside the bytes of the decoder come the planes, at most four times as large.
    let sample_bytes = if depth == SampleDepth::U16 { 2 } else { 1 };
    let bytes = width as u128 * height as u128 * (names.len() * sample_bytes) as u128;
    limits.check_bytes(path, "IHDR", bytes * 5, length)?;
    let Some(size) = reader.output_buffer_size() else {
        return Err(damaged(path, "it is too large"));
    };
    let mut data = vec![0_u8; size];
    reader.next_frame(&mut data).map_err(refuse)?;
    // Texts may stand after the picture; what is wrong there is no part of it.
    let _ = reader.finish();
    let info = reader.info();
    let planes = match depth {
        SampleDepth::U8 => FlatPlate::planes_of(&data, names.len(), |s| f32::from(s) / 255.0),
        _ => {
            let samples: Vec<u16> = data
                .chunks_exact(2)
                .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
                .collect();
            FlatPlate::planes_of(&samples, names.len(), |s| f32::from(s) / 65535.0)
        }
    };
    if planes.iter().any(|plane| plane.len() != width * height) {
        return Err(damaged(path, "pixels are missing"));
    }
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Png {
            icc: info.icc_profile.as_ref().map(|icc| icc.to_vec()),
        },
        depth,
        width,
        height,
        names,
        planes,
        texts: texts(info),
    })
}

/// All texts, those that do not unpack left out: they are no part of the picture.
fn texts(info: &Info) -> Texts {
    let plain = info.uncompressed_latin1_text.iter();
    let plain = plain.map(|TEXtChunk { keyword, text }| (keyword.clone(), text.clone()));
    let packed = info.compressed_latin1_text.iter();
    let packed = packed.filter_map(|chunk: &ZTXtChunk| {
        let mut chunk = chunk.clone();
        chunk.decompress_text_with_limit(TEXT_LIMIT).ok()?;
        Some((chunk.keyword.clone(), chunk.get_text().ok()?))
    });
    let wide = info.utf8_text.iter();
    let wide = wide.filter_map(|chunk: &ITXtChunk| {
        let mut chunk = chunk.clone();
        chunk.decompress_text_with_limit(TEXT_LIMIT).ok()?;
        Some((chunk.keyword.clone(), chunk.get_text().ok()?))
    });
    plain.chain(packed).chain(wide).collect()
}

/// Writes a PNG file whole or not at all.
pub(super) fn write(path: &Path, plate: &FlatPlate, icc: Option<&[u8]>) -> Result<()> {
    let mut info = Info::with_size(plate.width as u32, plate.height as u32);
    info.color_type = match plate.planes.len() {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    };
    info.icc_profile = icc.map(Cow::Borrowed);
    let data = if plate.depth == SampleDepth::U8 {
        info.bit_depth = BitDepth::Eight;
        plate.interleaved(to_u8)
    } else {
        info.bit_depth = BitDepth::Sixteen;
        plate
            .interleaved(|code| to_u16(code).to_be_bytes())
            .concat()
    };
    write_whole(path, |out| {
        let packed = || -> std::result::Result<(), EncodingError> {
            let mut encoder = Encoder::with_info(out, info)?;
            for (name, text) in &plate.texts {
                // A name may be Latin-1 of at most 79 letters, and a text may hold no zero.
                let name = name.chars().filter(|c| (' '..='~').contains(c)).take(79);
                encoder.add_itxt_chunk(name.collect(), text.replace('\0', ""))?;
            }
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&data)?;
            writer.finish()
        };
        packed().map_err(|e| e.to_string())
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

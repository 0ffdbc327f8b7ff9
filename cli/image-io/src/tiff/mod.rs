//! TIFF files read: 8 and 16 bit, half and float, one page.

pub(crate) mod tags;
pub(crate) mod write;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::{ExtraSamples, Tag};
use tiff::{ColorType, TiffError};

use crate::error::{FileError, Result};
use crate::flat_plate::{Container, FlatPlate, SampleDepth, names};
use crate::guard::caught;
use crate::limits::{Limits, open};
use crate::provenance::{Texts, is_ours};
use crate::tiff::tags::{Carried, IMAGE_HISTORY};

/// Reads the first page of a TIFF file.
pub(crate) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (file, length) = open(path)?;
    let refuse = |error: TiffError| refusal(path, error);
    let unsupported = |what: String| {
        FileError::new(
            path,
            "",
            format!("is a TIFF of a kind that is not supported ({what})"),
            "save it as grey or RGB, 8-bit, 16-bit or float, one page",
        )
    };
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(refuse)?;
    let (width, height) = decoder.dimensions().map_err(refuse)?;
    let (width, height) = (width as usize, height as usize);
    limits.check_sides(path, "ImageWidth, ImageLength", width, height)?;
    let kind = decoder.colortype().map_err(refuse)?;
    let stored = decoder
        .find_tag_unsigned::<u16>(Tag::SamplesPerPixel)
        .map_err(refuse)?
        .unwrap_or(1);
    let extra: Vec<u16> = decoder
        .find_tag_unsigned_vec(Tag::ExtraSamples)
        .map_err(refuse)?
        .unwrap_or_default();
    let (colour, alpha) = match kind {
        ColorType::Gray(_) => (false, false),
        // Grey with alpha comes under this name.
        ColorType::Multiband { num_samples: 2, .. } if matches!(extra[..], [1 | 2]) => {
            (false, true)
        }
        ColorType::RGB(_) => (true, false),
        ColorType::RGBA(_) => (true, true),
        other => return Err(unsupported(format!("{other:?}"))),
    };
    let names = names(colour, alpha);
    if usize::from(stored) != names.len() {
        return Err(unsupported(format!(
            "{stored} samples a pixel where {} are used",
            names.join(", ")
        )));
    }
    let sample_bytes = u128::from(kind.bit_depth().div_ceil(8));
    let bytes = width as u128 * height as u128 * names.len() as u128 * sample_bytes;
    limits.check_bytes(path, "ImageWidth, ImageLength", bytes * 5, length)?;
    let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);

    let mut room = tiff::decoder::Limits::default();
    room.decoding_buffer_size = bytes;
    room.intermediate_buffer_size = bytes.max(1 << 20).saturating_mul(4);
    room.ifd_value_size = 64 << 20;
    let mut decoder = decoder.with_limits(room);
    let alpha = extra.first().and_then(|&v| ExtraSamples::from_u16(v));
    let carried = Carried::read(&mut decoder, alpha);
    let mut data = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut data).map_err(refuse)?;
    let planar = layout.planes > 1;
    let count = names.len();
    let (planes, depth) = match &data {
        // Grey of fewer bits than eight would come packed.
        DecodingResult::U8(d) if kind.bit_depth() == 8 => (
            planes(d, count, planar, |s| f32::from(s) / 255.0),
            SampleDepth::U8,
        ),
        DecodingResult::U16(d) if kind.bit_depth() == 16 => (
            planes(d, count, planar, |s| f32::from(s) / 65535.0),
            SampleDepth::U16,
        ),
        DecodingResult::F16(d) => (planes(d, count, planar, |s| s.to_f32()), SampleDepth::F16),
        DecodingResult::F32(d) => (planes(d, count, planar, |s| s), SampleDepth::F32),
        _ => {
            return Err(unsupported(format!("{} bits a sample", kind.bit_depth())));
        }
    };
    if planes.len() != count || planes.iter().any(|p| p.len() != width * height) {
        return Err(damaged(path, "pixels are missing"));
    }
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Tiff(carried),
        depth,
        width,
        height,
        names,
        planes,
        texts: history(&mut decoder),
        changed: false,
        notes: Vec::new(),
    })
}

fn planes<T: Copy>(
    data: &[T],
    count: usize,
    planar: bool,
    convert: impl Fn(T) -> f32,
) -> Vec<Vec<f32>> {
    if planar {
        data.chunks(data.len().div_ceil(count).max(1))
            .map(|plane| plane.iter().map(|&s| convert(s)).collect())
            .collect()
    } else {
        FlatPlate::planes_of(data, count, convert)
    }
}

/// The texts of ImageHistory; what it holds otherwise is one text.
fn history(decoder: &mut Decoder<BufReader<File>>) -> Texts {
    let found = decoder.find_tag(IMAGE_HISTORY);
    let Some(text) = found
        .ok()
        .flatten()
        .and_then(|value| value.into_string().ok())
    else {
        return Texts::new();
    };
    let mut texts = Texts::new();
    for line in text.lines() {
        match (
            line.strip_prefix("  "),
            line.split_once(": "),
            texts.last_mut(),
        ) {
            (Some(more), _, Some((_, text))) => {
                text.push('\n');
                text.push_str(more);
            }
            (None, Some((name, text)), _) if is_ours(name) => {
                texts.push((name.to_owned(), text.to_owned()));
            }
            _ => return vec![("ImageHistory".to_owned(), text)],
        }
    }
    texts
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is no readable TIFF ({what})"),
        "save or copy the file again",
    )
}

fn refusal(path: &Path, error: TiffError) -> FileError {
    match error {
        TiffError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            FileError::io(path, "be read", &error)
        }
        TiffError::UnsupportedError(what) => FileError::new(
            path,
            "",
            format!("is a TIFF of a kind that is not supported ({what})"),
            "save it as grey or RGB, 8-bit, 16-bit or float, one page",
        ),
        error => damaged(path, &error.to_string()),
    }
}

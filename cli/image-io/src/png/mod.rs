//! PNG files, 8 and 16 bit.

mod chunks;

use std::borrow::Cow;
use std::io::{BufReader, Seek, Write};
use std::path::Path;

use png::chunk::ChunkType;
use png::text_metadata::{ITXtChunk, TEXtChunk, ZTXtChunk};
use png::{
    BitDepth, ColorType, Decoder, DecodingError, Encoder, EncodingError, Info, Transformations,
    Writer,
};

use self::chunks::{Chunk, PROFILE};
use crate::atomic::write_whole;
use crate::error::{FileError, Result};
use crate::flat_plate::{Container, FlatPlate, SampleDepth, names, to_u8, to_u16};
use crate::guard::caught;
use crate::limits::{Limits, open};

/// Most bytes that a packed text may unpack to.
const TEXT_LIMIT: usize = 16 << 20;

/// What a PNG file holds beside its pixels and is written back.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Carried {
    /// The colour profile, unpacked.
    icc: Option<Vec<u8>>,
    chunks: Vec<Chunk>,
    texts: Vec<TextChunk>,
    /// Whether pixels are written as they were stored: not so of palettes and fewer bits than eight.
    as_read: bool,
    /// Whether there are further pictures, which are not carried over.
    pub(crate) animated: bool,
}

/// A text as it lies in a file, with its name and unpacked.
#[derive(Debug, Clone, PartialEq)]
struct TextChunk {
    named: (String, String),
    chunk: AnyText,
}

#[derive(Debug, Clone, PartialEq)]
enum AnyText {
    Plain(TEXtChunk),
    Packed(ZTXtChunk),
    Wide(ITXtChunk),
}

impl Carried {
    /// What a new file holds beside its pixels.
    pub(crate) fn new(icc: Option<Vec<u8>>) -> Self {
        Self {
            icc,
            ..Self::default()
        }
    }

    /// The colour profile.
    pub(crate) fn icc(&self) -> Option<Vec<u8>> {
        self.icc.clone()
    }

    /// Names of the chunks, but for the colour profile.
    pub(crate) fn names(&self) -> Vec<String> {
        let others = self.chunks.iter().filter(|chunk| chunk.name() != PROFILE);
        others.map(Chunk::in_letters).collect()
    }

    /// Names of the chunks that do not hold for a picture of which samples have `changed` or not.
    pub(crate) fn left_out(&self, changed: bool) -> Vec<String> {
        let gone = |chunk: &&Chunk| !chunk.holds(changed, self.as_read);
        self.chunks
            .iter()
            .filter(gone)
            .map(Chunk::in_letters)
            .collect()
    }

    /// The chunk that says that codes are proportional to light, where one does: cICP, which goes before gAMA.
    pub(crate) fn says_linear(&self) -> Option<&'static str> {
        let data = |name: &[u8; 4]| {
            let own = self.chunks.iter().find(|chunk| chunk.name() == *name);
            own.map(Chunk::data)
        };
        match (data(b"cICP"), data(b"gAMA")) {
            // Transfer characteristic 8 of ITU-T H.273.
            (Some([_, 8, ..]), _) => Some("cICP"),
            // One, in hundred-thousandths.
            (None, Some([0, 1, 0x86, 0xa0])) if data(b"sRGB").is_none() => Some("gAMA"),
            _ => None,
        }
    }

    /// Takes away what says of what colour space codes are; the names of that.
    pub(crate) fn drop_colour(&mut self) -> Vec<String> {
        let colour = self.chunks.iter().filter(|chunk| chunk.is_colour());
        let names = colour.map(Chunk::in_letters).collect();
        self.chunks.retain(|chunk| !chunk.is_colour());
        self.icc = None;
        names
    }
}

/// Reads a PNG file.
pub(crate) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    caught(|| read_unguarded(path, limits)).unwrap_or_else(|panic| Err(damaged(path, &panic)))
}

fn read_unguarded(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (mut file, length) = open(path)?;
    let (chunks, animated) = chunks::read(&mut BufReader::new(&file), length);
    file.rewind()
        .map_err(|e| FileError::io(path, "be read", &e))?;
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
    let texts = texts(info);
    let named = texts.iter().map(|text| text.named.clone()).collect();
    let carried = Carried {
        icc: info.icc_profile.as_ref().map(|icc| icc.to_vec()),
        chunks,
        texts,
        as_read: (info.color_type, info.bit_depth) == (kind, bits),
        animated,
    };
    Ok(FlatPlate {
        path: path.to_path_buf(),
        container: Container::Png(Box::new(carried)),
        depth,
        width,
        height,
        names,
        planes,
        texts: named,
        changed: false,
        notes: Vec::new(),
    })
}

/// All texts, those that do not unpack left out: they are no part of the picture.
fn texts(info: &Info) -> Vec<TextChunk> {
    let plain = info.uncompressed_latin1_text.iter().map(|chunk| TextChunk {
        named: (chunk.keyword.clone(), chunk.text.clone()),
        chunk: AnyText::Plain(chunk.clone()),
    });
    let packed = info.compressed_latin1_text.iter().filter_map(|chunk| {
        let mut open = chunk.clone();
        open.decompress_text_with_limit(TEXT_LIMIT).ok()?;
        Some(TextChunk {
            named: (open.keyword.clone(), open.get_text().ok()?),
            chunk: AnyText::Packed(chunk.clone()),
        })
    });
    let wide = info.utf8_text.iter().filter_map(|chunk| {
        let mut open = chunk.clone();
        open.decompress_text_with_limit(TEXT_LIMIT).ok()?;
        Some(TextChunk {
            named: (open.keyword.clone(), open.get_text().ok()?),
            chunk: AnyText::Wide(chunk.clone()),
        })
    });
    plain.chain(packed).chain(wide).collect()
}

/// Writes a PNG file whole or not at all.
pub(crate) fn write(path: &Path, plate: &FlatPlate, carried: &Carried) -> Result<()> {
    let mut info = Info::with_size(plate.width as u32, plate.height as u32);
    info.color_type = match plate.planes.len() {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    };
    let (behind, before): (Vec<&Chunk>, Vec<&Chunk>) = (carried.chunks.iter())
        .filter(|chunk| chunk.holds(plate.changed, carried.as_read))
        .partition(|chunk| chunk.is_behind());
    // As it lay in the file, under its own name, where it came from one.
    if !before.iter().any(|chunk| chunk.name() == PROFILE) {
        info.icc_profile = carried.icc.as_deref().map(Cow::Borrowed);
    }
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
            let mut writer = Encoder::with_info(out, info)?.write_header()?;
            for chunk in before {
                writer.write_chunk(ChunkType(chunk.name()), chunk.data())?;
            }
            for named in &plate.texts {
                write_text(&mut writer, named, carried)?;
            }
            writer.write_image_data(&data)?;
            for chunk in behind {
                writer.write_chunk(ChunkType(chunk.name()), chunk.data())?;
            }
            writer.finish()
        };
        packed().map_err(|e| e.to_string())
    })
}

/// Writes a text as it lay in the file that it came from, else as UTF-8.
fn write_text<W: Write>(
    writer: &mut Writer<W>,
    named: &(String, String),
    carried: &Carried,
) -> std::result::Result<(), EncodingError> {
    let own = carried.texts.iter().find(|text| text.named == *named);
    match own.map(|text| &text.chunk) {
        Some(AnyText::Plain(chunk)) => writer.write_text_chunk(chunk),
        Some(AnyText::Packed(chunk)) => writer.write_text_chunk(chunk),
        Some(AnyText::Wide(chunk)) => writer.write_text_chunk(chunk),
        None => {
            // A name may be Latin-1 of at most 79 letters, and a text may hold no zero.
            let (name, text) = named;
            let name = name.chars().filter(|c| (' '..='~').contains(c)).take(79);
            let chunk = ITXtChunk::new(name.collect::<String>(), text.replace('\0', ""));
            writer.write_text_chunk(&chunk)
        }
    }
}

fn damaged(path: &Path, what: &str) -> FileError {
    FileError::new(
        path,
        "",
        format!("is no readable PNG ({what})"),
        "save or copy the file again",
    )
}

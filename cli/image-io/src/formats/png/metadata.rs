//! The metadata of a PNG file: ancillary chunks, texts and the ICC profile.

use std::io::Write;
use std::path::Path;

use png::text_metadata::{ITXtChunk, TEXtChunk, ZTXtChunk};
use png::{EncodingError, Info, Writer};

use super::chunks::{AncillaryChunks, Changes, Chunk, ICC_PROFILE};
use super::transfer::{self, StatedTransfer};
use crate::error::Result;
use crate::metadata::TextAttributes;
use crate::raster::{AssumedEncoding, Metadata, RasterImage};
use crate::samples::Encoding;

/// Limit of the length of a decompressed text, bytes.
const TEXT_LIMIT: usize = 16 << 20;

/// The metadata of a PNG file.
#[derive(Debug, Clone, Default)]
pub(super) struct PngMetadata {
    /// The ICC profile, decompressed.
    icc_profile: Option<Vec<u8>>,
    chunks: Vec<Chunk>,
    texts: Vec<Text>,
    /// Whether the file stored a palette or fewer than eight bits, which are written as eight bits.
    is_expanded: bool,
    is_animated: bool,
}

/// A text with the chunk that it was stored in.
#[derive(Debug, Clone)]
struct Text {
    name: String,
    text: String,
    chunk: TextChunk,
}

#[derive(Debug, Clone)]
enum TextChunk {
    Plain(TEXtChunk),
    Compressed(ZTXtChunk),
    Utf8(ITXtChunk),
}

impl PngMetadata {
    /// Creates the metadata of a new file.
    pub(super) fn new(icc_profile: Option<Vec<u8>>) -> Self {
        Self {
            icc_profile,
            ..Self::default()
        }
    }

    /// Collects the metadata of a file.
    pub(super) fn read(info: &Info, ancillary: AncillaryChunks) -> Self {
        Self {
            icc_profile: info.icc_profile.as_ref().map(|icc| icc.to_vec()),
            chunks: ancillary.chunks,
            texts: texts(info),
            is_expanded: false,
            is_animated: ancillary.is_animated,
        }
    }

    /// Returns the same metadata; `is_expanded` if the file stored a palette or fewer than eight bits.
    pub(super) fn with_expansion(self, is_expanded: bool) -> Self {
        Self {
            is_expanded,
            ..self
        }
    }

    /// Returns the texts, each with its name.
    pub(super) fn texts(&self) -> TextAttributes {
        let texts = self.texts.iter();
        texts
            .map(|text| (text.name.clone(), text.text.clone()))
            .collect()
    }

    /// Returns the ICC profile unless a chunk of the file has it, which is written as it was.
    pub(super) fn new_icc_profile(&self) -> Option<&[u8]> {
        let has_chunk = self.chunks.iter().any(|chunk| chunk.name() == ICC_PROFILE);
        self.icc_profile.as_deref().filter(|_| !has_chunk)
    }

    /// Returns the chunks that are still valid in a new file of `image`.
    pub(super) fn valid_chunks(&self, image: &RasterImage) -> impl Iterator<Item = &Chunk> {
        let changes = self.changes(image);
        let chunks = self.chunks.iter();
        chunks.filter(move |chunk| chunk.is_valid(changes))
    }

    /// Returns the differences of `image` to the file that was read.
    fn changes(&self, image: &RasterImage) -> Changes {
        Changes {
            samples: image.changed,
            expanded: self.is_expanded,
        }
    }

    /// Writes a text in the chunk that it was read from, else as UTF-8.
    pub(super) fn write_text<W: Write>(
        &self,
        writer: &mut Writer<W>,
        name: &str,
        text: &str,
    ) -> std::result::Result<(), EncodingError> {
        let is_same = |own: &&Text| own.name == name && own.text == text;
        match self.texts.iter().find(is_same).map(|own| &own.chunk) {
            Some(TextChunk::Plain(chunk)) => writer.write_text_chunk(chunk),
            Some(TextChunk::Compressed(chunk)) => writer.write_text_chunk(chunk),
            Some(TextChunk::Utf8(chunk)) => writer.write_text_chunk(chunk),
            None => {
                // Keywords are Latin-1 of at most 79 characters, and texts must not contain NUL.
                let keyword = name.chars().filter(|c| (' '..='~').contains(c)).take(79);
                let chunk = ITXtChunk::new(keyword.collect::<String>(), text.replace('\0', ""));
                writer.write_text_chunk(&chunk)
            }
        }
    }

    /// Returns the names of all chunks but the ICC profile.
    fn chunk_names(&self) -> Vec<String> {
        let others = self.chunks.iter().filter(|c| c.name() != ICC_PROFILE);
        others.map(Chunk::name_text).collect()
    }

    fn stated_transfer(&self) -> Option<StatedTransfer> {
        transfer::stated(&self.chunks, self.icc_profile.as_deref())
    }
}

impl Metadata for PngMetadata {
    fn write(&self, path: &Path, image: &RasterImage) -> Result<()> {
        super::write(path, image, self)
    }

    fn is_premultiplied(&self) -> bool {
        false
    }

    fn icc_profile(&self) -> Option<&[u8]> {
        self.icc_profile.as_deref()
    }

    fn remove_colour_space(&mut self) -> Vec<String> {
        let removed = self.chunks.iter().filter(|chunk| chunk.is_colour_space());
        let names = removed.map(Chunk::name_text).collect();
        self.chunks.retain(|chunk| !chunk.is_colour_space());
        self.icc_profile = None;
        names
    }

    fn summary(&self) -> TextAttributes {
        match self.chunk_names() {
            names if names.is_empty() => TextAttributes::new(),
            names => vec![("chunks".to_owned(), names.join(", "))],
        }
    }

    fn encoding(&self) -> Option<Encoding> {
        self.stated_transfer()?.encoding
    }

    fn read_warning(&self, assumed: AssumedEncoding) -> Option<String> {
        let used = assumed.encoding?;
        let StatedTransfer { chunk, encoding } = self.stated_transfer()?;
        match encoding {
            Some(stated) if stated == used && stated == Encoding::Srgb => None,
            Some(stated) if stated == used => {
                let white = match stated {
                    Encoding::Pq => "; 1.0 is 203 cd/m2",
                    Encoding::Hlg => "; 1.0 is the light of the code 0.75",
                    _ => "",
                };
                Some(format!(
                    "samples are {stated}, as the PNG states ({chunk}){white}"
                ))
            }
            Some(stated) => Some(format!(
                "the PNG states {stated} samples ({chunk}), but they are read as {used}, as --encoding says"
            )),
            None if assumed.from_user => None,
            None => Some(format!(
                "the PNG states a transfer function that is not known ({chunk}): samples are read as {used}; give --encoding, or convert the file"
            )),
        }
    }

    fn rewrite_losses(&self, image: &RasterImage) -> Vec<String> {
        let is_lost = |chunk: &&Chunk| !chunk.is_valid(self.changes(image));
        let lost: Vec<String> = (self.chunks.iter().filter(is_lost))
            .map(Chunk::name_text)
            .collect();
        if lost.is_empty() {
            return Vec::new();
        }
        vec![format!(
            "chunks that are not valid in the new file are left out: {}",
            lost.join(", ")
        )]
    }

    fn conversion_loss(&self, _kept: &[&str]) -> Option<String> {
        match self.chunk_names() {
            names if names.is_empty() => None,
            names => Some(format!("{} of the PNG", names.join(", "))),
        }
    }

    fn multiple_images(&self) -> Option<&'static str> {
        self.is_animated.then_some("frame of the animated PNG")
    }
}

/// Returns all texts. Those that cannot be decompressed are left out, as they do not affect the image.
fn texts(info: &Info) -> Vec<Text> {
    let plain = info.uncompressed_latin1_text.iter().map(|chunk| Text {
        name: chunk.keyword.clone(),
        text: chunk.text.clone(),
        chunk: TextChunk::Plain(chunk.clone()),
    });
    let compressed = info.compressed_latin1_text.iter().filter_map(|chunk| {
        let mut open = chunk.clone();
        open.decompress_text_with_limit(TEXT_LIMIT).ok()?;
        Some(Text {
            name: open.keyword.clone(),
            text: open.get_text().ok()?,
            chunk: TextChunk::Compressed(chunk.clone()),
        })
    });
    let utf8 = info.utf8_text.iter().filter_map(|chunk| {
        let mut open = chunk.clone();
        open.decompress_text_with_limit(TEXT_LIMIT).ok()?;
        Some(Text {
            name: open.keyword.clone(),
            text: open.get_text().ok()?,
            chunk: TextChunk::Utf8(chunk.clone()),
        })
    });
    plain.chain(compressed).chain(utf8).collect()
}

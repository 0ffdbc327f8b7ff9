//! DPX files (SMPTE 268M-2003): 8, 10, 12 and 16 bits, both byte orders, one image element.

mod facts;
mod header;
mod samples;
mod user_data;

use std::io::{Read, Write};
use std::path::Path;

use crate::atomic::write_whole;
use crate::error::{FileError, Result};
use crate::facts::Facts;
use crate::flat_plate::{Container, Encoding, FlatPlate, SampleDepth, names, to_integer};
use crate::limits::{Limits, open};
use crate::provenance::Texts;
use header::{Header, NewHeader, made, parse, set_file_size};
use samples::{Justified, Layout, Packing};

/// What a DPX file holds beside its pixels, all of which is written back, and how pixels lie in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Carried {
    /// All bytes before the pixels: the header and user data.
    lead: Vec<u8>,
    /// All bytes after the pixels.
    tail: Vec<u8>,
    header: Header,
    /// Bytes from the start of a line to that of the next.
    stride: usize,
}

impl Carried {
    /// What codes mean by what the file says.
    pub(crate) fn encoding(&self) -> Encoding {
        self.header.encoding()
    }

    /// The transfer characteristic that the header names.
    pub(crate) fn transfer_name(&self) -> String {
        self.header.transfer_name()
    }

    /// Whether others have something where our texts would stand.
    pub(crate) fn has_no_room(&self) -> bool {
        user_data::is_taken(&self.lead, self.header.layout.big_endian)
    }

    /// Width of a pixel over its height.
    pub(crate) fn pixel_aspect(&self) -> f64 {
        self.header.pixel_aspect
    }

    /// What the header says of the picture beside its pixels.
    pub(crate) fn facts(&self) -> Facts {
        facts::facts(&self.lead, self.header.layout.big_endian)
    }

    /// Has the header say what is known of the picture; the names, as EXR has them, of what it has no room for.
    pub(crate) fn put_facts(&mut self, facts: &Facts) -> Vec<&'static str> {
        let big_endian = self.header.layout.big_endian;
        facts::put_facts(&mut self.lead, big_endian, facts)
    }

    /// Takes away what the header says of codes as colour; the names of that.
    pub(crate) fn drop_colour(&mut self) -> Vec<String> {
        self.header.transfer = 0;
        self.header.is_srgb = false;
        header::drop_colour(&mut self.lead)
    }

    /// The texts of the header, each with its name.
    pub(crate) fn texts(&self) -> Texts {
        facts::texts(&self.lead)
    }

    /// What a new file holds beside the pixels. `encoding` is what codes mean, `None` where that is not known.
    pub(crate) fn new(
        (width, height): (usize, usize),
        components: usize,
        depth: SampleDepth,
        encoding: Option<Encoding>,
        pixel_aspect: f64,
    ) -> Self {
        let layout = Layout {
            width,
            components,
            reversed: false,
            packing: match depth {
                SampleDepth::U8 => Packing::Bits8,
                SampleDepth::U12 => Packing::Bits12(Justified::High),
                SampleDepth::U16 => Packing::Bits16,
                _ => Packing::Bits10(Justified::High),
            },
            big_endian: true,
        };
        let stride = aligned(layout.line_bytes());
        // Said as padding too, for readers that do not know of the alignment.
        let line_padding = stride - layout.line_bytes();
        let lead = made(&NewHeader {
            height,
            layout,
            line_padding,
            encoding,
            pixel_aspect,
        });
        Self {
            header: Header {
                offset: lead.len(),
                height,
                layout,
                line_padding,
                transfer: 0,
                is_srgb: encoding == Some(Encoding::Srgb),
                pixel_aspect,
            },
            lead,
            tail: Vec::new(),
            stride,
        }
    }
}

/// The next multiple of four: lines begin at 32-bit words.
fn aligned(bytes: usize) -> usize {
    bytes.next_multiple_of(4)
}

/// Reads a DPX file.
pub(crate) fn read(path: &Path, limits: Limits) -> Result<FlatPlate> {
    let (mut file, length) = open(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(|e| FileError::io(path, "be read", &e))?;
    let header = parse(path, &bytes)?;
    let Header { layout, height, .. } = header;
    limits.check_sides(path, "pixels per line, lines", layout.width, height)?;
    // Codes of a line, and the planes.
    let room = layout.samples() as u128 * height as u128 * 5;
    limits.check_bytes(path, "pixels per line, lines", room, length)?;
    let stride = stride(path, &header, bytes.len())?;

    let names = names(layout.components > 1, layout.components == 4);
    let full_scale = f32::from(layout.packing.full_scale());
    let mut planes = vec![vec![0.0; layout.width * height]; names.len()];
    let mut codes = vec![0; layout.samples()];
    for y in 0..height {
        let start = header.offset + y * stride;
        layout.unpack(&bytes[start..start + layout.line_bytes()], &mut codes);
        for (at, plane) in planes.iter_mut().enumerate() {
            let at = component(&layout, at);
            let row = &mut plane[y * layout.width..][..layout.width];
            let own = codes.iter().skip(at).step_by(layout.components);
            for (sample, &code) in row.iter_mut().zip(own) {
                *sample = f32::from(code) / full_scale;
            }
        }
    }
    let end = bytes.len().min(header.offset + stride * height);
    let carried = Carried {
        tail: bytes[end..].to_vec(),
        lead: bytes[..header.offset].to_vec(),
        header,
        stride,
    };
    Ok(FlatPlate {
        path: path.to_path_buf(),
        texts: user_data::texts(&carried.lead, layout.big_endian),
        container: Container::Dpx(Box::new(carried)),
        depth: match layout.packing {
            Packing::Bits8 => SampleDepth::U8,
            Packing::Bits10(_) | Packing::Across(10) => SampleDepth::U10,
            Packing::Bits12(_) | Packing::Across(_) => SampleDepth::U12,
            Packing::Bits16 => SampleDepth::U16,
        },
        width: layout.width,
        height,
        names,
        planes,
        changed: false,
        notes: Vec::new(),
    })
}

/// Where the sample of the plane at `index` stands in a pixel.
fn component(layout: &Layout, index: usize) -> usize {
    match layout.reversed {
        true => layout.components - 1 - index,
        false => index,
    }
}

/// Bytes from line to line. Lines are to begin at 32-bit words, which some writers do not heed: theirs are known by the
/// length of the file.
fn stride(path: &Path, header: &Header, length: usize) -> Result<usize> {
    let (line, height) = (header.layout.line_bytes(), header.height);
    let room = length - header.offset;
    let plain = line.saturating_add(header.line_padding);
    let needed = |stride: usize| stride.saturating_mul(height - 1).saturating_add(line);
    let standard = plain.checked_next_multiple_of(4).unwrap_or(plain);
    if plain.checked_mul(height) == Some(room) {
        return Ok(plain);
    }
    // Some writers fill words and call them packed.
    if let Packing::Across(bits) = header.layout.packing {
        let filled = match bits {
            10 => Packing::Bits10(Justified::High),
            _ => Packing::Bits12(Justified::High),
        };
        let layout = Layout {
            packing: filled,
            ..header.layout
        };
        if layout.line_bytes().checked_mul(height) == Some(room) {
            return Err(FileError::new(
                path,
                "packing",
                "is 0, samples across words, but the image data are as long as filled words",
                "save it as 10 bits filled to 32-bit words (method A) or as 16 bits",
            ));
        }
    }
    let fitting = [standard, plain].into_iter().find(|&s| needed(s) <= room);
    fitting.ok_or_else(|| {
        FileError::new(
            path,
            "image data",
            format!(
                "takes {} bytes, but {room} are left in the file",
                needed(plain)
            ),
            "the file is truncated or its header damaged: copy or render it again",
        )
    })
}

/// Writes a DPX file whole or not at all.
pub(crate) fn write(path: &Path, plate: &FlatPlate, carried: &Carried) -> Result<()> {
    let Carried {
        lead,
        tail,
        header,
        stride,
    } = carried;
    let layout = &header.layout;
    let mut lead = user_data::with_texts(lead, layout.big_endian, &plate.texts);
    let size = lead.len() + stride * header.height + tail.len();
    set_file_size(&mut lead, layout.big_endian, size);
    let full_scale = layout.packing.full_scale();
    write_whole(path, |out| {
        out.write_all(&lead)?;
        let mut codes = vec![0; layout.samples()];
        let mut line = Vec::new();
        for y in 0..header.height {
            for (at, plane) in plate.planes.iter().enumerate() {
                let at = component(layout, at);
                let row = &plane[y * layout.width..][..layout.width];
                let own = codes.iter_mut().skip(at).step_by(layout.components);
                for (code, &sample) in own.zip(row) {
                    *code = to_integer(sample, full_scale);
                }
            }
            line.clear();
            layout.pack(&codes, &mut line);
            line.resize(*stride, 0);
            out.write_all(&line)?;
        }
        out.write_all(tail)
    })
}

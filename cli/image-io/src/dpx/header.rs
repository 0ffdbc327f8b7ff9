//! The fields of a DPX header (SMPTE 268M-2003) that pixels hang on, and new headers.

use std::path::Path;

use super::samples::{Justified, Layout, Packing};
use crate::error::{FileError, Result};
use crate::flat_plate::Encoding;

/// Bytes of the header: the generic part and the motion-picture and television part.
pub(crate) const HEADER: usize = 2048;

/// A whole number that the writer left undefined.
const UNDEFINED: u32 = u32::MAX;

/// Where fields begin.
const IMAGE_OFFSET: usize = 4;
const FILE_SIZE: usize = 16;
const USER_DATA: usize = 32;
const ORIENTATION: usize = 768;
const ELEMENTS: usize = 770;
const WIDTH: usize = 772;
const HEIGHT: usize = 776;
const DATA_SIGN: usize = 780;
const DESCRIPTOR: usize = 800;
const TRANSFER: usize = 801;
const COLORIMETRIC: usize = 802;
const BIT_SIZE: usize = 803;
const PACKING: usize = 804;
const ENCODING: usize = 806;
const ELEMENT_OFFSET: usize = 808;
const LINE_PADDING: usize = 812;
const DESCRIPTION: usize = 820;
const PIXEL_ASPECT: usize = 1628;

/// What an image element of ours is described as where its codes are sRGB: the standard has no number for that.
const SRGB_DESCRIPTION: &[u8] = b"sRGB (IEC 61966-2-1)";

/// Image elements by their descriptor.
const LUMA: u8 = 6;
const RGB: u8 = 50;
const RGBA: u8 = 51;
const ABGR: u8 = 52;

/// What a header says of the pixels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// Where pixels begin in the file.
    pub(crate) offset: usize,
    pub(crate) height: usize,
    pub(crate) layout: Layout,
    /// Bytes at the end of each line, as the header says.
    pub(crate) line_padding: usize,
    /// The transfer characteristic by its number.
    pub(crate) transfer: u8,
    /// Whether the element is described as sRGB codes.
    pub(crate) is_srgb: bool,
    /// Width of a pixel over its height.
    pub(crate) pixel_aspect: f64,
}

/// Numbers in the byte order of a file.
pub(crate) struct Fields<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) big_endian: bool,
}

impl Fields<'_> {
    fn u16(&self, at: usize) -> u16 {
        let pair = [self.bytes[at], self.bytes[at + 1]];
        match self.big_endian {
            true => u16::from_be_bytes(pair),
            false => u16::from_le_bytes(pair),
        }
    }

    pub(crate) fn u32(&self, at: usize) -> u32 {
        let (first, second) = (u32::from(self.u16(at)), u32::from(self.u16(at + 2)));
        match self.big_endian {
            true => first << 16 | second,
            false => second << 16 | first,
        }
    }
}

/// Writes a number into a header in its byte order.
pub(crate) fn put_u32(header: &mut [u8], big_endian: bool, at: usize, value: u32) {
    let bytes = match big_endian {
        true => value.to_be_bytes(),
        false => value.to_le_bytes(),
    };
    header[at..at + 4].copy_from_slice(&bytes);
}

fn put_u16(header: &mut [u8], big_endian: bool, at: usize, value: u16) {
    let bytes = match big_endian {
        true => value.to_be_bytes(),
        false => value.to_le_bytes(),
    };
    header[at..at + 2].copy_from_slice(&bytes);
}

/// Reads the header at the start of `file`.
pub(crate) fn parse(path: &Path, file: &[u8]) -> Result<Header> {
    let refuse = |field: &str, problem: String, remedy: &str| {
        Err(FileError::new(path, field, problem, remedy))
    };
    if file.len() < HEADER {
        let problem = format!("is {} bytes of a header of {HEADER}", file.len());
        return refuse("", problem, "copy or render the file again");
    }
    let fields = Fields {
        bytes: file,
        big_endian: file.starts_with(b"SDPX"),
    };
    let again =
        "save it as one uncompressed 10- or 16-bit RGB image, left to right and top to bottom";
    match fields.u16(ELEMENTS) {
        1 => {}
        count => {
            let problem = format!("is {count}; pixels in several or no elements are not supported");
            return refuse("number of image elements", problem, again);
        }
    }
    match fields.u16(ORIENTATION) {
        0 | u16::MAX => {}
        other => {
            let problem =
                format!("is {other}; only 0, left to right and top to bottom, is supported");
            return refuse("image orientation", problem, again);
        }
    }
    if fields.u32(DATA_SIGN) == 1 {
        return refuse(
            "data sign",
            "is signed, which is not supported".into(),
            again,
        );
    }
    match fields.u16(ENCODING) {
        0 | u16::MAX => {}
        1 => {
            let problem = "is 1, run-length encoded, which is not supported";
            return refuse("encoding", problem.into(), again);
        }
        other => return refuse("encoding", format!("is {other}, which is unknown"), again),
    }
    let (components, reversed) = match file[DESCRIPTOR] {
        LUMA => (1, false),
        RGB => (3, false),
        RGBA => (4, false),
        ABGR => (4, true),
        other => {
            let problem =
                format!("is {other}; supported are 6 (luma), 50 (RGB), 51 (RGBA) and 52 (ABGR)");
            return refuse("descriptor", problem, again);
        }
    };
    let packing = packing(path, file[BIT_SIZE], fields.u16(PACKING))?;
    let offset = match fields.u32(ELEMENT_OFFSET) {
        0 | UNDEFINED => fields.u32(IMAGE_OFFSET),
        offset => offset,
    } as usize;
    if offset < HEADER || offset > file.len() {
        let problem = format!("is {offset} in a file of {} bytes", file.len());
        let remedy =
            format!("a file whose pixels begin after a header of {HEADER} bytes is needed");
        return refuse("offset to image data", problem, &remedy);
    }
    let line_padding = match fields.u32(LINE_PADDING) {
        UNDEFINED => 0,
        padding => padding as usize,
    };
    let aspect = (fields.u32(PIXEL_ASPECT), fields.u32(PIXEL_ASPECT + 4));
    let pixel_aspect = match aspect {
        (0 | UNDEFINED, _) | (_, 0 | UNDEFINED) => 1.0,
        (x, y) => f64::from(x) / f64::from(y),
    };
    Ok(Header {
        offset,
        height: fields.u32(HEIGHT) as usize,
        layout: Layout {
            width: fields.u32(WIDTH) as usize,
            components,
            reversed,
            packing,
            big_endian: fields.big_endian,
        },
        line_padding,
        transfer: file[TRANSFER],
        is_srgb: file[DESCRIPTION..].starts_with(SRGB_DESCRIPTION),
        pixel_aspect,
    })
}

fn packing(path: &Path, bits: u8, method: u16) -> Result<Packing> {
    let justified = match method {
        1 => Some(Justified::High),
        2 => Some(Justified::Low),
        _ => None,
    };
    let (field, problem) = match (bits, justified) {
        (8, _) => return Ok(Packing::Bits8),
        (16, _) => return Ok(Packing::Bits16),
        (10, Some(justified)) => return Ok(Packing::Bits10(justified)),
        (12, Some(justified)) => return Ok(Packing::Bits12(justified)),
        (10 | 12, None) if method == 0 => return Ok(Packing::Across(bits)),
        (10 | 12, None) => ("packing", format!("is {method}, which is unknown")),
        _ => (
            "bit size",
            format!("is {bits}; supported are 8, 10, 12 and 16"),
        ),
    };
    let remedy = "save it as 10 bits filled to 32-bit words (method A) or as 16 bits";
    Err(FileError::new(path, field, problem, remedy))
}

impl Header {
    /// What codes mean: sRGB where the file describes them so, else proportional to light.
    pub(crate) fn encoding(&self) -> Encoding {
        match self.is_srgb {
            true => Encoding::Srgb,
            false => Encoding::Linear,
        }
    }

    /// The transfer characteristic in words.
    pub(crate) fn transfer_name(&self) -> String {
        let known = match self.transfer {
            0 => "user defined",
            1 => "printing density",
            2 => "linear",
            3 => "logarithmic",
            4 => "unspecified video",
            5 => "SMPTE 274M",
            6 => "ITU-R 709-4",
            7 => "ITU-R 601-5, 625 lines",
            8 => "ITU-R 601-5, 525 lines",
            9 => "NTSC composite video",
            10 => "PAL composite video",
            11 => "linear depth",
            12 => "homogeneous depth",
            u8::MAX => "nothing",
            other => return format!("transfer characteristic {other}"),
        };
        known.to_owned()
    }
}

/// What a new file is to be.
pub(crate) struct NewHeader {
    pub(crate) height: usize,
    pub(crate) layout: Layout,
    pub(crate) line_padding: usize,
    /// What codes mean; `None` where nothing is known of it.
    pub(crate) encoding: Option<Encoding>,
    pub(crate) pixel_aspect: f64,
}

/// A header with its fields but for the size of the file, without user data.
pub(crate) fn made(new: &NewHeader) -> Vec<u8> {
    let layout = &new.layout;
    let big_endian = layout.big_endian;
    // Numbers that are not known are all ones, texts are empty.
    let mut header = vec![0xff; HEADER];
    for (at, length) in [
        (36, 624),
        (664, 104),
        (DESCRIPTION, 32),
        (1356, 52),
        (1432, 188),
        (1644, 20),
        (1664, 48),
        (1732, 188),
        (1972, 76),
    ] {
        header[at..at + length].fill(0);
    }
    header[..4].copy_from_slice(if big_endian { b"SDPX" } else { b"XPDS" });
    header[8..16].copy_from_slice(b"V2.0\0\0\0\0");
    let creator = concat!("Seidel ", env!("CARGO_PKG_VERSION"));
    header[160..160 + creator.len()].copy_from_slice(creator.as_bytes());
    let mut put = |at, value| put_u32(&mut header, big_endian, at, value);
    put(IMAGE_OFFSET, HEADER as u32);
    // A new file, header lengths, no user data.
    put(20, 1);
    put(24, 1664);
    put(28, 384);
    put(USER_DATA, 0);
    let (width, height) = (layout.width as u32, new.height as u32);
    put(WIDTH, width);
    put(HEIGHT, height);
    put(DATA_SIGN, 0);
    // The codes of least and most light.
    put(784, 0);
    put(792, u32::from(layout.packing.full_scale()));
    put(ELEMENT_OFFSET, HEADER as u32);
    put(LINE_PADDING, new.line_padding as u32);
    put(816, 0);
    // The picture is all there was.
    put(1408, 0);
    put(1412, 0);
    put(1424, width);
    put(1428, height);
    let (x, y) = ratio(new.pixel_aspect);
    put(PIXEL_ASPECT, x);
    put(PIXEL_ASPECT + 4, y);
    put_u16(&mut header, big_endian, ORIENTATION, 0);
    put_u16(&mut header, big_endian, ELEMENTS, 1);
    let method = match layout.packing {
        Packing::Bits10(Justified::High) | Packing::Bits12(Justified::High) => 1,
        Packing::Bits10(Justified::Low) | Packing::Bits12(Justified::Low) => 2,
        Packing::Bits8 | Packing::Bits16 | Packing::Across(_) => 0,
    };
    put_u16(&mut header, big_endian, PACKING, method);
    put_u16(&mut header, big_endian, ENCODING, 0);
    header[DESCRIPTOR] = match (layout.components, layout.reversed) {
        (1, _) => LUMA,
        (3, _) => RGB,
        (_, false) => RGBA,
        (_, true) => ABGR,
    };
    header[BIT_SIZE] = layout.packing.bits();
    // Transfer and colorimetry: linear, or else user defined.
    let transfer = u8::from(new.encoding == Some(Encoding::Linear)) * 2;
    header[TRANSFER] = transfer;
    header[COLORIMETRIC] = 0;
    if new.encoding == Some(Encoding::Srgb) {
        header[DESCRIPTION..DESCRIPTION + SRGB_DESCRIPTION.len()].copy_from_slice(SRGB_DESCRIPTION);
    }
    header
}

/// Has a header call its codes user defined, where it says anything else of them; the names of what it said.
pub(crate) fn drop_colour(header: &mut [u8]) -> Vec<String> {
    let mut names = Vec::new();
    for (at, name) in [
        (TRANSFER, "the transfer characteristic"),
        (COLORIMETRIC, "the colorimetric specification"),
    ] {
        if ![0, u8::MAX].contains(&header[at]) {
            header[at] = 0;
            names.push(name.to_owned());
        }
    }
    if header[DESCRIPTION..].starts_with(SRGB_DESCRIPTION) {
        header[DESCRIPTION..DESCRIPTION + SRGB_DESCRIPTION.len()].fill(0);
        names.push("the description as sRGB".to_owned());
    }
    names
}

/// Bytes of user data after the header; none where that is not said.
pub(crate) fn user_data(header: &[u8], big_endian: bool) -> usize {
    let fields = Fields {
        bytes: header,
        big_endian,
    };
    match fields.u32(USER_DATA) {
        UNDEFINED => 0,
        length => length as usize,
    }
}

/// Has a header say how long its user data are.
pub(crate) fn set_user_data(header: &mut [u8], big_endian: bool, bytes: usize) {
    let bytes = u32::try_from(bytes).unwrap_or(UNDEFINED);
    put_u32(header, big_endian, USER_DATA, bytes);
}

/// Has a header say where pixels begin.
pub(crate) fn set_offset(header: &mut [u8], big_endian: bool, bytes: usize) {
    let bytes = u32::try_from(bytes).unwrap_or(UNDEFINED);
    put_u32(header, big_endian, IMAGE_OFFSET, bytes);
    put_u32(header, big_endian, ELEMENT_OFFSET, bytes);
}

/// Has a header say how long its file is.
pub(crate) fn set_file_size(header: &mut [u8], big_endian: bool, bytes: usize) {
    put_u32(
        header,
        big_endian,
        FILE_SIZE,
        u32::try_from(bytes).unwrap_or(UNDEFINED),
    );
}

/// A ratio as two whole numbers.
fn ratio(value: f64) -> (u32, u32) {
    const PARTS: u32 = 10_000;
    if value == value.round() {
        return (value as u32, 1);
    }
    ((value * f64::from(PARTS)).round() as u32, PARTS)
}

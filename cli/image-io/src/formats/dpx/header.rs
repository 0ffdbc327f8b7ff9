//! The fields of a DPX header (SMPTE 268M-2003) that describe the pixels, and new headers.

use std::path::Path;

use super::byte_order::ByteOrder;
use super::samples::{Layout, Packing, WordEnd};
use crate::error::{FileError, Result};
use crate::samples::Encoding;

/// Length of the header, bytes: the generic, motion-picture and television parts.
pub(super) const HEADER_BYTES: usize = 2048;

/// The value of an undefined integer field.
pub(super) const UNDEFINED: u32 = u32::MAX;

/// The transfer characteristic of linear samples.
pub(super) const LINEAR: u8 = 2;

/// Advice on unsupported packings.
pub(super) const SUPPORTED_PACKING: &str =
    "save it as 10 bits filled to 32-bit words (method A) or as 16 bits";

// Offsets of fields, bytes.
const IMAGE_OFFSET: usize = 4;
const VERSION: usize = 8;
const FILE_SIZE: usize = 16;
const NEW_FRAME: usize = 20;
/// Lengths of the generic header, and of the motion-picture and television headers.
const GENERIC_LENGTH: usize = 24;
const INDUSTRY_LENGTH: usize = 28;
const USER_DATA: usize = 32;
const CREATOR: usize = 160;
const ORIENTATION: usize = 768;
const ELEMENTS: usize = 770;
const WIDTH: usize = 772;
const HEIGHT: usize = 776;
const DATA_SIGN: usize = 780;
/// Reference codes.
const LOW_CODE: usize = 784;
const HIGH_CODE: usize = 792;
const DESCRIPTOR: usize = 800;
const TRANSFER: usize = 801;
const COLORIMETRIC: usize = 802;
const BIT_SIZE: usize = 803;
const PACKING: usize = 804;
const ENCODING: usize = 806;
const ELEMENT_OFFSET: usize = 808;
const LINE_PADDING: usize = 812;
const IMAGE_PADDING: usize = 816;
const DESCRIPTION: usize = 820;
/// Place of the image in the original one, and the size of that.
const ORIGINAL_X: usize = 1408;
const ORIGINAL_Y: usize = 1412;
const ORIGINAL_WIDTH: usize = 1424;
const ORIGINAL_HEIGHT: usize = 1428;
const PIXEL_ASPECT: usize = 1628;

/// Offsets and lengths of texts and reserved fields, which are zero if undefined.
const TEXTS: [(usize, usize); 9] = [
    (36, 624),
    (664, 104),
    (DESCRIPTION, 32),
    (1356, 52),
    (1432, 188),
    (1644, 20),
    (1664, 48),
    (1732, 188),
    (1972, 76),
];

/// The description of an image element with sRGB samples, for which the standard has no transfer characteristic.
const SRGB_DESCRIPTION: &[u8] = b"sRGB (IEC 61966-2-1)";

// Descriptors of image elements.
const LUMA: u8 = 6;
const RGB: u8 = 50;
const RGBA: u8 = 51;
const ABGR: u8 = 52;

/// The fields of a header that describe the pixels.
#[derive(Debug, Clone)]
pub(super) struct Header {
    /// Offset of the pixels in the file, bytes.
    pub(super) offset: usize,
    pub(super) height: usize,
    pub(super) layout: Layout,
    /// Padding at the end of each line, as the header states, bytes.
    pub(super) line_padding: usize,
    /// The number of the transfer characteristic.
    pub(super) transfer: u8,
    /// Whether the description of the element states sRGB samples.
    pub(super) is_srgb: bool,
    /// Width of a pixel over its height.
    pub(super) pixel_aspect: f64,
}

/// Access to integers in the byte order of a file.
pub(super) struct Fields<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) order: ByteOrder,
}

impl Fields<'_> {
    fn u16(&self, at: usize) -> u16 {
        self.order.u16(std::array::from_fn(|k| self.bytes[at + k]))
    }

    pub(super) fn u32(&self, at: usize) -> u32 {
        self.order.u32(std::array::from_fn(|k| self.bytes[at + k]))
    }
}

/// Writes an integer into a header in its byte order.
pub(super) fn put_u32(header: &mut [u8], order: ByteOrder, at: usize, value: u32) {
    header[at..at + 4].copy_from_slice(&order.bytes32(value));
}

/// Returns the packing of samples of `bits` bits by the packing method that the header states.
fn packing(path: &Path, bits: u8, method: u16) -> Result<Packing> {
    let end = match method {
        1 => Some(WordEnd::High),
        2 => Some(WordEnd::Low),
        _ => None,
    };
    let (field, problem) = match (bits, end) {
        (8, _) => return Ok(Packing::Bits8),
        (16, _) => return Ok(Packing::Bits16),
        (10, Some(end)) => return Ok(Packing::Bits10(end)),
        (12, Some(end)) => return Ok(Packing::Bits12(end)),
        (10 | 12, None) if method == 0 => return Ok(Packing::Contiguous(bits)),
        (10 | 12, None) => ("packing", format!("is {method}, which is unknown")),
        _ => (
            "bit size",
            format!("is {bits}; supported are 8, 10, 12 and 16"),
        ),
    };
    Err(FileError::new(path, field, problem, SUPPORTED_PACKING))
}

impl Header {
    /// Reads the header at the start of `file`.
    ///
    /// # Errors
    /// A truncated header, and files of several elements, other orientations, signed or run-length encoded samples.
    pub(super) fn parse(path: &Path, file: &[u8]) -> Result<Self> {
        let refuse = |field: &str, problem: String, remedy: &str| {
            Err(FileError::new(path, field, problem, remedy))
        };
        if file.len() < HEADER_BYTES {
            let problem = format!("has {} bytes of a header of {HEADER_BYTES}", file.len());
            return refuse("", problem, "copy or render the file again");
        }
        let fields = Fields {
            bytes: file,
            order: if file.starts_with(b"SDPX") {
                ByteOrder::Big
            } else {
                ByteOrder::Little
            },
        };
        let supported =
            "save it as one uncompressed 10- or 16-bit RGB image, left to right and top to bottom";
        let elements = fields.u16(ELEMENTS);
        if elements != 1 {
            let problem = format!("is {elements}; only one image element is supported");
            return refuse("number of image elements", problem, supported);
        }
        let orientation = fields.u16(ORIENTATION);
        if !matches!(orientation, 0 | u16::MAX) {
            let problem =
                format!("is {orientation}; only 0, left to right and top to bottom, is supported");
            return refuse("image orientation", problem, supported);
        }
        if fields.u32(DATA_SIGN) == 1 {
            return refuse(
                "data sign",
                "is signed, which is not supported".into(),
                supported,
            );
        }
        match fields.u16(ENCODING) {
            0 | u16::MAX => {}
            1 => {
                let problem = "is 1, run-length encoded, which is not supported";
                return refuse("encoding", problem.into(), supported);
            }
            other => {
                return refuse(
                    "encoding",
                    format!("is {other}, which is unknown"),
                    supported,
                );
            }
        }
        let (components, reversed) = match file[DESCRIPTOR] {
            LUMA => (1, false),
            RGB => (3, false),
            RGBA => (4, false),
            ABGR => (4, true),
            other => {
                let problem = format!(
                    "is {other}; supported are 6 (luma), 50 (RGB), 51 (RGBA) and 52 (ABGR)"
                );
                return refuse("descriptor", problem, supported);
            }
        };
        let packing = packing(path, file[BIT_SIZE], fields.u16(PACKING))?;
        let offset = match fields.u32(ELEMENT_OFFSET) {
            0 | UNDEFINED => fields.u32(IMAGE_OFFSET),
            offset => offset,
        } as usize;
        if offset < HEADER_BYTES || offset > file.len() {
            let problem = format!("is {offset} in a file of {} bytes", file.len());
            let remedy =
                format!("give a file whose pixels follow a header of {HEADER_BYTES} bytes");
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
        Ok(Self {
            offset,
            height: fields.u32(HEIGHT) as usize,
            layout: Layout {
                width: fields.u32(WIDTH) as usize,
                components,
                reversed,
                packing,
                order: fields.order,
            },
            line_padding,
            transfer: file[TRANSFER],
            is_srgb: file[DESCRIPTION..].starts_with(SRGB_DESCRIPTION),
            pixel_aspect,
        })
    }

    /// Returns the encoding of the samples: sRGB if the description states it, else linear.
    pub(super) fn encoding(&self) -> Encoding {
        if self.is_srgb {
            Encoding::Srgb
        } else {
            Encoding::Linear
        }
    }

    /// Returns the name of the transfer characteristic.
    pub(super) fn transfer_name(&self) -> String {
        let known = match self.transfer {
            0 => "user defined",
            1 => "printing density",
            LINEAR => "linear",
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

    /// Returns the bytes of a new header, without file size and user data.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let layout = &self.layout;
        let order = layout.order;
        let (width, height) = (layout.width as u32, self.height as u32);
        let (aspect_x, aspect_y) = ratio(self.pixel_aspect);
        // Undefined numbers are all ones, undefined texts are empty.
        let mut header = vec![0xff; HEADER_BYTES];
        for (at, length) in TEXTS {
            header[at..at + length].fill(0);
        }
        let magic = match order {
            ByteOrder::Big => b"SDPX",
            ByteOrder::Little => b"XPDS",
        };
        let creator = concat!("Seidel ", env!("CARGO_PKG_VERSION"));
        let description = if self.is_srgb { SRGB_DESCRIPTION } else { b"" };
        for (at, text) in [
            (0, &magic[..]),
            (VERSION, b"V2.0\0\0\0\0"),
            (CREATOR, creator.as_bytes()),
            (DESCRIPTION, description),
        ] {
            header[at..at + text.len()].copy_from_slice(text);
        }
        for (at, value) in [
            (IMAGE_OFFSET, HEADER_BYTES as u32),
            (NEW_FRAME, 1),
            (GENERIC_LENGTH, 1664),
            (INDUSTRY_LENGTH, 384),
            (USER_DATA, 0),
            (WIDTH, width),
            (HEIGHT, height),
            (DATA_SIGN, 0),
            (LOW_CODE, 0),
            (HIGH_CODE, u32::from(layout.packing.full_scale())),
            (ELEMENT_OFFSET, HEADER_BYTES as u32),
            (LINE_PADDING, self.line_padding as u32),
            (IMAGE_PADDING, 0),
            (ORIGINAL_X, 0),
            (ORIGINAL_Y, 0),
            (ORIGINAL_WIDTH, width),
            (ORIGINAL_HEIGHT, height),
            (PIXEL_ASPECT, aspect_x),
            (PIXEL_ASPECT + 4, aspect_y),
        ] {
            put_u32(&mut header, order, at, value);
        }
        let method = match layout.packing {
            Packing::Bits10(WordEnd::High) | Packing::Bits12(WordEnd::High) => 1,
            Packing::Bits10(WordEnd::Low) | Packing::Bits12(WordEnd::Low) => 2,
            Packing::Bits8 | Packing::Bits16 | Packing::Contiguous(_) => 0,
        };
        for (at, value) in [
            (ORIENTATION, 0),
            (ELEMENTS, 1),
            (PACKING, method),
            (ENCODING, 0),
        ] {
            header[at..at + 2].copy_from_slice(&order.bytes16(value));
        }
        let descriptor = match (layout.components, layout.reversed) {
            (1, _) => LUMA,
            (3, _) => RGB,
            (_, false) => RGBA,
            (_, true) => ABGR,
        };
        for (at, value) in [
            (DESCRIPTOR, descriptor),
            (TRANSFER, self.transfer),
            (COLORIMETRIC, 0),
            (BIT_SIZE, layout.packing.bits()),
        ] {
            header[at] = value;
        }
        header
    }
}

/// Makes the colour statements of a header "user defined". Returns the names of those that were others.
pub(super) fn remove_colour_space(header: &mut [u8]) -> Vec<String> {
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

/// Returns the length of the user data after the header, bytes; zero if undefined.
pub(super) fn user_data_length(header: &[u8], order: ByteOrder) -> usize {
    let fields = Fields {
        bytes: header,
        order,
    };
    match fields.u32(USER_DATA) {
        UNDEFINED => 0,
        length => length as usize,
    }
}

/// Stores the length of the user data in a header.
pub(super) fn set_user_data_length(header: &mut [u8], order: ByteOrder, bytes: usize) {
    let bytes = u32::try_from(bytes).unwrap_or(UNDEFINED);
    put_u32(header, order, USER_DATA, bytes);
}

/// Stores the offset of the pixels in a header.
pub(super) fn set_offset(header: &mut [u8], order: ByteOrder, bytes: usize) {
    let bytes = u32::try_from(bytes).unwrap_or(UNDEFINED);
    put_u32(header, order, IMAGE_OFFSET, bytes);
    put_u32(header, order, ELEMENT_OFFSET, bytes);
}

/// Stores the size of the file in a header.
pub(super) fn set_file_size(header: &mut [u8], order: ByteOrder, bytes: usize) {
    let bytes = u32::try_from(bytes).unwrap_or(UNDEFINED);
    put_u32(header, order, FILE_SIZE, bytes);
}

/// Returns a ratio as numerator and denominator.
fn ratio(value: f64) -> (u32, u32) {
    const DENOMINATOR: u32 = 10_000;
    if value == value.round() {
        return (value as u32, 1);
    }
    ((value * f64::from(DENOMINATOR)).round() as u32, DENOMINATOR)
}

//! The metadata of a DPX file: its whole header and user data, and the fields that other formats store too.

use std::path::Path;

use exr::meta::attribute::{KeyCode, TimeCode};

use super::byte_order::ByteOrder;
use super::header::{self, Fields, Header, UNDEFINED, put_u32};
use super::samples::{Layout, Packing, WordEnd};
use super::user_data;
use crate::error::Result;
use crate::metadata::{
    CAMERA_MODEL, CAMERA_SERIAL, CommonMetadata, DEFAULT_PERFORATIONS, KEY_CODE, TextAttributes,
    fraction_of_rate, is_provenance, key_code_text, rate_of_fraction, time_code_text,
};
use crate::new_image::NewImage;
use crate::raster::{AssumedEncoding, Metadata, RasterImage};
use crate::samples::{Encoding, SampleFormat};

/// The metadata of a DPX file, and the layout of its pixels.
#[derive(Debug, Clone)]
pub(super) struct DpxMetadata {
    /// All bytes before the pixels: the header and user data.
    pub(super) before_pixels: Vec<u8>,
    /// All bytes after the pixels.
    pub(super) after_pixels: Vec<u8>,
    pub(super) header: Header,
    /// Bytes from the start of a line to that of the next.
    pub(super) stride: usize,
}

impl DpxMetadata {
    /// Creates the metadata of a new file: big endian, without common metadata and provenance.
    pub(super) fn new(image: &NewImage) -> Self {
        let window = image.windows.data;
        let layout = Layout {
            width: window.width,
            components: image.channels(),
            reversed: false,
            packing: match image.sample_format {
                SampleFormat::U8 => Packing::Bits8,
                SampleFormat::U12 => Packing::Bits12(WordEnd::High),
                SampleFormat::U16 => Packing::Bits16,
                _ => Packing::Bits10(WordEnd::High),
            },
            order: ByteOrder::Big,
        };
        let stride = layout.line_bytes().next_multiple_of(4);
        let mut header = Header {
            offset: header::HEADER_BYTES,
            height: window.height,
            layout,
            // Stated as padding too, for readers that do not align lines.
            line_padding: stride - layout.line_bytes(),
            transfer: 0,
            is_srgb: image.encoding == Some(Encoding::Srgb),
            pixel_aspect: image.pixel_aspect,
        };
        if image.encoding == Some(Encoding::Linear) {
            header.transfer = header::LINEAR;
        }
        Self {
            before_pixels: header.to_bytes(),
            after_pixels: Vec::new(),
            header,
            stride,
        }
    }

    /// Stores common metadata in the header. Returns the names, as EXR calls them, of those that do not fit.
    pub(super) fn set_common(&mut self, common: &CommonMetadata) -> Vec<&'static str> {
        let order = self.header.layout.order;
        let header = &mut self.before_pixels;
        let mut lost = Vec::new();
        if let Some(code) = &common.time_code {
            match code.pack_time_as_tv60_u32() {
                Ok(word) => {
                    put_u32(header, order, TIME_CODE, word);
                    let bits = code.pack_user_data_as_u32();
                    put_u32(header, order, USER_BITS, bits);
                }
                Err(_) => lost.push("timeCode"),
            }
        }
        if let Some(fraction) = common.frame_rate {
            match rate_of_fraction(fraction) {
                Some(rate) => {
                    put_u32(header, order, FILM_FRAME_RATE, rate.to_bits());
                    put_u32(header, order, TELEVISION_FRAME_RATE, rate.to_bits());
                }
                None => lost.push("framesPerSecond"),
            }
        }
        if let Some(angle) = common.shutter_angle {
            put_u32(header, order, SHUTTER_ANGLE, angle.to_bits());
        }
        let date = common.capture_date.as_ref();
        let date = date.map(|text| match exr_date(text) {
            Some(date) => date.replace(' ', ":"),
            None => text.clone(),
        });
        for (field, name, text) in [
            (COPYRIGHT, "owner", &common.owner),
            (CREATION_DATE, "capDate", &date),
            (SOURCE_DATE, "capDate", &date),
            (INPUT_DEVICE, CAMERA_MODEL, &common.camera_model),
            (INPUT_DEVICE_SERIAL, CAMERA_SERIAL, &common.camera_serial),
        ] {
            if let Some(text) = text
                && !put_text(header, field, text)
                && !lost.contains(&name)
            {
                lost.push(name);
            }
        }
        if let Some(code) = &common.key_code {
            let perforations = (code.perforations_per_frame, code.perforations_per_count);
            if !put_edge_code(header, code) {
                lost.push(KEY_CODE);
            } else if perforations != DEFAULT_PERFORATIONS {
                lost.push("the perforations per frame and count of keyCode");
            }
        }
        lost
    }

    fn byte_order(&self) -> ByteOrder {
        self.header.layout.order
    }

    /// Returns all texts that people write into a header.
    fn header_texts(&self) -> TextAttributes {
        let named = [
            ("created", CREATION_DATE),
            ("creator", CREATOR),
            ("project", PROJECT),
            ("copyright", COPYRIGHT),
            ("source created", SOURCE_DATE),
            ("input device", INPUT_DEVICE),
            ("input device serial number", INPUT_DEVICE_SERIAL),
            ("frame", FRAME_ID),
            ("slate", SLATE),
        ];
        let texts = named.into_iter();
        texts
            .filter_map(|(name, field)| Some((name.to_owned(), text(&self.before_pixels, field)?)))
            .collect()
    }
}

impl Metadata for DpxMetadata {
    fn write(&self, path: &Path, image: &RasterImage) -> Result<()> {
        super::write(path, image, self)
    }

    fn encoding(&self) -> Option<Encoding> {
        Some(self.header.encoding())
    }

    fn pixel_aspect(&self) -> f64 {
        self.header.pixel_aspect
    }

    fn common(&self) -> CommonMetadata {
        let header = &self.before_pixels[..];
        let fields = Fields {
            bytes: header,
            order: self.byte_order(),
        };
        let rate =
            positive(&fields, FILM_FRAME_RATE).or_else(|| positive(&fields, TELEVISION_FRAME_RATE));
        let date = |field| text(header, field).and_then(|text| exr_date(&text));
        CommonMetadata {
            time_code: time_code(&fields),
            frame_rate: rate.and_then(fraction_of_rate),
            owner: text(header, COPYRIGHT),
            capture_date: date(SOURCE_DATE).or_else(|| date(CREATION_DATE)),
            camera_model: text(header, INPUT_DEVICE),
            camera_serial: text(header, INPUT_DEVICE_SERIAL),
            shutter_angle: positive(&fields, SHUTTER_ANGLE),
            key_code: edge_code(header),
        }
    }

    fn remove_colour_space(&mut self) -> Vec<String> {
        self.header.transfer = 0;
        self.header.is_srgb = false;
        header::remove_colour_space(&mut self.before_pixels)
    }

    fn summary(&self) -> TextAttributes {
        let common = self.common();
        let fields = [
            ("transfer characteristic", Some(self.header.transfer_name())),
            ("pixel aspect", Some(self.pixel_aspect().to_string())),
            ("time code", common.time_code.as_ref().map(time_code_text)),
            (
                "frame rate",
                common
                    .frame_rate
                    .and_then(rate_of_fraction)
                    .map(|rate| rate.to_string()),
            ),
            (
                "shutter angle",
                common.shutter_angle.map(|angle| angle.to_string()),
            ),
            (
                "film edge code",
                common.key_code.as_ref().map(key_code_text),
            ),
        ];
        let stated = fields.into_iter();
        let stated = stated.filter_map(|(name, value)| Some((name.to_owned(), value?)));
        stated.chain(self.header_texts()).collect()
    }

    fn read_warning(&self, assumed: AssumedEncoding) -> Option<String> {
        let encoding = assumed.encoding?;
        let stated = self.header.transfer_name();
        let is_certain =
            assumed.from_user || stated == "linear" || self.header.encoding() == Encoding::Srgb;
        let advice = if is_certain {
            ""
        } else {
            ": if they are not, give --encoding, or convert the plate to scene-linear first"
        };
        Some(format!(
            "the DPX header states {stated} as transfer characteristic; samples are read as {encoding}{advice}"
        ))
    }

    fn rewrite_losses(&self, image: &RasterImage) -> Vec<String> {
        let has_provenance = image.texts.iter().any(|(name, _)| is_provenance(name));
        if has_provenance && user_data::is_foreign(&self.before_pixels, self.byte_order()) {
            return vec![
                "the DPX holds user data of another program, so provenance is not written into it"
                    .to_owned(),
            ];
        }
        Vec::new()
    }

    fn conversion_loss(&self, kept: &[&str]) -> Option<String> {
        Some(if kept.is_empty() {
            "the header of the DPX and its user data".to_owned()
        } else {
            let kept = kept.join(", ");
            format!("the header of the DPX, except {kept}, and its user data")
        })
    }
}

/// Offset and length of a text in the header, bytes.
type TextField = (usize, usize);

const CREATION_DATE: TextField = (136, 24);
const CREATOR: TextField = (160, 100);
const PROJECT: TextField = (260, 200);
const COPYRIGHT: TextField = (460, 200);
const SOURCE_DATE: TextField = (1532, 24);
const INPUT_DEVICE: TextField = (1556, 32);
const INPUT_DEVICE_SERIAL: TextField = (1588, 32);
/// The edge code of film: manufacturer, type, offset in perforations, prefix, count.
const EDGE_CODE: [TextField; 5] = [(1664, 2), (1666, 2), (1668, 2), (1670, 6), (1676, 4)];
const FILM_FRAME_RATE: usize = 1724;
const SHUTTER_ANGLE: usize = 1728;
const FRAME_ID: TextField = (1732, 32);
const SLATE: TextField = (1764, 100);
const TIME_CODE: usize = 1920;
const USER_BITS: usize = 1924;
const TELEVISION_FRAME_RATE: usize = 1940;

/// Returns a text of the header; `None` if it is empty or undefined.
fn text(header: &[u8], field: TextField) -> Option<String> {
    let (at, length) = field;
    let bytes = &header[at..at + length];
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(length);
    let text = String::from_utf8_lossy(&bytes[..end]).trim().to_owned();
    (!text.is_empty() && bytes[0] != 0xff).then_some(text)
}

/// Writes a text, terminated by zero, if it fits. Returns whether it does.
fn put_text(header: &mut [u8], field: TextField, text: &str) -> bool {
    let (at, length) = field;
    let fits = text.len() < length && !text.contains('\0');
    if fits {
        header[at..at + length].fill(0);
        header[at..at + text.len()].copy_from_slice(text.as_bytes());
    }
    fits
}

/// Returns a float of the header if it is positive and finite.
fn positive(fields: &Fields, at: usize) -> Option<f32> {
    let value = f32::from_bits(fields.u32(at));
    (value.is_finite() && value > 0.0).then_some(value)
}

/// Returns the time code of the header; `None` for invalid digits. Its digits and flags are laid out as in EXR, by
/// SMPTE 12M with hours first.
fn time_code(fields: &Fields) -> Option<TimeCode> {
    let word = fields.u32(TIME_CODE);
    let bits = match fields.u32(USER_BITS) {
        UNDEFINED => 0,
        bits => bits,
    };
    let code = TimeCode::from_tv60_time(word, bits);
    let is_valid = code.pack_time_as_tv60_u32().ok() == Some(word);
    (word != UNDEFINED && is_valid).then_some(code)
}

/// Converts a date `YYYY:MM:DD:hh:mm:ss` with any time zone to the form of EXR, `YYYY:MM:DD hh:mm:ss`.
fn exr_date(text: &str) -> Option<String> {
    let text = text.get(..19)?;
    let is_date = text.bytes().enumerate().all(|(at, byte)| match at {
        4 | 7 | 13 | 16 => byte == b':',
        10 => byte == b':' || byte == b' ',
        _ => byte.is_ascii_digit(),
    });
    is_date.then(|| format!("{} {}", &text[..10], &text[11..]))
}

/// Returns the edge code as the key code of EXR.
fn edge_code(header: &[u8]) -> Option<KeyCode> {
    let number = |k: usize| text(header, EDGE_CODE[k])?.parse::<u32>().ok();
    let number = |k: usize| number(k).and_then(|number| i32::try_from(number).ok());
    let (perforations_per_frame, perforations_per_count) = DEFAULT_PERFORATIONS;
    Some(KeyCode {
        film_manufacturer_code: number(0)?,
        film_type: number(1)?,
        perforation_offset: number(2)?,
        film_roll_prefix: number(3)?,
        count: number(4)?,
        perforations_per_frame,
        perforations_per_count,
    })
}

/// Writes an edge code if all of its numbers fit. Returns whether they do.
fn put_edge_code(header: &mut [u8], code: &KeyCode) -> bool {
    let numbers = [
        code.film_manufacturer_code,
        code.film_type,
        code.perforation_offset,
        code.film_roll_prefix,
        code.count,
    ];
    let digits = |((_, length), number): (TextField, i32)| {
        let digits = format!("{number:0length$}");
        (number >= 0 && digits.len() == length).then_some(digits)
    };
    let all: Option<Vec<String>> = EDGE_CODE.into_iter().zip(numbers).map(digits).collect();
    for ((at, length), digits) in EDGE_CODE.into_iter().zip(all.iter().flatten()) {
        header[at..at + length].copy_from_slice(digits.as_bytes());
    }
    all.is_some()
}

//! What a DPX header says of the picture beside its pixels (SMPTE 268M-2003): generic, orientation, motion-picture and
//! television headers.

use exr::meta::attribute::{KeyCode, TimeCode};

use super::header::{Fields, put_u32};
use crate::exr::key_code;
use crate::facts::{Facts, fraction, rate};
use crate::provenance::Texts;

/// Where a text begins, and its bytes.
type Place = (usize, usize);

const CREATED: Place = (136, 24);
const CREATOR: Place = (160, 100);
const PROJECT: Place = (260, 200);
const COPYRIGHT: Place = (460, 200);
const SOURCE_CREATED: Place = (1532, 24);
const DEVICE: Place = (1556, 32);
const SERIAL: Place = (1588, 32);
/// The edge code of film: manufacturer, type, offset in perforations, prefix, count.
const EDGE_CODE: [Place; 5] = [(1664, 2), (1666, 2), (1668, 2), (1670, 6), (1676, 4)];
const FILM_RATE: usize = 1724;
const SHUTTER_ANGLE: usize = 1728;
const FRAME_ID: Place = (1732, 32);
const SLATE: Place = (1764, 100);
const TIME_CODE: usize = 1920;
const USER_BITS: usize = 1924;
const TELEVISION_RATE: usize = 1940;

/// A number or word that the writer left undefined.
const UNDEFINED: u32 = u32::MAX;

/// A text of a header; nothing where it is empty or undefined.
fn text(header: &[u8], (at, length): Place) -> Option<String> {
    let field = &header[at..at + length];
    let end = field.iter().position(|&b| b == 0).unwrap_or(length);
    let text = String::from_utf8_lossy(&field[..end]).trim().to_owned();
    (!text.is_empty() && field[0] != 0xff).then_some(text)
}

/// A real number of a header, if it is one above zero.
fn positive(fields: &Fields, at: usize) -> Option<f32> {
    let value = f32::from_bits(fields.u32(at));
    (value.is_finite() && value > 0.0).then_some(value)
}

/// The time code of a header: its digits and flags are those of EXR, hours first, by SMPTE 12M. Nothing for digits that
/// are none.
fn time_code(fields: &Fields) -> Option<TimeCode> {
    let word = fields.u32(TIME_CODE);
    let bits = match fields.u32(USER_BITS) {
        UNDEFINED => 0,
        bits => bits,
    };
    let code = TimeCode::from_tv60_time(word, bits);
    let sound = code.pack_time_as_tv60_u32().ok() == Some(word);
    (word != UNDEFINED && sound).then_some(code)
}

/// A date as EXR has it, of `YYYY:MM:DD:hh:mm:ss` and a zone.
fn date(text: &str) -> Option<String> {
    let text = text.get(..19)?;
    let sound = text.bytes().enumerate().all(|(at, byte)| match at {
        4 | 7 | 13 | 16 => byte == b':',
        10 => byte == b':' || byte == b' ',
        _ => byte.is_ascii_digit(),
    });
    sound.then(|| format!("{} {}", &text[..10], &text[11..]))
}

/// The edge code, in the words that EXR plates have it in.
fn edge_code(header: &[u8]) -> Option<KeyCode> {
    let number = |k: usize| text(header, EDGE_CODE[k])?.parse::<u32>().ok();
    let number = |k: usize| number(k).and_then(|number| i32::try_from(number).ok());
    let (perforations_per_frame, perforations_per_count) = key_code::USUAL;
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

/// What the bytes before the pixels say of the picture.
pub(crate) fn facts(lead: &[u8], big_endian: bool) -> Facts {
    let fields = Fields {
        bytes: lead,
        big_endian,
    };
    let rate = positive(&fields, FILM_RATE).or_else(|| positive(&fields, TELEVISION_RATE));
    let dated = |place| text(lead, place).and_then(|text| date(&text));
    Facts {
        time_code: time_code(&fields),
        frame_rate: rate.and_then(fraction),
        owner: text(lead, COPYRIGHT),
        captured: dated(SOURCE_CREATED).or_else(|| dated(CREATED)),
        device: text(lead, DEVICE),
        serial: text(lead, SERIAL),
        shutter_angle: positive(&fields, SHUTTER_ANGLE),
        key_code: edge_code(lead),
    }
}

/// All texts of the header that people write, each with its name.
pub(crate) fn texts(lead: &[u8]) -> Texts {
    let named = [
        ("created", CREATED),
        ("creator", CREATOR),
        ("project", PROJECT),
        ("copyright", COPYRIGHT),
        ("source created", SOURCE_CREATED),
        ("input device", DEVICE),
        ("input device serial number", SERIAL),
        ("frame", FRAME_ID),
        ("slate", SLATE),
    ];
    let there = named.into_iter();
    there
        .filter_map(|(name, place)| Some((name.to_owned(), text(lead, place)?)))
        .collect()
}

/// Writes a text where it fits, with a zero at its end, and has it told what of it is lost otherwise.
fn put_text(header: &mut [u8], (at, length): Place, text: &str) -> bool {
    let fits = text.len() < length && !text.contains('\0');
    if fits {
        header[at..at + length].fill(0);
        header[at..at + text.len()].copy_from_slice(text.as_bytes());
    }
    fits
}

/// Writes what is known of a picture into a header; the names, as EXR has them, of what does not fit.
pub(crate) fn put_facts(header: &mut [u8], big_endian: bool, facts: &Facts) -> Vec<&'static str> {
    let mut lost = Vec::new();
    if let Some(code) = &facts.time_code {
        match code.pack_time_as_tv60_u32() {
            Ok(word) => {
                put_u32(header, big_endian, TIME_CODE, word);
                let bits = code.pack_user_data_as_u32();
                put_u32(header, big_endian, USER_BITS, bits);
            }
            Err(_) => lost.push("timeCode"),
        }
    }
    if let Some(fraction) = facts.frame_rate {
        match rate(fraction) {
            Some(rate) => {
                put_u32(header, big_endian, FILM_RATE, rate.to_bits());
                put_u32(header, big_endian, TELEVISION_RATE, rate.to_bits());
            }
            None => lost.push("framesPerSecond"),
        }
    }
    if let Some(angle) = facts.shutter_angle {
        put_u32(header, big_endian, SHUTTER_ANGLE, angle.to_bits());
    }
    let colons = facts.captured.as_ref();
    let colons = colons.map(|text| match date(text) {
        Some(date) => date.replace(' ', ":"),
        None => text.clone(),
    });
    for (place, name, text) in [
        (COPYRIGHT, "owner", &facts.owner),
        (CREATED, "capDate", &colons),
        (SOURCE_CREATED, "capDate", &colons),
        (DEVICE, crate::facts::CAMERA_MODEL, &facts.device),
        (SERIAL, crate::facts::CAMERA_SERIAL, &facts.serial),
    ] {
        if let Some(text) = text
            && !put_text(header, place, text)
            && !lost.contains(&name)
        {
            lost.push(name);
        }
    }
    if let Some(code) = &facts.key_code {
        if !put_edge_code(header, code) {
            lost.push(key_code::NAME);
        } else if (code.perforations_per_frame, code.perforations_per_count) != key_code::USUAL {
            lost.push("the perforations per frame and count of keyCode");
        }
    }
    lost
}

/// Writes an edge code; false where a number of it does not fit.
fn put_edge_code(header: &mut [u8], code: &KeyCode) -> bool {
    let numbers = [
        code.film_manufacturer_code,
        code.film_type,
        code.perforation_offset,
        code.film_roll_prefix,
        code.count,
    ];
    let digits = |((_, length), number): (Place, i32)| {
        let digits = format!("{number:0length$}");
        (number >= 0 && digits.len() == length).then_some(digits)
    };
    let all: Option<Vec<String>> = EDGE_CODE.into_iter().zip(numbers).map(digits).collect();
    for ((at, length), digits) in EDGE_CODE.into_iter().zip(all.iter().flatten()) {
        header[at..at + length].copy_from_slice(digits.as_bytes());
    }
    all.is_some()
}

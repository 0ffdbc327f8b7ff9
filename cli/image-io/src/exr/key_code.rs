//! Film key codes of OpenEXR files.
//!
//! The `exr` library reads the seven numbers of a key code but writes only six, which no program can read. So key codes
//! are wrapped as custom attributes, and their name and type are restored in the written file (see `header`).

use std::borrow::Cow;

use exr::meta::attribute::{AttributeValue, KeyCode, Text};
use exr::prelude::LayerAttributes;

use super::attributes::new_text;

/// Name of the attribute.
pub(crate) const NAME: &str = "keyCode";
/// Type of the attribute.
const TYPE: &str = "keycode";
// Name and type of the wrapped attribute, since the library refuses custom attributes of standard names. They have the
// lengths of the originals, so that restoring those moves nothing in the file.
const WRAPPED_NAME: &str = "keyCodX";
const WRAPPED_TYPE: &str = "keycodX";

/// Perforations per frame and per count of 35 mm film, the defaults of OpenEXR.
pub(crate) const DEFAULT_PERFORATIONS: (i32, i32) = (4, 64);

/// Wraps all key codes of a part as custom attributes.
pub(super) fn wrap_all(attributes: &mut LayerAttributes) {
    if let Some(code) = attributes.film_key_code.take() {
        insert(attributes, &code);
    }
    for value in attributes.other.values_mut() {
        if let AttributeValue::KeyCode(code) = value {
            *value = wrap_as_custom(code);
        }
    }
}

/// Adds a key code to a part.
pub(super) fn insert(attributes: &mut LayerAttributes, code: &KeyCode) {
    let name = new_text(WRAPPED_NAME);
    attributes.other.insert(name, wrap_as_custom(code));
}

fn wrap_as_custom(code: &KeyCode) -> AttributeValue {
    let bytes = numbers(code).into_iter();
    let bytes = bytes.flat_map(|(_, number)| number.to_le_bytes());
    AttributeValue::Custom {
        kind: new_text(WRAPPED_TYPE),
        bytes: bytes.collect(),
    }
}

/// Returns the key code of a part.
pub(super) fn find(attributes: &LayerAttributes) -> Option<KeyCode> {
    let name = Text::new_or_none(WRAPPED_NAME)?;
    let Some(AttributeValue::Custom { bytes, .. }) = attributes.other.get(&name) else {
        return None;
    };
    let mut numbers = bytes.chunks_exact(4).map(|four| {
        let four = four.try_into().unwrap_or_default();
        i32::from_le_bytes(four)
    });
    let mut next = || numbers.next();
    Some(KeyCode {
        film_manufacturer_code: next()?,
        film_type: next()?,
        film_roll_prefix: next()?,
        count: next()?,
        perforation_offset: next()?,
        perforations_per_frame: next()?,
        perforations_per_count: next()?,
    })
}

/// Returns the name under which an attribute is stored in the file.
pub(super) fn stored_name<'a>(name: &'a Text, value: &'a AttributeValue) -> Cow<'a, str> {
    match value {
        AttributeValue::Custom { kind, .. } => {
            let (name, _) = unwrap(name.as_slice(), kind.as_slice());
            String::from_utf8_lossy(name)
        }
        _ => String::from_utf8_lossy(name.as_slice()),
    }
}

/// Returns the stored name and type of an attribute, which differ from `name` and `kind` if it is wrapped.
pub(super) fn unwrap<'a>(name: &'a [u8], kind: &'a [u8]) -> (&'a [u8], &'a [u8]) {
    if kind != WRAPPED_TYPE.as_bytes() {
        return (name, kind);
    }
    if name == WRAPPED_NAME.as_bytes() {
        (NAME.as_bytes(), TYPE.as_bytes())
    } else {
        (name, TYPE.as_bytes())
    }
}

/// Returns the numbers in the order of the format, with OpenEXR's names.
fn numbers(code: &KeyCode) -> [(&'static str, i32); 7] {
    [
        ("filmMfcCode", code.film_manufacturer_code),
        ("filmType", code.film_type),
        ("prefix", code.film_roll_prefix),
        ("count", code.count),
        ("perfOffset", code.perforation_offset),
        ("perfsPerFrame", code.perforations_per_frame),
        ("perfsPerCount", code.perforations_per_count),
    ]
}

/// Formats a key code for people.
pub(crate) fn to_text(code: &KeyCode) -> String {
    let words = numbers(code).map(|(name, value)| format!("{name}={value}"));
    words.join(" ")
}

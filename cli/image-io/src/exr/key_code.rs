//! Film key codes of EXR. The library reads them but writes six of their seven numbers, which nobody can read. So they go
//! through it under another type, and get their own back in the file that it has written.

use std::borrow::Cow;

use exr::meta::attribute::{AttributeValue, KeyCode, Text};
use exr::prelude::LayerAttributes;

use crate::exr::texts::as_text;

/// The format's attribute.
pub(crate) const NAME: &str = "keyCode";
/// Its type.
const KIND: &str = "keycode";
/// What stands for both meanwhile, as long as they are so that nothing in the file moves. The library takes no attribute
/// of its own by the format's name.
const VEILED_NAME: &str = "keyCodX";
const VEILED_KIND: &str = "keycodX";

/// Perforations per frame and per count of 35 mm film, where nobody says them (OpenEXR has the same).
pub(crate) const USUAL: (i32, i32) = (4, 64);

/// Has all key codes of a part go through the library.
pub(crate) fn veil(attributes: &mut LayerAttributes) {
    if let Some(code) = attributes.film_key_code.take() {
        put(attributes, &code);
    }
    for value in attributes.other.values_mut() {
        if let AttributeValue::KeyCode(code) = value {
            *value = veiled(code);
        }
    }
}

/// Gives a part a key code.
pub(crate) fn put(attributes: &mut LayerAttributes, code: &KeyCode) {
    let name = as_text(VEILED_NAME);
    attributes.other.insert(name, veiled(code));
}

fn veiled(code: &KeyCode) -> AttributeValue {
    let bytes = numbers(code).into_iter();
    let bytes = bytes.flat_map(|(_, number)| number.to_le_bytes());
    AttributeValue::Custom {
        kind: as_text(VEILED_KIND),
        bytes: bytes.collect(),
    }
}

/// The key code of a part.
pub(crate) fn of(attributes: &LayerAttributes) -> Option<KeyCode> {
    let name = Text::new_or_none(VEILED_NAME)?;
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

/// The name of an attribute of a plate, as the format has it.
pub(crate) fn name_of<'a>(name: &'a Text, value: &'a AttributeValue) -> Cow<'a, str> {
    match value {
        AttributeValue::Custom { kind, .. } => {
            let (name, _) = unveiled(name.as_slice(), kind.as_slice());
            String::from_utf8_lossy(name)
        }
        _ => String::from_utf8_lossy(name.as_slice()),
    }
}

/// The name and type of an attribute that was written, as the format has them.
pub(crate) fn unveiled<'a>(name: &'a [u8], kind: &'a [u8]) -> (&'a [u8], &'a [u8]) {
    if kind != VEILED_KIND.as_bytes() {
        return (name, kind);
    }
    match name == VEILED_NAME.as_bytes() {
        true => (NAME.as_bytes(), KIND.as_bytes()),
        false => (name, KIND.as_bytes()),
    }
}

/// The numbers in the format's order, by OpenEXR's names.
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

/// For people to read.
pub(crate) fn in_words(code: &KeyCode) -> String {
    let words = numbers(code).map(|(name, value)| format!("{name}={value}"));
    words.join(" ")
}

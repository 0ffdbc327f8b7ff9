//! Attributes that the `exr` library would not write as they were read.
//!
//! It reads the seven numbers of a film key code but writes only six, which no program can read, and it refuses the
//! sample count of deep pixels in flat files. Both are kept under placeholder names, of the length of the real ones so
//! that nothing moves in the file when `header` restores them.

use std::borrow::Cow;

use exr::meta::attribute::{AttributeValue, KeyCode, Text};
use exr::prelude::LayerAttributes;

use super::library_types::new_text;

use crate::metadata::{KEY_CODE, key_code_numbers};

const KEY_CODE_PLACEHOLDER: &str = "keyCodX";
/// The type of key codes.
const KEY_CODE_TYPE: &str = "keycode";
const KEY_CODE_TYPE_PLACEHOLDER: &str = "keycodX";
/// The attribute that counts the samples of deep pixels, which flat files may have too.
const MAX_SAMPLES: &str = "maxSamplesPerPixel";
const MAX_SAMPLES_PLACEHOLDER: &str = "maxSamplesPerPixeX";

/// Replaces all key codes of a part by placeholders.
pub(super) fn replace_key_codes(attributes: &mut LayerAttributes) {
    if let Some(code) = attributes.film_key_code.take() {
        insert_key_code(attributes, &code);
    }
    for value in attributes.other.values_mut() {
        if let AttributeValue::KeyCode(code) = value {
            *value = placeholder(code);
        }
    }
}

/// Adds a key code to a part.
pub(super) fn insert_key_code(attributes: &mut LayerAttributes, code: &KeyCode) {
    let name = new_text(KEY_CODE_PLACEHOLDER);
    attributes.other.insert(name, placeholder(code));
}

/// Adds the sample count of deep pixels to a part.
pub(super) fn insert_max_samples(attributes: &mut LayerAttributes, count: i32) {
    let name = new_text(MAX_SAMPLES_PLACEHOLDER);
    attributes.other.insert(name, AttributeValue::I32(count));
}

/// Returns the numbers of a key code as a custom attribute.
fn placeholder(code: &KeyCode) -> AttributeValue {
    let numbers = key_code_numbers(code).into_iter();
    AttributeValue::Custom {
        kind: new_text(KEY_CODE_TYPE_PLACEHOLDER),
        bytes: numbers
            .flat_map(|(_, number)| number.to_le_bytes())
            .collect(),
    }
}

/// Returns the key code of a part.
pub(super) fn find_key_code(attributes: &LayerAttributes) -> Option<KeyCode> {
    let name = Text::new_or_none(KEY_CODE_PLACEHOLDER)?;
    let AttributeValue::Custom { bytes, .. } = attributes.other.get(&name)? else {
        return None;
    };
    let (numbers, _) = bytes.as_chunks::<4>();
    let &[
        manufacturer,
        film,
        prefix,
        count,
        offset,
        per_frame,
        per_count,
        ..,
    ] = numbers
    else {
        return None;
    };
    Some(KeyCode {
        film_manufacturer_code: i32::from_le_bytes(manufacturer),
        film_type: i32::from_le_bytes(film),
        film_roll_prefix: i32::from_le_bytes(prefix),
        count: i32::from_le_bytes(count),
        perforation_offset: i32::from_le_bytes(offset),
        perforations_per_frame: i32::from_le_bytes(per_frame),
        perforations_per_count: i32::from_le_bytes(per_count),
    })
}

/// Returns the name under which an attribute is stored in the file.
pub(super) fn stored_name<'a>(name: &'a Text, value: &'a AttributeValue) -> Cow<'a, str> {
    let kind = match value {
        AttributeValue::Custom { kind, .. } => kind.as_slice(),
        _ => &[],
    };
    String::from_utf8_lossy(restored(name.as_slice(), kind).0)
}

/// Returns the stored name and type of an attribute, which differ from `name` and `kind` if it is a placeholder.
pub(super) fn restored<'a>(name: &'a [u8], kind: &'a [u8]) -> (&'a [u8], &'a [u8]) {
    let is_key_code = kind == KEY_CODE_TYPE_PLACEHOLDER.as_bytes();
    if name == MAX_SAMPLES_PLACEHOLDER.as_bytes() {
        (MAX_SAMPLES.as_bytes(), kind)
    } else if is_key_code && name == KEY_CODE_PLACEHOLDER.as_bytes() {
        (KEY_CODE.as_bytes(), KEY_CODE_TYPE.as_bytes())
    } else if is_key_code {
        (name, KEY_CODE_TYPE.as_bytes())
    } else {
        (name, kind)
    }
}

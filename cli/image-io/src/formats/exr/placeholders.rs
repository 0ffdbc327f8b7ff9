//! Attributes that the `exr` library would not write as they were read.
//!
//! It reads the seven numbers of a film key code but writes only six, which no program can read. It refuses standard names
//! with values of another type than the standard's, and drops some attributes that flat files may have, such as `version`. All
//! of these are kept under placeholder names, of the length of the real ones so that nothing moves in the file when `header`
//! restores them.

use std::borrow::Cow;

use std::collections::HashMap;

use exr::meta::attribute::{AttributeValue, KeyCode, Text};
use exr::meta::header::standard_names;
use exr::prelude::LayerAttributes;

use super::library_types::new_text;

use crate::metadata::key_code_numbers;

/// The type of key codes.
const KEY_CODE_TYPE: &str = "keycode";
const KEY_CODE_TYPE_PLACEHOLDER: &str = "keycodX";
/// The bit that marks the last byte of a placeholder name. Standard names are ASCII.
const MARK: u8 = 0x80;

/// Returns the placeholder of a standard name.
fn marked(name: &[u8]) -> Text {
    let mut bytes = name.to_vec();
    if let Some(last) = bytes.last_mut() {
        *last |= MARK;
    }
    Text::from_slice_unchecked(&bytes)
}

/// Returns the standard name that a placeholder stands for; `None` for other names.
fn unmarked(name: &[u8]) -> Option<&'static [u8]> {
    let (last, start) = name.split_last()?;
    let is_it = |standard: &&&'static [u8]| {
        last & MARK != 0 && standard.split_last() == Some((&(last & !MARK), start))
    };
    standard_names::ALL.iter().find(is_it).copied()
}

/// Gives placeholder names to the attributes that have a standard name, and so a type that is not the standard's.
pub(super) fn replace_standard_names(attributes: &mut HashMap<Text, AttributeValue>) {
    for name in standard_names::ALL {
        if let Some(value) = attributes.remove(&Text::from_slice_unchecked(name)) {
            attributes.insert(marked(name), value);
        }
    }
}

/// Adds an attribute that the library drops, by its name, its type and its bytes.
pub(super) fn insert_dropped(
    attributes: &mut LayerAttributes,
    name: &[u8],
    kind: &[u8],
    value: &[u8],
) {
    let own = AttributeValue::Custom {
        kind: Text::from_slice_unchecked(kind),
        bytes: value.into(),
    };
    let name = if standard_names::ALL.contains(&name) {
        marked(name)
    } else {
        Text::from_slice_unchecked(name)
    };
    attributes.other.insert(name, own);
}

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
    (attributes.other).insert(marked(standard_names::KEY_CODE), placeholder(code));
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
    let name = marked(standard_names::KEY_CODE);
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
    let kind = if kind == KEY_CODE_TYPE_PLACEHOLDER.as_bytes() {
        KEY_CODE_TYPE.as_bytes()
    } else {
        kind
    };
    (unmarked(name).unwrap_or(name), kind)
}

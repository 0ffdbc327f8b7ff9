//! Mutations of JSON values. What is not JSON is left as it is.

use serde_json::{Map, Value};

use super::text::NUMBERS;
use crate::rng::Rng;

/// Replaces a number. Numbers that JSON lacks, such as NaN, become strings or are left to mutations of text.
pub(crate) fn replace_number(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change(bytes, rng, &Value::is_number, &mut |value, rng| {
        let text = *rng.pick(&NUMBERS);
        let number = serde_json::from_str(text);
        *value = number.unwrap_or_else(|_| Value::from(text));
    });
}

/// Replaces any value by one of another type.
pub(crate) fn replace_value(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change(bytes, rng, &|_| true, &mut |value, rng| {
        *value = match rng.below(9) {
            0 => Value::Null,
            1 => Value::Bool(true),
            2 => Value::from(-1),
            3 => Value::from(""),
            4 => Value::from("../../../x\u{1b}[2J\0"),
            5 => Value::from("long ".repeat(5000)),
            6 => Value::Array(vec![value.clone(); 1 + rng.below(40)]),
            7 => Value::Object(Map::new()),
            _ => Value::Array(Vec::new()),
        };
    });
}

/// Removes an entry of an object or a list.
pub(crate) fn drop_entry(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change(bytes, rng, &has_entries, &mut |value, rng| match value {
        Value::Object(map) => {
            let keys: Vec<String> = map.keys().cloned().collect();
            map.remove(rng.pick(&keys));
        }
        Value::Array(list) => {
            list.remove(rng.below(list.len()));
        }
        _ => {}
    });
}

/// Repeats an entry of a list, or gives an entry of an object the value of another one.
pub(crate) fn duplicate_entry(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change(bytes, rng, &has_entries, &mut |value, rng| match value {
        Value::Object(map) => {
            let keys: Vec<String> = map.keys().cloned().collect();
            let copy = map[rng.pick(&keys)].clone();
            map.insert(rng.pick(&keys).clone(), copy);
        }
        Value::Array(list) => {
            let copy = list[rng.below(list.len())].clone();
            let count = if rng.once_in(10) { 500 } else { 1 };
            list.extend(std::iter::repeat_n(copy, count));
        }
        _ => {}
    });
}

/// Renames a key.
pub(crate) fn rename_key(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    let is_object = |value: &Value| value.as_object().is_some_and(|map| !map.is_empty());
    change(bytes, rng, &is_object, &mut |value, rng| {
        if let Value::Object(map) = value {
            let keys: Vec<String> = map.keys().cloned().collect();
            let key = rng.pick(&keys).clone();
            let held = map.remove(&key).unwrap_or_default();
            let name = match rng.below(5) {
                0 => String::new(),
                1 => format!("{key}\u{1b}[2J"),
                2 => key.to_uppercase(),
                3 => key.repeat(2000),
                _ => format!("{key}s"),
            };
            map.insert(name, held);
        }
    });
}

/// Nests a value in lists.
pub(crate) fn nest(bytes: &mut Vec<u8>, rng: &mut Rng, _: &[u8]) {
    change(bytes, rng, &|_| true, &mut |value, rng| {
        for _ in 0..*rng.pick(&[1, 2, 40, 100]) {
            *value = Value::Array(vec![value.take()]);
        }
    });
}

/// Replaces a value by one of another seed.
pub(crate) fn graft(bytes: &mut Vec<u8>, rng: &mut Rng, other: &[u8]) {
    let Ok(other) = serde_json::from_slice::<Value>(other) else {
        return;
    };
    let at = rng.below(count(&other, &|_| true));
    let mut left = at;
    let mut copy = Value::Null;
    let mut other = other;
    visit(&mut other, &|_| true, &mut left, &mut |value| {
        copy = value.clone();
    });
    change(bytes, rng, &|_| true, &mut |value, _| *value = copy.clone());
}

fn has_entries(value: &Value) -> bool {
    match value {
        Value::Object(map) => !map.is_empty(),
        Value::Array(list) => !list.is_empty(),
        _ => false,
    }
}

/// Changes one of the values that `is_wanted` accepts.
fn change(
    bytes: &mut Vec<u8>,
    rng: &mut Rng,
    is_wanted: &dyn Fn(&Value) -> bool,
    apply: &mut dyn FnMut(&mut Value, &mut Rng),
) {
    let Ok(mut root) = serde_json::from_slice::<Value>(bytes) else {
        return;
    };
    let count = count(&root, is_wanted);
    if count == 0 {
        return;
    }
    let mut left = rng.below(count);
    visit(&mut root, is_wanted, &mut left, &mut |value| {
        apply(value, rng)
    });
    *bytes = root.to_string().into_bytes();
}

fn count(value: &Value, is_wanted: &dyn Fn(&Value) -> bool) -> usize {
    let inner: usize = match value {
        Value::Object(map) => map.values().map(|v| count(v, is_wanted)).sum(),
        Value::Array(list) => list.iter().map(|v| count(v, is_wanted)).sum(),
        _ => 0,
    };
    inner + usize::from(is_wanted(value))
}

/// Applies `apply` to the value that is `left` wanted values behind this one; returns whether it was found.
fn visit(
    value: &mut Value,
    is_wanted: &dyn Fn(&Value) -> bool,
    left: &mut usize,
    apply: &mut dyn FnMut(&mut Value),
) -> bool {
    if is_wanted(value) {
        if *left == 0 {
            apply(value);
            return true;
        }
        *left -= 1;
    }
    match value {
        Value::Object(map) => map.values_mut().any(|v| visit(v, is_wanted, left, apply)),
        Value::Array(list) => list.iter_mut().any(|v| visit(v, is_wanted, left, apply)),
        _ => false,
    }
}

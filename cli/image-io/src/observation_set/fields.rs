//! Typed reading of JSON objects that collects all faults.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Fault;
use serde_json::{Map, Value};

/// A JSON object of a manifest, and the list of faults.
pub(super) struct Fields<'v, 'f> {
    object: &'v Map<String, Value>,
    /// Prefix of keys in messages, such as `camera.`.
    prefix: &'static str,
    observation: Option<usize>,
    file: String,
    faults: &'f mut Vec<Fault>,
}

impl<'v, 'f> Fields<'v, 'f> {
    /// Returns the fields of a JSON value; `None`, with a fault of `field`, if it is no object.
    pub(super) fn of_value(
        value: &'v Value,
        observation: Option<usize>,
        field: &str,
        faults: &'f mut Vec<Fault>,
    ) -> Option<Self> {
        let Some(object) = value.as_object() else {
            faults.push(Fault {
                observation,
                file: String::new(),
                field: field.to_owned(),
                problem: format!("is {}", abbreviated(value)),
                remedy: "give a JSON object".to_owned(),
            });
            return None;
        };
        let file = object.get("file").and_then(Value::as_str);
        Some(Self {
            object,
            prefix: "",
            observation,
            file: file.unwrap_or_default().to_owned(),
            faults,
        })
    }

    /// Returns the fields of an object within this one.
    pub(super) fn inside<'o>(
        &mut self,
        object: &'o Map<String, Value>,
        prefix: &'static str,
    ) -> Fields<'o, '_> {
        Fields {
            object,
            prefix,
            observation: self.observation,
            file: self.file.clone(),
            faults: self.faults,
        }
    }

    pub(super) fn fault(
        &mut self,
        key: &str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.faults.push(Fault {
            observation: self.observation,
            file: self.file.clone(),
            field: format!("{}{key}", self.prefix),
            problem: problem.into(),
            remedy: remedy.into(),
        });
    }

    /// Reports every key that is not in `known`.
    pub(super) fn check_keys(&mut self, known: &[&str]) {
        let object = self.object;
        for key in object.keys().filter(|key| !known.contains(&key.as_str())) {
            let remedy = format!("remove it, or use one of: {}", known.join(", "));
            self.fault(key, "is not a key of this format", remedy);
        }
    }

    pub(super) fn get(&self, key: &str) -> Option<&'v Value> {
        self.object.get(key)
    }

    /// Returns a required value.
    pub(super) fn required(&mut self, key: &str, what: &str) -> Option<&'v Value> {
        let value = self.get(key);
        if value.is_none() {
            self.fault(key, "is missing", format!("give {what}"));
        }
        value
    }

    /// Converts an optional value by `read`; reports a fault where that fails.
    pub(super) fn parsed<T>(
        &mut self,
        key: &str,
        remedy: &str,
        read: impl FnOnce(&'v Value) -> Option<T>,
    ) -> Option<T> {
        let value = self.get(key)?;
        let parsed = read(value);
        if parsed.is_none() {
            self.fault(key, format!("is {}", abbreviated(value)), remedy);
        }
        parsed
    }

    /// Converts a required value by `read`; reports a fault where that fails.
    pub(super) fn required_parsed<T>(
        &mut self,
        key: &str,
        what: &str,
        read: impl FnOnce(&'v Value) -> Option<T>,
    ) -> Option<T> {
        self.required(key, what)?;
        self.parsed(key, &format!("give {what}"), read)
    }

    /// Returns `value` as a finite number; otherwise reports a fault of `key`.
    pub(super) fn number_of(&mut self, key: &str, value: &Value, remedy: &str) -> Option<f64> {
        let number = finite(value);
        if number.is_none() {
            self.fault(key, format!("is {}", abbreviated(value)), remedy);
        }
        number
    }

    /// Returns a required number.
    pub(super) fn required_number(&mut self, key: &str, what: &str) -> Option<f64> {
        self.required_parsed(key, what, finite)
    }

    /// Returns an optional number.
    pub(super) fn number(&mut self, key: &str, what: &str) -> Option<f64> {
        self.parsed(key, &format!("give {what}, or leave it out"), finite)
    }

    /// Returns an optional number greater than zero.
    pub(super) fn positive(&mut self, key: &str, what: &str) -> Option<f64> {
        let number = self.number(key, what)?;
        if number <= 0.0 {
            self.fault(
                key,
                format!("is {number}"),
                format!("give {what} greater than zero, or leave it out"),
            );
            return None;
        }
        Some(number)
    }

    /// Returns a distance in metres: absent is unknown, null is infinity.
    pub(super) fn distance(&mut self, key: &str) -> ObjectDistance {
        const REMEDY: &str = "give metres greater than zero, null for infinity, or leave it out";
        let metres = match self.get(key) {
            None => None,
            Some(Value::Null) => return ObjectDistance::Infinity,
            Some(value) => self.number_of(key, value, REMEDY),
        };
        let distance = metres.map(ObjectDistance::metres).transpose();
        let distance = distance.map_err(|error| self.fault(key, error.problem, REMEDY));
        distance.ok().flatten().unwrap_or(ObjectDistance::Unknown)
    }
}

fn finite(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.is_finite())
}

/// Formats a JSON value for a message, abbreviated.
pub(super) fn abbreviated(value: &Value) -> String {
    match value {
        Value::Object(_) => "an object".to_owned(),
        Value::Array(items) => format!("a list of {}", items.len()),
        Value::String(text) => format!("the text {:?}", text.chars().take(40).collect::<String>()),
        other => other.to_string(),
    }
}

/// Puts NaN and infinities in quotes, so that the manifest parses and they are reported as faults of their fields.
///
/// JSON does not have them, but common writers write them. Quoted text is unchanged.
pub(super) fn quote_non_finite(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len());
    let mut rest = text;
    let mut in_string = false;
    while let Some(c) = rest.chars().next() {
        if !in_string
            && let Some(word) = ["-Infinity", "Infinity", "-NaN", "NaN", "-inf", "inf", "nan"]
                .into_iter()
                .find(|word| rest.starts_with(word))
        {
            quoted.push('"');
            quoted.push_str(word);
            quoted.push('"');
            rest = &rest[word.len()..];
            continue;
        }
        let mut length = c.len_utf8();
        if in_string && c == '\\' {
            // Includes the escaped character, so that \" does not end the string.
            length += rest[length..].chars().next().map_or(0, char::len_utf8);
        } else if c == '"' {
            in_string = !in_string;
        }
        quoted.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    quoted
}

/// Returns whether the name of a tile stays inside the folder of the set on every system.
pub(super) fn is_inside(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    let rooted = name.starts_with(['/', '\\']);
    let climbs = name.split(['/', '\\']).any(|part| part == "..");
    !name.is_empty() && !name.contains('\0') && !drive && !rooted && !climbs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_unquoted_words_are_quoted() {
        assert_eq!(
            quote_non_finite(r#"{"NaN \" NaN": NaN, "é": [-Infinity, 1]}"#),
            r#"{"NaN \" NaN": "NaN", "é": ["-Infinity", 1]}"#
        );
    }
}

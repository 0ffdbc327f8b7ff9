//! Typed reading of JSON objects that collects every fault instead of stopping at the first.

use seidel_core::Fault;
use serde_json::{Map, Value};

/// One JSON object of a manifest, and where to put the faults found in it.
pub(crate) struct Fields<'v, 'f> {
    object: &'v Map<String, Value>,
    /// Put before the key in messages, such as `camera.`.
    prefix: &'static str,
    observation: Option<usize>,
    file: String,
    faults: &'f mut Vec<Fault>,
}

impl<'v, 'f> Fields<'v, 'f> {
    pub(crate) fn new(
        object: &'v Map<String, Value>,
        prefix: &'static str,
        observation: Option<usize>,
        faults: &'f mut Vec<Fault>,
    ) -> Self {
        let file = object
            .get("file")
            .and_then(Value::as_str)
            .unwrap_or_default()
            .to_owned();
        Self {
            object,
            prefix,
            observation,
            file,
            faults,
        }
    }

    /// The fields of an object within this one.
    pub(crate) fn inside<'o>(
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

    pub(crate) fn fault(
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

    /// Refuses every key that is not in `known`.
    pub(crate) fn only(&mut self, known: &[&str]) {
        let object = self.object;
        for key in object.keys().filter(|key| !known.contains(&key.as_str())) {
            let remedy = format!("remove it, or use one of: {}", known.join(", "));
            self.fault(key, "is no key of this format", remedy);
        }
    }

    pub(crate) fn get(&self, key: &str) -> Option<&'v Value> {
        self.object.get(key)
    }

    /// A value that must be there.
    pub(crate) fn required(&mut self, key: &str, what: &str) -> Option<&'v Value> {
        let value = self.get(key);
        if value.is_none() {
            self.fault(key, "is missing", format!("give {what}"));
        }
        value
    }

    /// `value` as a finite number, or a fault of `key`.
    pub(crate) fn number_of(&mut self, key: &str, value: &Value, remedy: &str) -> Option<f64> {
        match value.as_f64().filter(|n| n.is_finite()) {
            Some(number) => Some(number),
            None => {
                self.fault(key, format!("is {}", shown(value)), remedy);
                None
            }
        }
    }

    /// A number that must be there.
    pub(crate) fn required_number(&mut self, key: &str, what: &str) -> Option<f64> {
        let value = self.required(key, what)?;
        self.number_of(key, value, &format!("give {what}"))
    }

    /// A number that may be left out.
    pub(crate) fn number(&mut self, key: &str, what: &str) -> Option<f64> {
        let value = self.get(key)?;
        self.number_of(key, value, &format!("give {what}, or leave it out"))
    }

    /// A number greater than zero that may be left out.
    pub(crate) fn positive(&mut self, key: &str, what: &str) -> Option<f64> {
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
}

/// A JSON value for a message, cut short.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::Object(_) => "an object".to_owned(),
        Value::Array(items) => format!("a list of {}", items.len()),
        Value::String(text) => format!("the text {:?}", text.chars().take(40).collect::<String>()),
        other => other.to_string(),
    }
}

/// Puts NaN and infinities, which JSON has not but common writers write, in quotes, so that they can
/// be reported where they stand. Text within quotes is left alone.
pub(crate) fn quote_non_finite(text: &str) -> String {
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
            // The escaped character goes along, so that \" does not end the string.
            length += rest[length..].chars().next().map_or(0, char::len_utf8);
        } else if c == '"' {
            in_string = !in_string;
        }
        quoted.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bare_words_are_quoted() {
        assert_eq!(
            quote_non_finite(r#"{"NaN \" NaN": NaN, "é": [-Infinity, 1]}"#),
            r#"{"NaN \" NaN": "NaN", "é": ["-Infinity", 1]}"#
        );
    }
}

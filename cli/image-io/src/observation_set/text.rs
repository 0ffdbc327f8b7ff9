//! The text of manifests, and the names in it.

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

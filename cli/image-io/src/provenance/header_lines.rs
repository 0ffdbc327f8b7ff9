//! Provenance as short lines, for headers that consist of lines.
//!
//! Each line of a text becomes a line `NAME=LINE`; the rest of a long one follows as `NAME+=REST`.

use crate::metadata::{TextAttributes, is_provenance};

/// Limit of the text in a line, bytes. Readers of HDR files accept lines of about 250.
const MAX_LINE_BYTES: usize = 160;

/// Returns the lines of all provenance among `texts`.
pub(crate) fn lines(texts: &TextAttributes) -> Vec<String> {
    let mut all = Vec::new();
    for (name, text) in texts.iter().filter(|(name, _)| is_provenance(name)) {
        for line in text.split('\n') {
            let line = line.replace('\\', "\\\\").replace('\r', "\\r");
            let mut current = format!("{name}=");
            let mut bytes = 0;
            for letter in line.chars() {
                bytes += letter.len_utf8();
                if bytes > MAX_LINE_BYTES {
                    all.push(std::mem::replace(&mut current, format!("{name}+=")));
                    bytes = letter.len_utf8();
                }
                current.push(letter);
            }
            all.push(current);
        }
    }
    all
}

/// Returns whether a line holds provenance.
pub(crate) fn is_provenance_line(line: &[u8]) -> bool {
    split(line).is_some()
}

/// Splits a line of provenance into name and text.
fn split(line: &[u8]) -> Option<(&str, &str)> {
    let (name, text) = std::str::from_utf8(line).ok()?.split_once('=')?;
    is_provenance(name).then_some((name, text))
}

/// Returns the provenance in `lines`.
pub(crate) fn texts<'a>(lines: impl Iterator<Item = &'a [u8]>) -> TextAttributes {
    let mut texts = TextAttributes::new();
    for (name, line) in lines.filter_map(split) {
        match (name.strip_suffix('+'), texts.last_mut()) {
            (Some(name), Some((last, text))) if last == name => text.push_str(line),
            (None, Some((last, text))) if last == name => {
                text.push('\n');
                text.push_str(line);
            }
            _ => texts.push((name.to_owned(), line.to_owned())),
        }
    }
    for (_, text) in &mut texts {
        *text = unescape(text);
    }
    texts
}

/// Reverts the escapes of backslashes and carriage returns.
fn unescape(text: &str) -> String {
    let mut unescaped = String::with_capacity(text.len());
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        unescaped.push(match letter {
            '\\' => match letters.next() {
                Some('r') => '\r',
                Some(other) => other,
                None => '\\',
            },
            letter => letter,
        });
    }
    unescaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_round_trip() {
        let named = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        let long = "\\ä".repeat(300);
        let own = vec![
            named("seidelCommand", r"a\nb \ c\\"),
            named("seidelLens", &long),
            named("seidelSettings", "amount: 1\n\nscale: =2\r\n"),
        ];
        let all = [own.clone(), vec![named("Author", "other")]].concat();
        let lines = lines(&all);
        assert!(
            lines
                .iter()
                .all(|line| !line.contains('\n') && line.len() < 200)
        );
        assert_eq!(texts(lines.iter().map(String::as_bytes)), own);
        assert!(
            !is_provenance_line(b"EXPOSURE=2")
                && !is_provenance_line(b"seidelVersion")
                && !is_provenance_line(b"\xff=\xff")
        );
    }
}

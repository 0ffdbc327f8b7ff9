//! Texts of ours as short lines, for formats whose headers are lines: `NAME=` with a line of the text, the next ones with
//! the same name, and `NAME+=` with what goes on in the same line.

use crate::provenance::{Texts, is_ours};

/// Bytes of text in a line: readers of HDR files take no more than some 250.
const MOST: usize = 160;

/// The lines of the texts that are ours.
pub(crate) fn lines(texts: &Texts) -> Vec<String> {
    let mut all = Vec::new();
    for (name, text) in texts.iter().filter(|(name, _)| is_ours(name)) {
        for line in text.split('\n') {
            let line = line.replace('\\', "\\\\").replace('\r', "\\r");
            let mut written = format!("{name}=");
            let mut bytes = 0;
            for letter in line.chars() {
                bytes += letter.len_utf8();
                if bytes > MOST {
                    all.push(std::mem::replace(&mut written, format!("{name}+=")));
                    bytes = letter.len_utf8();
                }
                written.push(letter);
            }
            all.push(written);
        }
    }
    all
}

/// Whether a line is of a text of ours.
pub(crate) fn is_own(line: &[u8]) -> bool {
    parts(line).is_some()
}

/// The name of a text, and a line of it.
fn parts(line: &[u8]) -> Option<(&str, &str)> {
    let parts = std::str::from_utf8(line).ok()?.split_once('=')?;
    is_ours(parts.0).then_some(parts)
}

/// The texts of ours among some lines.
pub(crate) fn texts<'a>(lines: impl Iterator<Item = &'a [u8]>) -> Texts {
    let mut texts = Texts::new();
    for (name, line) in lines.filter_map(parts) {
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
        *text = plain(text);
    }
    texts
}

/// A text as it was before its backslashes and carriage returns were marked.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        plain.push(match letter {
            '\\' => match letters.next() {
                Some('r') => '\r',
                Some(other) => other,
                None => '\\',
            },
            letter => letter,
        });
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_come_back_from_lines() {
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
        assert!(!is_own(b"EXPOSURE=2") && !is_own(b"seidelVersion") && !is_own(b"\xff=\xff"));
    }
}

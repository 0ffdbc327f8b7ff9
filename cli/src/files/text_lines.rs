//! Texts of ours as single lines, `NAME=TEXT`, for formats that hold lines.

use super::provenance::{Texts, is_ours};

/// A line a text of ours; ends of lines within a text are written as `\n`.
pub(super) fn lines(texts: &Texts) -> Vec<String> {
    let own = texts.iter().filter(|(name, _)| is_ours(name));
    own.map(|(name, text)| {
        let text = text.replace('\\', "\\\\").replace('\n', "\\n");
        format!("{name}={}", text.replace('\r', "\\r"))
    })
    .collect()
}

/// The text that a line is, if it is one of ours.
pub(super) fn text(line: &[u8]) -> Option<(String, String)> {
    let (name, text) = std::str::from_utf8(line).ok()?.split_once('=')?;
    if !is_ours(name) {
        return None;
    }
    let mut plain = String::with_capacity(text.len());
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        plain.push(match letter {
            '\\' => match letters.next() {
                Some('n') => '\n',
                Some('r') => '\r',
                Some(other) => other,
                None => '\\',
            },
            letter => letter,
        });
    }
    Some((name.to_owned(), plain))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_come_back_from_lines() {
        let named = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        let texts = vec![
            named("seidelCommand", r"a\nb \ c\\"),
            named("seidelSettings", "amount: 1\nscale: =2\r\n"),
        ];
        let all = [texts.clone(), vec![named("Author", "other")]].concat();
        let lines = lines(&all);
        assert!(lines.iter().all(|line| !line.contains('\n')));
        let back: Texts = lines
            .iter()
            .filter_map(|line| text(line.as_bytes()))
            .collect();
        assert_eq!(back, texts);
        assert_eq!(text(b"EXPOSURE=2"), None);
        assert_eq!(text(b"seidelVersion"), None);
        assert_eq!(text(b"\xff=\xff"), None);
    }
}

//! Paths in provenance texts: whole, or by the names of files alone.

/// Options whose values are names of spaces, views or layers, which may contain slashes.
const NAMED_VALUES: [&str; 5] = [
    "--in-space",
    "--out-space",
    "--working-space",
    "--view",
    "--layer",
];

/// Separator of scheme and name in names that are no paths, such as `ocio://cg-config-latest`.
const SCHEME: &str = "://";

/// Returns a word without the folders of the path in it, if there is one: `a/b.exr` as `b.exr`, `--lens=a/b` as `--lens=b`.
pub(super) fn without_folders(word: &str) -> String {
    let (option, value) = match word.split_once('=') {
        Some((option, value)) if option.starts_with('-') => (Some(option), value),
        _ => (None, word),
    };
    if value.contains(SCHEME) || option.is_some_and(|option| NAMED_VALUES.contains(&option)) {
        return word.to_owned();
    }
    // A folder may end with a separator.
    let whole = value.trim_end_matches(['/', '\\']);
    let name = whole.rsplit(['/', '\\']).next().unwrap_or(whole);
    if name.is_empty() {
        return word.to_owned();
    }
    match option {
        Some(option) => format!("{option}={name}"),
        None => name.to_owned(),
    }
}

/// Returns the words of a command line without the folders of paths.
pub(super) fn words_without_folders(words: &[String]) -> Vec<String> {
    let before = std::iter::once("").chain(words.iter().map(String::as_str));
    let pairs = words.iter().zip(before);
    let short = pairs.map(|(word, before)| {
        if NAMED_VALUES.contains(&before) {
            word.clone()
        } else {
            without_folders(word)
        }
    });
    short.collect()
}

/// Returns a text of shell-quoted words, such as a command in a history, without the folders of paths.
pub(super) fn text_without_folders(text: &str) -> String {
    let mut short = String::with_capacity(text.len());
    let mut before = "";
    for word in raw_words(text) {
        let content = unquoted(word);
        let name = if NAMED_VALUES.contains(&before) {
            content.clone()
        } else {
            without_folders(&content)
        };
        if name == content {
            short.push_str(word);
        } else {
            short.push_str(&super::shell_quoted(&name));
        }
        if !word.trim().is_empty() {
            before = word;
        }
    }
    short
}

/// Cuts a text into words, with their quotes, and the white space between them.
fn raw_words(text: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let (mut start, mut in_quotes, mut is_escaped) = (0, false, false);
    let mut in_space = text.starts_with(char::is_whitespace);
    for (at, c) in text.char_indices() {
        let is_space = c.is_whitespace() && !in_quotes && !is_escaped;
        if is_space != in_space {
            words.push(&text[start..at]);
            (start, in_space) = (at, is_space);
        }
        if c == '\'' && !is_escaped {
            in_quotes = !in_quotes;
        }
        is_escaped = c == '\\' && !in_quotes && !is_escaped;
    }
    words.push(&text[start..]);
    words
}

/// Returns a word without its quotes.
fn unquoted(word: &str) -> String {
    let mut content = String::with_capacity(word.len());
    let mut in_quotes = false;
    let mut chars = word.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '\'' => in_quotes = !in_quotes,
            '\\' if !in_quotes && chars.peek() == Some(&'\'') => content.extend(chars.next()),
            c => content.push(c),
        }
    }
    content
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_keep_the_names_of_files_alone() {
        for (word, short) in [
            ("/show/sh 010/plate.%04d.exr", "plate.%04d.exr"),
            ("plate.exr", "plate.exr"),
            ("../out/", "out"),
            (r"C:\show\plate.exr", "plate.exr"),
            ("--depth=/show/z.exr:Z", "--depth=z.exr:Z"),
            ("--in-space=Input/ARRI", "--in-space=Input/ARRI"),
            ("ocio://cg-config-latest", "ocio://cg-config-latest"),
            ("--amount=0.5", "--amount=0.5"),
            ("", ""),
            ("/", "/"),
        ] {
            assert_eq!(without_folders(word), short);
        }
        let words = ["lut", "a/b.exr", "--view", "sRGB/ACES", "-o", "c/d.exr"];
        let words = words.map(str::to_owned);
        let short = ["lut", "b.exr", "--view", "sRGB/ACES", "-o", "d.exr"];
        assert_eq!(words_without_folders(&words), short);
    }

    #[test]
    fn texts_of_quoted_words_lose_folders_and_nothing_else() {
        let text = "0.1.0: seidel apply '/a b/it'\\''s c.exr' -o x/y.exr --view d/e [l.json sha256:ab]\n0.1.0: seidel";
        let short = "0.1.0: seidel apply 'it'\\''s c.exr' -o y.exr --view d/e [l.json sha256:ab]\n0.1.0: seidel";
        assert_eq!(text_without_folders(text), short);
        for plain in ["", " ", "a  b\n c", "it'", "\\"] {
            assert_eq!(text_without_folders(plain).len(), plain.len());
        }
    }
}

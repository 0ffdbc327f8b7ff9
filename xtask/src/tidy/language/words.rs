//! Words: the phrases of `words.txt`, and the first words of doc comments.

use super::Finding;

/// A phrase to avoid.
pub(super) struct Phrase {
    /// Its words in small letters. A `*` stands for any one word.
    words: Vec<&'static str>,
    /// Suggested replacement.
    instead: &'static str,
}

/// Words that open a question, or a clause without a main verb.
const OPENINGS: [&str; 8] = [
    "What",
    "How",
    "Of what",
    "By how much",
    "By which",
    "By what",
    "Where",
    "Which",
];

/// Returns the phrases of `words.txt`.
pub(super) fn phrases() -> Vec<Phrase> {
    let lines = include_str!("words.txt").lines();
    let phrase = |line: &'static str| {
        let (find, instead) = line.split_once(" / ")?;
        Some(Phrase {
            words: find.split_whitespace().collect(),
            instead,
        })
    };
    lines.filter_map(phrase).collect()
}

/// Looks for `phrases` in every line of a Rust file or document, code blocks excepted.
///
/// Words between backquotes are names of other programs or files. A name such as `is_none` is one word.
pub(super) fn check(text: &str, phrases: &[Phrase], found: &mut Vec<Finding>) {
    let is_mark = |c: char| !c.is_alphanumeric() && !['`', '\'', '_'].contains(&c);
    let mut is_code = false;
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        }
        if is_code {
            continue;
        }
        let prose: Vec<&str> = line.split('`').step_by(2).collect();
        let lower = prose.join(" ` ").to_lowercase();
        let words: Vec<&str> = lower.split(is_mark).filter(|w| !w.is_empty()).collect();
        for phrase in phrases {
            let is_phrase = |words: &[&str]| {
                let mut pairs = phrase.words.iter().zip(words);
                pairs.all(|(own, word)| *own == "*" || own == word)
            };
            if words.windows(phrase.words.len()).any(is_phrase) {
                let (phrase, instead) = (phrase.words.join(" "), phrase.instead);
                found.push(Finding {
                    line: index + 1,
                    message: format!("`{phrase}`; write for example: {instead}"),
                });
            }
        }
    }
}

/// Looks for doc comments that open like a question and are none.
pub(super) fn check_openings(text: &str, found: &mut Vec<Finding>) {
    let doc = |line: &str| {
        let line = line.trim_start();
        (line.strip_prefix("///").or(line.strip_prefix("//!"))).map(|doc| doc.trim().to_owned())
    };
    let mut previous = None;
    for (index, line) in text.lines().enumerate() {
        let doc = doc(line);
        if let (None, Some(doc)) = (previous, &doc)
            && let Some(opening) = OPENINGS.into_iter().find(|opening| {
                let rest = doc.strip_prefix(opening);
                rest.is_some_and(|rest| rest.starts_with([' ', ',', ':']) && !rest.contains('?'))
            })
        {
            found.push(Finding {
                line: index + 1,
                message: format!("opens with `{opening}`; open with a noun phrase or a verb"),
            });
        }
        previous = doc;
    }
}

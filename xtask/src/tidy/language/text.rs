//! Text: comments, string literals and documents.

use super::words::Words;
use super::{Finding, Rule};

/// The kind of value that a doc comment describes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Described {
    /// A `bool` or several, or a function that returns them: its comment may open with "Whether".
    Bool,
    Other,
}

/// Words that open a question, or a clause without a main verb.
const OPENINGS: [&str; 9] = [
    "What",
    "How",
    "Of what",
    "By how much",
    "By which",
    "By what",
    "Where",
    "Whether",
    "Which",
];

/// Looks for phrases in a Markdown document, code blocks excepted.
pub(super) fn check_document(text: &str, words: &Words, found: &mut Vec<Finding>) {
    let mut is_code = false;
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            check_phrases(line, index + 1, words, found);
        }
    }
}

/// Looks for phrases in the comments of a Rust file.
pub(super) fn check_comments(text: &str, words: &Words, found: &mut Vec<Finding>) {
    for (index, line) in text.lines().enumerate() {
        if let Some(comment) = comment(line) {
            check_phrases(comment, index + 1, words, found);
        }
    }
}

/// The comment of a line: the whole line, or what follows ` // ` after code.
fn comment(line: &str) -> Option<&str> {
    let trimmed = line.trim_start();
    if trimmed.starts_with("//") {
        return Some(trimmed.trim_start_matches(['/', '!']));
    }
    let (code, comment) = line.rsplit_once(" // ")?;
    (code.matches('"').count() % 2 == 0).then_some(comment)
}

/// A format string without its placeholders, which are names and not text.
pub(super) fn without_placeholders(text: &str) -> String {
    let mut is_inside = false;
    let mut prose = String::new();
    for c in text.chars() {
        match c {
            '{' => is_inside = true,
            '}' => is_inside = false,
            c if !is_inside => prose.push(c),
            _ => {}
        }
    }
    prose
}

/// Looks for phrases in one line of text. Words between backquotes are names, not text; a name such as `is_none` is one
/// word.
pub(super) fn check_phrases(line: &str, number: usize, words: &Words, found: &mut Vec<Finding>) {
    let prose: Vec<&str> = line.split('`').step_by(2).collect();
    let lower = prose.join(" ` ").to_lowercase();
    let is_mark = |c: char| !c.is_alphanumeric() && !['`', '\'', '_'].contains(&c);
    let tokens: Vec<&str> = lower
        .split(is_mark)
        .filter(|word| !word.is_empty())
        .collect();
    let mut at = 0;
    while at < tokens.len() {
        let rest = &tokens[at..];
        let longest = (words.phrases.iter())
            .filter(|entry| entry.matches_start(rest))
            .max_by_key(|entry| entry.words.len());
        let Some(entry) = longest else {
            at += 1;
            continue;
        };
        let phrase = rest[..entry.words.len()].join(" ");
        found.push(Finding {
            rule: Rule::Phrase,
            line: number,
            message: entry.message(&phrase),
        });
        at += entry.words.len();
    }
}

/// The word or words that a doc comment should not open with.
///
/// A question is allowed, and "Whether" for a `bool`.
pub(super) fn bad_opening(doc: &str, described: Described) -> Option<&'static str> {
    let doc = doc.trim_start();
    let opening = OPENINGS.into_iter().find(|opening| {
        let rest = doc.strip_prefix(opening);
        rest.is_some_and(|rest| rest.starts_with([' ', ',', ':']))
    })?;
    let sentence = doc.split(['.', '?']).next().unwrap_or("");
    let is_question = doc[sentence.len()..].starts_with('?');
    let is_allowed = is_question || (opening == "Whether" && described == Described::Bool);
    (!is_allowed).then_some(opening)
}

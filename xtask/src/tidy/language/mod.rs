//! The language rules, as far as a program can check them: doc comments that open like a question, words with a plainer
//! equivalent, and signatures that hide what their values mean.

mod names;
mod signatures;
mod syntax;
mod text;
mod words;

use crate::workspace::{TextFile, Tree};

use words::Words;

/// A language rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// A doc comment opens with What, How, Where and the like and is no question.
    Opening,
    /// A name of `words.txt`.
    Name,
    /// A phrase of `words.txt`.
    Phrase,
    /// A tuple of three or more values in a signature that another module calls.
    Tuple,
    /// A parameter that destructures a tuple.
    Pattern,
    /// A bare `bool` parameter of a function that another module calls.
    Bool,
    /// A `match` on a `bool`.
    Match,
    /// A file of tests that is not called `tests.rs`.
    TestFile,
}

impl Rule {
    /// Its name in reports.
    fn name(self) -> &'static str {
        match self {
            Self::Opening => "opening",
            Self::Name => "name",
            Self::Phrase => "phrase",
            Self::Tuple => "tuple",
            Self::Pattern => "pattern",
            Self::Bool => "bool",
            Self::Match => "match",
            Self::TestFile => "testfile",
        }
    }
}

/// The folder of this check, which contains every word that it looks for.
const OWN_FOLDER: &str = "xtask/src/tidy/language/";

/// A breach of a language rule.
struct Finding {
    rule: Rule,
    line: usize,
    message: String,
}

/// Adds every breach of a language rule to `problems`.
pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    let words = Words::read();
    let files = tree
        .files()
        .filter(|file| !file.path.starts_with(OWN_FOLDER));
    for file in files {
        let findings = findings_of(file, &words);
        problems.extend(findings.iter().map(|finding| listing(file, finding)));
    }
}

fn findings_of(file: &TextFile, words: &Words) -> Vec<Finding> {
    let mut found = Vec::new();
    if file.path.ends_with(".rs") {
        if let Some(name) =
            (file.path.rsplit('/').next()).filter(|name| name.ends_with("_tests.rs"))
        {
            found.push(Finding {
                rule: Rule::TestFile,
                line: 1,
                message: format!("{name}: tests of a module x are in x/tests.rs"),
            });
        }
        syntax::check(&file.text, words, &mut found);
    } else if file.path.ends_with(".md") {
        text::check_document(&file.text, words, &mut found);
    }
    found.sort_by_key(|finding| finding.line);
    found
}

fn listing(file: &TextFile, finding: &Finding) -> String {
    let (path, line, rule) = (&file.path, finding.line, finding.rule.name());
    format!("{path}:{line}: {rule}: {}", finding.message)
}

#[cfg(test)]
mod tests;

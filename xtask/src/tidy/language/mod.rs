//! The language rules, as far as a program can check them: doc comments that open like a question, words with a plainer
//! equivalent, and signatures that hide what their values mean.

mod names;
mod signatures;
mod syntax;
mod text;
mod words;

use std::collections::BTreeMap;

use crate::workspace::{TextFile, Tree};

use words::Words;

/// A language rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// Every rule.
const ALL: [Rule; 8] = [
    Rule::Opening,
    Rule::Name,
    Rule::Phrase,
    Rule::Tuple,
    Rule::Pattern,
    Rule::Bool,
    Rule::Match,
    Rule::TestFile,
];

/// Folders whose language is still being revised: `cargo xtask tidy --language` lists their breaches, and
/// `cargo xtask tidy` accepts them.
const UNREVISED: [&str; 1] = ["ofx-shim/"];

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

/// Breaches outside the folders that are being revised.
pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    for (file, finding) in findings(tree, "") {
        let is_unrevised = UNREVISED.iter().any(|folder| file.path.starts_with(folder));
        if !is_unrevised {
            problems.push(listing(file, &finding));
        }
    }
}

/// Counts by folder and rule, or with `start` every breach in files whose path begins with it.
pub(super) fn report(tree: &Tree, start: Option<String>) -> String {
    if let Some(start) = start {
        let lines = findings(tree, &start).map(|(file, finding)| listing(file, &finding));
        return lines.collect::<Vec<_>>().join("\n");
    }
    let mut counts = BTreeMap::<String, [usize; ALL.len()]>::new();
    for (file, finding) in findings(tree, "") {
        for folder in [folder(&file.path), "total".to_owned()] {
            let row = counts.entry(folder).or_default();
            row[finding.rule as usize] += 1;
        }
    }
    table(&counts)
}

fn findings<'a>(tree: &'a Tree, start: &str) -> impl Iterator<Item = (&'a TextFile, Finding)> {
    let words = Words::read();
    let files = tree
        .files()
        .filter(move |file| file.path.starts_with(start) && !file.path.starts_with(OWN_FOLDER));
    files.flat_map(move |file| {
        let found = findings_of(file, &words).into_iter();
        found.map(move |finding| (file, finding))
    })
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

/// The folder of a path, at most three levels deep.
fn folder(path: &str) -> String {
    let parts: Vec<&str> = path.split('/').collect();
    let depth = (parts.len() - 1).min(3);
    if depth == 0 {
        ".".to_owned()
    } else {
        parts[..depth].join("/")
    }
}

fn table(counts: &BTreeMap<String, [usize; ALL.len()]>) -> String {
    let row = |folder: &str, cells: Vec<String>| {
        let cells: String = cells.iter().map(|cell| format!("{cell:>9}")).collect();
        format!("{folder:<36}{cells}")
    };
    let heads = ALL.map(|rule| rule.name().to_owned()).to_vec();
    let mut lines = vec![row("folder", heads)];
    for (folder, counts) in counts {
        lines.push(row(folder, counts.map(|count| count.to_string()).to_vec()));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests;

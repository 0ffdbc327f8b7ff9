//! The language rules that neither rustc nor Clippy knows: words with a plainer equivalent, doc comments that open like a
//! question, and signatures that hide what their values mean.

mod signatures;
mod words;

use crate::workspace::{TextFile, Tree};

/// The folder of this check, which contains every word that it looks for.
const OWN_FOLDER: &str = "xtask/src/tidy/language/";

/// A breach of a language rule.
struct Finding {
    line: usize,
    message: String,
}

/// Adds every breach of a language rule to `problems`.
pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    let phrases = words::phrases();
    let others = |file: &&TextFile| !file.path.starts_with(OWN_FOLDER);
    for file in tree.files().filter(others) {
        let mut found = Vec::new();
        if file.path.ends_with(".rs") {
            words::check(&file.text, &phrases, &mut found);
            words::check_openings(&file.text, &mut found);
            signatures::check(&file.text, &mut found);
        } else if file.path.ends_with(".md") {
            words::check(&file.text, &phrases, &mut found);
        }
        let listing =
            |finding: Finding| format!("{}:{}: {}", file.path, finding.line, finding.message);
        problems.extend(found.into_iter().map(listing));
    }
}

#[cfg(test)]
mod tests;

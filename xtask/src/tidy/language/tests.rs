//! Tests of the language rules.

use super::*;

/// Messages about the text of a file.
fn problems(path: &str, text: &str) -> Vec<String> {
    let mut problems = Vec::new();
    check(&Tree::of(&[(path, text)]), &mut problems);
    problems
}

/// Checks that every text of `bad` has one breach, whose message contains `part`, and that no text of `good` has any.
fn expect(part: &str, bad: &[&str], good: &[&str]) {
    for text in bad {
        let found = problems("a.rs", text);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert!(found[0].contains(part), "{text}: {found:?}");
    }
    for text in good {
        assert_eq!(problems("a.rs", text), [""; 0], "{text}");
    }
}

#[test]
fn doc_comments_that_open_like_a_question_are_found() {
    expect(
        "opens with",
        &[
            "//! What it holds.",
            "/// How far it goes.\nfn f() {}",
            "enum E {\n    /// By how much it\n    /// differs.\n    A,\n}",
        ],
        &[
            "/// What is it? A lens.\nfn f() {}",
            "/// Returns\n/// What it holds.\nfn f() {}",
            "/// Whatever comes.\nfn f() {}",
            "// What is that for.\nfn f() {}",
        ],
    );
}

#[test]
fn phrases_are_found_in_comments_names_strings_and_documents() {
    expect(
        "write for example",
        &[
            "struct Seen;",
            "fn told() {}",
            "fn f() {\n    let said = 1;\n}",
            "// It is told by the noise.",
            "/// Reads a file that is none.\nfn f() {}",
            "fn f() {\n    g(); // had back\n}",
            "fn f() -> String {\n    format!(\"{} is said\", 1)\n}",
        ],
        &[
            "fn unseen() {}",
            "fn f() {\n    let seen = 1;\n}",
            "// A tolde word.\nfn f() { g(\"retold, is_told\") }",
        ],
    );
    let two = "A word of `told` here.\nTold.\n```\ntold\n```\n";
    assert_eq!(problems("a.md", two).len(), 1);
    assert_eq!(problems("a.txt", two), [""; 0]);
}

#[test]
fn signatures_that_hide_meaning_are_found() {
    expect(
        "tuple",
        &[
            "pub fn f() -> (u8, u8, u8) {}",
            "pub(crate) fn f(a: &[(u8, u8, u8)]) {}",
        ],
        &["fn f() -> (u8, u8, u8) {}", "pub fn f() -> (u8, u8) {}"],
    );
    expect(
        "bool",
        &[
            "impl S {\n    pub fn f(&self, exact: bool) {}\n}",
            "trait T {\n    fn f(&self, exact: bool);\n}",
        ],
        &[
            "impl S {\n    pub fn with_exact(self, exact: bool) -> Self {}\n}",
            "pub fn expect(condition: bool) {}",
            "pub extern \"C\" fn f(exact: bool) {}",
            "fn f(exact: bool) {}",
        ],
    );
}

#[test]
fn breaches_are_listed_with_file_and_line() {
    let found = problems("core/src/fit/a.rs", "struct A;\nstruct Seen;");
    assert!(
        found[0].starts_with("core/src/fit/a.rs:2: `struct seen`"),
        "{found:?}"
    );
}

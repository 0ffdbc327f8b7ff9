//! Tests of the language rules.

use super::*;

/// Rules that the text of a file breaks, in order of lines.
fn broken_rules(path: &str, text: &str) -> Vec<Rule> {
    let tree = Tree::of(&[(path, text)]);
    let words = Words::read();
    let files = tree.files();
    files
        .flat_map(|file| findings_of(file, &words))
        .map(|finding| finding.rule)
        .collect()
}

fn broken_in_rust(text: &str) -> Vec<Rule> {
    broken_rules("a.rs", text)
}

#[test]
fn doc_comments_that_open_like_a_question_are_found() {
    for text in [
        "//! What it holds.",
        "/// How far it goes.\nfn f() {}",
        "struct S {\n    /// Whether there are any.\n    count: usize,\n}",
        "/// Whether there are any.\nfn count() -> usize {}",
        "enum E {\n    /// By how much it\n    /// differs.\n    A,\n}",
    ] {
        assert_eq!(broken_in_rust(text), [Rule::Opening], "{text}");
    }
    for text in [
        "/// What is it? A lens.\nfn f() {}",
        "/// Returns what it holds.\nfn f() {}",
        "/// Whatever comes.\nfn f() {}",
        "// What is that for.\nfn f() {}",
        "struct S {\n    /// Whether there are any.\n    exists: bool,\n}",
        "struct S {\n    /// Whether each tile is lit.\n    lit: Vec<bool>,\n}",
        "trait T {\n    /// Whether there are any.\n    fn exists(&self) -> bool;\n}",
    ] {
        assert_eq!(broken_in_rust(text), [], "{text}");
    }
}

#[test]
fn names_are_found_where_they_are_defined() {
    for text in [
        "struct Seen;",
        "fn told() {}",
        "fn f() {\n    let said = 1;\n}",
        "struct S {\n    plates_told: u8,\n}",
        "const WITNESSES: u8 = 1;",
        "mod given;",
        "fn f(told: u8) {}",
    ] {
        assert_eq!(broken_in_rust(text), [Rule::Name], "{text}");
    }
    for text in [
        "fn unseen() {}",
        "fn f() {\n    let given = 1;\n}",
        "fn retold() {}",
    ] {
        assert_eq!(broken_in_rust(text), [], "{text}");
    }
}

#[test]
fn phrases_are_found_in_comments_strings_and_documents() {
    for text in [
        "// It is told by the noise.",
        "/// Reads a file that is none.\nfn f() {}",
        "fn f() {\n    g(); // had back\n}",
        "fn f() -> String {\n    format!(\"{} is said\", 1)\n}",
    ] {
        assert_eq!(broken_in_rust(text), [Rule::Phrase], "{text}");
    }
    let two = "A word of `told` here.\nTold.\n```\ntold\n```\n";
    assert_eq!(broken_rules("a.md", two), [Rule::Phrase]);
    assert_eq!(broken_rules("a.txt", two), []);
    let placeholder = "fn f() -> String {\n    format!(\"{told}\")\n}";
    assert_eq!(broken_in_rust(placeholder), []);
    assert_eq!(
        broken_in_rust("// A tolde word.\nfn f() { g(\"retold, is_told\") }"),
        []
    );
}

#[test]
fn signatures_that_hide_meaning_are_found() {
    for (text, rule) in [
        ("pub fn f() -> (u8, u8, u8) {}", Rule::Tuple),
        ("pub(crate) fn f(a: &[(u8, u8, u8)]) {}", Rule::Tuple),
        ("fn f((a, b): (u8, u8)) {}", Rule::Pattern),
        ("fn f(&(a, b): &(u8, u8)) {}", Rule::Pattern),
        (
            "impl S {\n    pub fn f(&self, exact: bool) {}\n}",
            Rule::Bool,
        ),
        ("trait T {\n    fn f(&self, exact: bool);\n}", Rule::Bool),
        (
            "fn f(a: bool) -> u8 {\n    match a {\n        true => 1,\n        false => 2,\n    }\n}",
            Rule::Match,
        ),
    ] {
        assert_eq!(broken_in_rust(text), [rule], "{text}");
    }
    for text in [
        "fn f() -> (u8, u8, u8) {}",
        "pub fn f() -> (u8, u8) {}",
        "impl S {\n    pub fn with_exact(self, exact: bool) -> Self {}\n}",
        "pub fn expect(condition: bool) {}",
        "pub extern \"C\" fn f(exact: bool) {}",
        "fn f(exact: bool) {}",
        "fn f(a: (bool, bool)) -> u8 {\n    match a {\n        (true, _) => 1,\n        _ => 2,\n    }\n}",
    ] {
        assert_eq!(broken_in_rust(text), [], "{text}");
    }
}

#[test]
fn test_files_are_called_tests() {
    assert_eq!(broken_rules("a/x_tests.rs", "//! Tests."), [Rule::TestFile]);
    assert_eq!(broken_rules("a/x/tests.rs", "//! Tests."), []);
}

#[test]
fn parts_of_names_are_parted_at_underscores_and_capitals() {
    for name in ["tile_data", "TileData", "TILE_DATA"] {
        assert_eq!(names::parts(name), ["tile", "data"], "{name}");
    }
}

#[test]
fn breaches_are_listed_with_file_line_and_rule() {
    let tree = Tree::of(&[("core/src/fit/a.rs", "struct A;\nstruct Seen;")]);
    let mut problems = Vec::new();
    check(&tree, &mut problems);
    assert_eq!(problems.len(), 1);
    assert!(
        problems[0].starts_with("core/src/fit/a.rs:2: name: `Seen`"),
        "{problems:?}"
    );
}

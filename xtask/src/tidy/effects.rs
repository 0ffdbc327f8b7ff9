//! An effect is one file: its page has a row for it, and no other file of the product knows it by its identifier.

use super::registries::{find_list, implementations};
use crate::workspace::{TextFile, Tree};

/// Packages of the product.
const PRODUCT: [&str; 5] = ["core/", "cli/", "plugin/", "ofx-shim/", "python/"];

/// Identifiers that name something else in these files: a series of lens profiles, a knob of looks, and a look.
const OTHER_MEANINGS: [(&str, &str); 6] = [
    ("core/optics/src/profile/pupil.rs", "distortion"),
    ("ofx-shim/src/lens/built_in.rs", "distortion"),
    ("core/optics/src/profile/look.rs", "obstruction"),
    ("core/src/knobs/look.rs", "obstruction"),
    ("core/src/knobs/preset.rs", "obstruction"),
    ("core/src/knobs/preset.rs", "anamorphic"),
];

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    let Some((list, _)) = find_list(tree, "effects") else {
        return;
    };
    let folder = list.path.trim_end_matches("mod.rs");
    let effects = tree.rust_files(folder);
    let effects = effects.filter(|file| implementations(file, &["Effect"]).next().is_some());
    let ids: Vec<&str> = effects
        .map(|file| file.path[folder.len()..].trim_end_matches(".rs"))
        .collect();
    check_page(tree, &ids, problems);
    for file in tree.rust_files("").filter(|file| is_product(file)) {
        if file.path.starts_with(folder) {
            continue;
        }
        let code = file.text.split("#[cfg(test)]\nmod tests {").next();
        for id in &ids {
            let is_named = code.is_some_and(|code| code.contains(&format!("\"{id}\"")));
            if is_named && !OTHER_MEANINGS.contains(&(&file.path, id)) {
                problems.push(format!(
                    "{}: names the effect \"{id}\"; let the effect's own file say what is to know of it",
                    file.path
                ));
            }
        }
    }
}

/// Whether `file` is code of the product; `tests.rs` and `samples.rs` are modules of tests.
fn is_product(file: &TextFile) -> bool {
    let path = &file.path;
    let is_test = path.contains("/tests/") || path.ends_with("/tests.rs");
    let is_code = path.contains("/src/") && !is_test && !path.ends_with("/samples.rs");
    is_code && PRODUCT.iter().any(|package| path.starts_with(package))
}

/// Every effect has a row in both tables of its page: what it does, and its parameters.
fn check_page(tree: &Tree, ids: &[&str], problems: &mut Vec<String>) {
    let Some(page) = tree.files().find(|file| file.path.ends_with("/effects.md")) else {
        problems.push("no page effects.md under docs/".to_owned());
        return;
    };
    for id in ids {
        if page.text.matches(&format!("\n| `{id}` |")).count() != 2 {
            problems.push(format!("{}: lacks a row for the effect `{id}`", page.path));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_known_elsewhere_are_found() {
        let tree = Tree::of(&[
            (
                "core/src/effects/mod.rs",
                "pub static ALL: &[&dyn Effect] = &[\n    &Fog,\n];",
            ),
            (
                "core/src/effects/fog.rs",
                "impl Effect for Fog {\n    id: \"fog\"",
            ),
            (
                "docs/effects.md",
                "\n| `fog` | haze |\n| `fog` | `density` |",
            ),
            ("core/src/words.rs", "match id {\n    \"fog\" => 1,"),
            (
                "core/src/tested.rs",
                "fn f() {}\n#[cfg(test)]\nmod tests {\n    \"fog\"",
            ),
            ("core/src/words/tests.rs", "\"fog\""),
            ("instruments/trial/src/fog.rs", "\"fog\""),
        ]);
        let mut problems = Vec::new();
        check(&tree, &mut problems);
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert!(problems[0].starts_with("core/src/words.rs"), "{problems:?}");
    }
}

//! The project's rules, and a message for each breach.

mod c_abi;
mod dependencies;
mod effects;
mod files;
mod language;
mod modules;
mod purity;
mod registries;

use std::path::Path;

use crate::knobs;
use crate::pictures;
use crate::workspace::Tree;

/// Runs `cargo xtask tidy`.
///
/// # Errors
/// Every breach, one a line.
pub(crate) fn run(root: &Path) -> Result<String, String> {
    let problems = problems(root);
    if problems.is_empty() {
        Ok("tidy: every rule is kept".to_owned())
    } else {
        Err(problems.join("\ntidy: "))
    }
}

/// Every breach of a rule.
fn problems(root: &Path) -> Vec<String> {
    let tree = Tree::read(root);
    let mut problems = check_packages(&tree);
    files::check(&tree, &mut problems);
    registries::check(&tree, &mut problems);
    effects::check(&tree, &mut problems);
    c_abi::check_header(root, &tree, &mut problems);
    check_knobs(&tree, &mut problems);
    pictures::check(&tree, &mut problems);
    language::check(&tree, &mut problems);
    problems
}

/// Checks that the files that follow from the table of knobs are up to date.
fn check_knobs(tree: &Tree, problems: &mut Vec<String>) {
    for (path, text) in knobs::files() {
        if text != tree.text(path) {
            problems.push(format!("{path}: is out of date; run `cargo xtask knobs`"));
        }
    }
}

/// Breaches of the rules about packages.
fn check_packages(tree: &Tree) -> Vec<String> {
    let packages = match tree.packages() {
        Ok(packages) => packages,
        Err(problem) => return vec![problem],
    };
    let mut problems = Vec::new();
    dependencies::check(tree, &packages, &mut problems);
    files::check_map(tree, &packages, &mut problems);
    modules::check(tree, &packages, &mut problems);
    purity::check(tree, &packages, &mut problems);
    c_abi::check_guards(tree, &packages, &mut problems);
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_project_keeps_its_rules() {
        let problems = problems(&crate::workspace::root());
        assert!(problems.is_empty(), "{}", problems.join("\n"));
    }

    #[test]
    fn breaches_are_found() {
        let tree = Tree::of(&[
            (
                "Cargo.toml",
                "[workspace]\nmembers = [\"core\", \"core/optics\", \"cli\", \"plugin\"]",
            ),
            (
                "core/Cargo.toml",
                "[package]\nname = \"seidel-core\"\n[dependencies]\nseidel.workspace = true\n",
            ),
            (
                "core/optics/Cargo.toml",
                "[package]\nname = \"seidel-unlisted\"\n",
            ),
            ("core/optics/src/lib.rs", "fn f() { std::fs::read(\"x\"); }"),
            ("cli/Cargo.toml", "[package]\nname = \"seidel\"\n"),
            ("cli/src/lib.rs", "mod commands;"),
            ("cli/src/commands/mod.rs", "mod fit;"),
            (
                "cli/src/commands/fit.rs",
                "use std::fs::File;\nfn f() { File::open(\"x\"); }",
            ),
            ("cli/src/commands/lost.rs", "//! Lost."),
            ("plugin/Cargo.toml", "[package]\nname = \"seidel-plugin\"\n"),
            (
                "plugin/src/open.rs",
                "#[unsafe(no_mangle)]\npub extern \"C\" fn closed() {\n    crate::guard::guard(|| 1)\n}\n\
                 #[unsafe(no_mangle)]\npub extern \"C\" fn gaping() {\n    work();\n    guard(|| 1)\n}\n",
            ),
        ]);
        let problems = check_packages(&tree);
        for part in [
            "must not depend on seidel",
            "seidel-unlisted",
            "std::fs",
            "forbid unsafe",
            "commands/lost.rs",
            "commands/fit.rs: opens a file",
            "gaping",
        ] {
            assert!(
                problems.iter().any(|p| p.contains(part)),
                "{part} in {problems:?}"
            );
        }
        for part in ["closed", "commands/mod.rs"] {
            assert!(
                !problems.iter().any(|p| p.contains(part)),
                "{part} in {problems:?}"
            );
        }
    }

    #[test]
    fn unlisted_parts_are_found() {
        let tree = Tree::of(&[
            (
                "core/src/psf/mod.rs",
                "pub static ALL: [&dyn PsfModel; 1] = [\n    &Gaussian,\n];",
            ),
            ("core/src/psf/gaussian.rs", "impl PsfModel for Gaussian {"),
            ("core/src/psf/lost.rs", "impl MomentPsf for Lost {"),
        ]);
        let mut problems = Vec::new();
        registries::check(&tree, &mut problems);
        assert!(problems.iter().any(|p| p.contains("Lost")), "{problems:?}");
        assert!(
            !problems.iter().any(|p| p.contains("Gaussian")),
            "{problems:?}"
        );
        // A list that is not found is a breach too, or a move of its folder would end the check.
        assert!(
            problems.iter().any(|p| p.contains("effects")),
            "{problems:?}"
        );
    }
}

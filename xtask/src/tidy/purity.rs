//! Layering that Cargo cannot enforce: the core is pure and knows nothing of the command, files are opened in one place, and the
//! sealed trial cases do not use the model that they test.

use crate::workspace::{Package, TextFile, Tree};

/// Access to files, clocks, the environment and global state, which the core must not use.
const IMPURE: [&str; 7] = [
    "std::fs",
    "std::env",
    "std::net",
    "std::time",
    "std::process",
    "println!",
    "thread_local!",
];

/// Parts of the names of types whose values change behind a shared reference.
const INTERIOR_MUTABILITY: [&str; 6] = ["Mutex", "RwLock", "Once", "Lazy", "Cell", "Atomic"];

/// Statics of the core that are computed once, from constants alone.
const COMPUTED_CONSTANTS: [&str; 3] = ["EXACT_TAPS", "FEW_DIRECTIONS", "MORE_DIRECTIONS"];

/// Packages that may contain `unsafe`: the layers between Rust and C, and their tests, the attack among them.
const MAY_BE_UNSAFE: [&str; 6] = [
    "seidel-attack",
    "seidel-plugin",
    "seidel-ofx",
    "seidel-ofx-host",
    "seidel-ofx-broken",
    "seidel-tests",
];

/// The folder of `cli/` that opens files.
const OPENS_FILES: &str = "cli/image-io/";

/// Modules of the core that the trial cases test. A case computed with them would agree with them by construction.
const UNDER_TEST: [&str; 10] = [
    "lens", "psf", "effects", "fit", "predict", "profile", "moments", "eval", "render", "diagnose",
];

pub(super) fn check(tree: &Tree, packages: &[Package], problems: &mut Vec<String>) {
    for package in packages {
        if package.is_core() {
            check_pure(tree, package, problems);
        }
        if !MAY_BE_UNSAFE.contains(&package.name.as_str()) {
            let path = package.path("src/lib.rs");
            let text = tree.text(&path);
            if !text.is_empty() && !text.contains("#![forbid(unsafe_code)]") {
                problems.push(format!("{path}: must forbid unsafe code"));
            }
        }
    }
    for file in tree.rust_files("cli/") {
        let allowed = file.path.starts_with(OPENS_FILES);
        let is_product = file.path.contains("/src/");
        let calls = ["fs::File", "fs::read", "fs::write", " File::open"];
        if is_product && !allowed && calls.iter().any(|call| file.text.contains(call)) {
            problems.push(format!(
                "{}: opens a file; that is done in {OPENS_FILES} only",
                file.path
            ));
        }
    }
    for file in tree
        .rust_files("")
        .filter(|file| file.path.contains("/trial/"))
    {
        check_trial(file, problems);
    }
}

fn check_pure(tree: &Tree, package: &Package, problems: &mut Vec<String>) {
    for file in tree.rust_files(&package.path("src/")) {
        for name in IMPURE {
            if file.text.contains(name) {
                problems.push(format!("{}: the core must not use {name}", file.path));
            }
        }
        if file.path.ends_with("/tests.rs") || file.path.contains("/tests/") {
            continue;
        }
        let product = file.text.split("#[cfg(test)]\nmod tests {").next();
        for (index, line) in product.unwrap_or("").lines().enumerate() {
            if let Some(breach) = breach(line) {
                problems.push(format!(
                    "{}:{}: the core must not {breach}",
                    file.path,
                    index + 1
                ));
            }
        }
    }
}

/// Returns the breach in a line of code: a static that may change, or an option or subcommand of the command.
fn breach(line: &str) -> Option<&'static str> {
    let code = line.trim_start();
    let has = |words: &[&str]| words.iter().any(|word| code.contains(word));
    let is_static = code.split(' ').take(2).any(|word| word == "static");
    if is_static && has(&INTERIOR_MUTABILITY) && !has(&COMPUTED_CONSTANTS) {
        return Some("keep state in a static");
    }
    let mut after_dashes = code.split("--").skip(1);
    let is_option = |rest: &str| rest.starts_with(|c: char| c.is_ascii_lowercase());
    let names_command = after_dashes.any(is_option) || code.contains("`seidel ");
    (names_command && !code.starts_with("//"))
        .then_some("name options of the command, as other callers see its messages too")
}

fn check_trial(file: &TextFile, problems: &mut Vec<String>) {
    // In a package of its own, `crate::lens` is the trial's own module.
    let within_core = file.path.starts_with("core/");
    for (at, separator) in file.text.match_indices("::") {
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        let before = &file.text[..at];
        let root = before.rsplit(|c| !is_name(c)).next().unwrap_or("");
        let after = &file.text[at + separator.len()..];
        let module = after.split(|c| !is_name(c)).next().unwrap_or("");
        let is_core = root.starts_with("seidel_") || (root == "crate" && within_core);
        let path = &file.path;
        if is_core && UNDER_TEST.contains(&module) {
            problems.push(format!("{path}: the trial must not use {root}::{module}"));
        }
        if is_core && after.starts_with('{') {
            problems.push(format!(
                "{path}: import each module of {root} in its own `use`"
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn state_and_options_are_found() {
        for line in [
            "    static A: Mutex<u8> = Mutex::new(0);",
            "pub static B: OnceLock<f64> = x;",
            "\"give --near\"",
            "\"run `seidel fit`\"",
        ] {
            assert!(breach(line).is_some(), "{line}");
        }
        for line in [
            "pub static C: &[u8] = &[];",
            "static EXACT_TAPS: LazyLock<u8> = y;",
            "fn a(b: &'static str, c: &RefCell<u8>) {",
            "/// as --near gives it",
            "a - -b",
        ] {
            assert_eq!(breach(line), None, "{line}");
        }
    }
}

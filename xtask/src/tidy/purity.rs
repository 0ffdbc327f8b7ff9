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
        for name in mutable_statics(&file.text) {
            problems.push(format!(
                "{}: the core must not keep state in the static {name}",
                file.path
            ));
        }
        let product = file.text.split("#[cfg(test)]\nmod tests {").next();
        for (index, line) in product.unwrap_or("").lines().enumerate() {
            if names_command(line) {
                problems.push(format!(
                    "{}:{}: the core must not name options of the command, as other callers see its messages too",
                    file.path,
                    index + 1
                ));
            }
        }
    }
}

/// Returns the names of statics that may change, constants that are computed once excepted.
fn mutable_statics(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices("static ").filter_map(|(at, word)| {
        // The lifetime is no declaration.
        let declaration = (!text[..at].ends_with('\'')).then(|| &text[at + word.len()..])?;
        let (name, of_type) = declaration.split_once(": ")?;
        let of_type = of_type.split('=').next()?;
        let changes = INTERIOR_MUTABILITY
            .iter()
            .any(|word| of_type.contains(word));
        (changes && !COMPUTED_CONSTANTS.contains(&name)).then_some(name)
    })
}

/// Returns whether a line of code has an option or a subcommand of the command, comments excepted.
fn names_command(line: &str) -> bool {
    let is_option = |(at, _): (usize, &str)| {
        let name = line[at + 2..].chars().next();
        name.is_some_and(|c| c.is_ascii_lowercase())
    };
    let has_any = line.contains("`seidel ") || line.match_indices("--").any(is_option);
    has_any && !line.trim_start().starts_with("//")
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
    fn statics_that_change_are_found() {
        let text = "static A: Mutex<u8> = Mutex::new(0);\n    static B: OnceLock<f64> = x;\npub static C: &[u8] = &[];\n\
                    static EXACT_TAPS: LazyLock<u8> = y;\nfn a(b: &'static str) { let c: RefCell<u8> = d; }";
        assert_eq!(mutable_statics(text).collect::<Vec<_>>(), ["A", "B"]);
    }

    #[test]
    fn options_and_subcommands_are_found() {
        assert!(names_command("\"give --near\"") && names_command("\"run `seidel fit`\""));
        assert!(!names_command("/// as --near gives it") && !names_command("a - -b"));
    }
}

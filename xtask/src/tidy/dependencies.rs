//! Dependencies between the packages of this project, and lines that every manifest contains.

use crate::workspace::{Package, Tree};

/// The packages of this project that each package may depend on, its tests included.
const ALLOWED: [(&str, &[&str]); 22] = [
    ("seidel-fourier", &[]),
    (
        "seidel-core",
        &["seidel-optics", "seidel-render", "seidel-calibrate"],
    ),
    ("seidel-optics", &["seidel-fourier"]),
    ("seidel-render", &["seidel-fourier", "seidel-optics"]),
    (
        "seidel-calibrate",
        &["seidel-fourier", "seidel-optics", "seidel-render"],
    ),
    ("seidel-measure", &["seidel-optics"]),
    ("seidel-colour", &[]),
    ("seidel-threads", &[]),
    (
        "seidel-plugin",
        &[
            "seidel-core",
            "seidel-optics",
            "seidel-render",
            "seidel-threads",
        ],
    ),
    // The test host and the C ABI are dependencies of its tests.
    (
        "seidel-ofx",
        &[
            "seidel-colour",
            "seidel-core",
            "seidel-image-io",
            "seidel-ofx-host",
            "seidel-optics",
            "seidel-plugin",
            "seidel-threads",
        ],
    ),
    (
        "seidel",
        &[
            "seidel-calibrate",
            "seidel-colour",
            "seidel-core",
            "seidel-image-io",
            "seidel-measure",
            "seidel-optics",
            "seidel-render",
        ],
    ),
    ("seidel-image-io", &["seidel-optics"]),
    (
        "seidel-python",
        &[
            "seidel-core",
            "seidel-image-io",
            "seidel-measure",
            "seidel-threads",
        ],
    ),
    (
        "seidel-tests",
        &[
            "seidel",
            "seidel-calibrate",
            "seidel-colour",
            "seidel-core",
            "seidel-image-io",
            "seidel-measure",
            "seidel-ofx",
            "seidel-ofx-host",
            "seidel-optics",
            "seidel-plugin",
            "seidel-render",
            "seidel-trial",
        ],
    ),
    (
        "seidel-attack",
        &[
            "seidel",
            "seidel-colour",
            "seidel-core",
            "seidel-image-io",
            "seidel-ofx-host",
            "seidel-plugin",
        ],
    ),
    ("seidel-fuzz", &["seidel-attack"]),
    // The trial cases have a lens and a renderer of their own; from the core they take only the vocabulary.
    ("seidel-trial", &["seidel-optics"]),
    (
        "seidel-self-test",
        &[
            "seidel",
            "seidel-calibrate",
            "seidel-core",
            "seidel-image-io",
            "seidel-optics",
            "seidel-trial",
        ],
    ),
    (
        "seidel-yardsticks",
        &[
            "seidel-core",
            "seidel-fourier",
            "seidel-image-io",
            "seidel-optics",
        ],
    ),
    // The test host shares no code with the plugins it tests, so that a mistake is not made twice.
    ("seidel-ofx-host", &[]),
    ("seidel-ofx-broken", &["seidel-ofx-host"]),
    ("xtask", &["seidel-colour", "seidel-core", "seidel-optics"]),
];

/// Lines that every manifest contains.
const REQUIRED: [&str; 3] = [
    "license.workspace = true",
    "rust-version.workspace = true",
    "[lints]\nworkspace = true",
];

pub(super) fn check(tree: &Tree, packages: &[Package], problems: &mut Vec<String>) {
    for package in packages {
        let path = package.path("Cargo.toml");
        let name = &package.name;
        for text in REQUIRED {
            if !package.manifest.contains(text) {
                problems.push(format!("{path}: lacks `{text}`"));
            }
        }
        let Some((_, allowed)) = ALLOWED.iter().find(|(of, _)| of == name) else {
            problems.push(format!(
                "{path}: xtask/src/tidy/dependencies.rs does not list what {name} may depend on"
            ));
            continue;
        };
        for dependency in package.dependencies() {
            let is_ours = ALLOWED.iter().any(|(ours, _)| *ours == dependency);
            if is_ours && !allowed.contains(&dependency.as_str()) {
                problems.push(format!("{path}: {name} must not depend on {dependency}"));
            }
        }
    }
    for lock in tree
        .files()
        .filter(|file| file.path.ends_with("Cargo.lock"))
    {
        if lock.text.contains("git+") {
            problems.push(format!(
                "{}: a dependency comes from a git repository",
                lock.path
            ));
        }
    }
}

//! The sources that each picture of `docs/` was drawn from, as digests, so that a stale picture is found.

use std::collections::BTreeMap;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::workspace::Tree;

/// A picture, a tab and the digest of its sources a line.
const PATH: &str = "docs/pictures/sources.txt";
/// Sources of every picture: the frame of its panels.
const COMMON: [&str; 2] = [
    "xtask/src/pictures/panels.rs",
    "xtask/src/pictures/samples.rs",
];

/// Notes that the picture `name` was drawn from the present `sources`.
///
/// # Errors
/// The file of digests cannot be written.
pub(super) fn note_drawn(root: &Path, name: &str, sources: &[&str]) -> Result<(), String> {
    let tree = Tree::read(root);
    let mut drawn = noted(&tree);
    let digest = digest(&tree, sources);
    drawn.insert(name, &digest);
    let lines = drawn
        .iter()
        .map(|(name, digest)| format!("{name}\t{digest}\n"));
    std::fs::write(root.join(PATH), lines.collect::<String>())
        .map_err(|why| format!("{PATH}: {why}"))
}

/// Returns the problem if `sources` changed after the picture `name` was drawn.
pub(super) fn stale(tree: &Tree, name: &str, sources: &[&str]) -> Option<String> {
    let is_current = noted(tree).get(name) == Some(&digest(tree, sources).as_str());
    (!is_current).then(|| {
        format!(
            "{PATH}: the picture {name} is older than its sources; run `cargo xtask pictures {name}` and look at it"
        )
    })
}

fn noted(tree: &Tree) -> BTreeMap<&str, &str> {
    let lines = tree.text(PATH).lines();
    lines.filter_map(|line| line.split_once('\t')).collect()
}

/// Returns a digest of the files whose path begins with one of `sources`, without comments, which draw nothing.
fn digest(tree: &Tree, sources: &[&str]) -> String {
    let mut hash = Sha256::new();
    let is_source = |path: &str| {
        let mut all = COMMON.iter().chain(sources);
        all.any(|start| path.starts_with(start))
    };
    for file in tree.files().filter(|file| is_source(&file.path)) {
        let code = file.text.lines().map(str::trim);
        for line in code.filter(|line| !line.starts_with("//")) {
            hash.update(line);
        }
    }
    let hash = hash.finalize();
    hash[..8].iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_makes_a_picture_stale_and_a_comment_does_not() {
        let of = |text: &str| {
            digest(
                &Tree::of(&[("cli/src/demo/a.rs", text)]),
                &["cli/src/demo/"],
            )
        };
        let drawn = of("//! A.\nfn f() {}\n");
        assert_eq!(drawn, of("//! B.\n\nfn f() {}\n"));
        assert_ne!(drawn, of("//! A.\nfn g() {}\n"));
        assert!(stale(&Tree::of(&[]), "a", &["cli/"]).is_some());
    }
}

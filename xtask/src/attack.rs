//! Builds and runs the attack: hostile runs of every reader, of the C ABI and of the command; and long runs.

use std::path::Path;
use std::process::Command;

/// Runs `cargo xtask attack`. Arguments are those of the attack; `--help` lists them.
///
/// # Errors
/// A build that fails, and any finding of the attack.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    start(root, &["seidel"], arguments)
}

/// Runs `cargo xtask endurance`. Arguments are the names of long runs, all without one, and options of the attack.
///
/// # Errors
/// A build that fails, wrong results, and memory that grows.
pub(crate) fn endurance(
    root: &Path,
    arguments: impl Iterator<Item = String>,
) -> Result<String, String> {
    let arguments = std::iter::once("--endurance".to_owned()).chain(arguments);
    start(root, &["seidel", "seidel-ofx"], arguments)
}

/// Builds `packages` and the attack, and runs it.
fn start(
    root: &Path,
    packages: &[&str],
    arguments: impl Iterator<Item = String>,
) -> Result<String, String> {
    let mut attack = Command::new(env!("CARGO"));
    attack.current_dir(root);
    attack.args(["run", "--quiet", "-p", "seidel-attack", "--"]);
    let packages = packages.iter().flat_map(|package| ["-p", package]);
    let built = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["build", "--quiet"])
        .args(packages)
        .status();
    if !built.is_ok_and(|status| status.success()) {
        return Err("the command does not build".to_owned());
    }
    let arguments: Vec<String> = arguments.collect();
    if !arguments.iter().any(|word| word.starts_with("--program")) {
        let folder = std::env::current_exe().map_err(|e| e.to_string())?;
        let name = format!("seidel{}", std::env::consts::EXE_SUFFIX);
        attack.arg("--program").arg(folder.with_file_name(name));
    }
    let status = attack.args(arguments).status();
    match status
        .map_err(|e| format!("the attack does not start: {e}"))?
        .code()
    {
        Some(0) => Ok("no finding".to_owned()),
        Some(1) => Err(
            "findings; those of the attack are stored beside its log with the command that runs them again"
                .to_owned(),
        ),
        _ => Err("the attack could not run".to_owned()),
    }
}

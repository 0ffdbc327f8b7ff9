//! Builds and runs the attack: hostile runs of every reader, of the C ABI and of the command.

use std::path::Path;
use std::process::Command;

/// Runs `cargo xtask attack`. Arguments are those of the attack; `--help` lists them.
///
/// # Errors
/// A build that fails, and any finding of the attack.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let mut attack = Command::new(env!("CARGO"));
    attack.current_dir(root);
    attack.args(["run", "--quiet", "-p", "seidel-attack", "--"]);
    let built = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["build", "--quiet", "-p", "seidel"])
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
        Some(0) => Ok("attack: no finding".to_owned()),
        Some(1) => Err(
            "findings; each is stored beside the log with the command that runs it again"
                .to_owned(),
        ),
        _ => Err("the attack could not run".to_owned()),
    }
}

//! Builds and runs the yardsticks: every job of the product beside the simplest program that could do it.

use std::path::Path;
use std::process::Command;

/// The page of the figures.
const PAGE: &str = "docs/background/yardsticks.md";

/// Runs `cargo xtask yardsticks`. Arguments are those of the yardsticks; `--help` lists them.
///
/// # Errors
/// A build that fails, and a case in which the simplest program is better.
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let arguments: Vec<String> = arguments.collect();
    let mut yardsticks = Command::new(env!("CARGO"));
    yardsticks.current_dir(root);
    yardsticks.args([
        "run",
        "--release",
        "--quiet",
        "-p",
        "seidel-yardsticks",
        "--",
    ]);
    if arguments.is_empty() {
        yardsticks.args(["--to", PAGE]);
    }
    match yardsticks.args(arguments).status() {
        Ok(status) if status.success() => Ok("no job is behind the simplest program".to_owned()),
        Ok(_) => {
            Err("the yardsticks did not run, or a job is behind the simplest program".to_owned())
        }
        Err(error) => Err(format!("the yardsticks do not start: {error}")),
    }
}

//! `seidel completions`: prints a script that completes commands and options in a shell.

use clap::Args;
use clap_complete::Shell;

use super::{CommandError, command};
use crate::Console;

/// Options of `seidel completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell to print the script for
    #[arg(value_enum)]
    shell: Shell,
}

pub(super) fn run(args: &CompletionsArgs, console: &mut Console) -> Result<(), CommandError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "seidel", &mut script);
    console.print(String::from_utf8_lossy(&script).trim_end());
    Ok(())
}

//! `seidel man`: writes the manual pages of the command and all its subcommands.

use std::path::{Path, PathBuf};

use clap::Args;
use clap_mangen::Man;

use super::{CommandError, command};
use crate::Console;
use seidel_image_io::atomic::write_atomically;
use seidel_image_io::error::FileError;

/// Options of `seidel man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Folder to write seidel.1, seidel-apply.1 and the others to; made if it does not exist
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub(super) fn run(args: &ManArgs, console: &mut Console) -> Result<(), CommandError> {
    std::fs::create_dir_all(&args.folder)
        .map_err(|error| FileError::io(&args.folder, "be made", &error))?;
    let mut whole = command().disable_help_subcommand(true);
    // Gives subcommands their full names and usages.
    whole.build();
    let whole = with_all_helps(whole);
    let count = write_pages(&whole, "seidel", &args.folder)?;
    let folder = args.folder.display();
    console.note(format!("{count} manual pages written to {folder}"));
    Ok(())
}

/// Returns `command` with the helps of options that `-h` does not show: clap_mangen prints long ones only for these.
fn with_all_helps(command: clap::Command) -> clap::Command {
    let command = command.mut_args(|arg| match arg.get_help().cloned() {
        Some(help) if arg.get_long_help().is_none() => arg.long_help(help),
        _ => arg,
    });
    command.mut_subcommands(with_all_helps)
}

/// Writes the page of `command`, called `name`, and those of its subcommands. Returns the number of pages.
fn write_pages(command: &clap::Command, name: &str, folder: &Path) -> Result<usize, CommandError> {
    let page = Man::new(command.clone()).title(name);
    let path = folder.join(format!("{name}.1"));
    write_atomically(&path, |out| page.render(out))?;
    let mut count = 1;
    for subcommand in command.get_subcommands() {
        let name = format!("{name}-{}", subcommand.get_name());
        count += write_pages(subcommand, &name, folder)?;
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_explain_the_options_that_short_helps_leave_out() {
        let mut whole = command();
        whole.build();
        let whole = with_all_helps(whole);
        let apply = whole.find_subcommand("apply").expect("a command");
        let mut page = Vec::new();
        Man::new(apply.clone()).render(&mut page).expect("memory");
        let page = String::from_utf8(page).expect("text");
        assert!(page.contains("EXR layer or part to process"));
    }
}

//! `seidel man`: writes the manual pages of the command and all its subcommands.

use std::path::{Path, PathBuf};

use clap::Args;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

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
    // The examples get a section of their own name: clap_mangen calls it EXTRA.
    let examples = command.get_after_long_help().map(ToString::to_string);
    let page = Man::new(command.clone()).title(name);
    let path = folder.join(format!("{name}.1"));
    write_atomically(&path, |out| {
        page.render_title(out)?;
        page.render_name_section(out)?;
        page.render_synopsis_section(out)?;
        page.render_description_section(out)?;
        page.render_options_section(out)?;
        if command.has_subcommands() {
            page.render_subcommands_section(out)?;
        }
        closing_sections(examples.as_deref()).to_writer(out)
    })?;
    let mut count = 1;
    for subcommand in command.get_subcommands() {
        let name = format!("{name}-{}", subcommand.get_name());
        count += write_pages(subcommand, &name, folder)?;
    }
    Ok(count)
}

/// The exit statuses, each with its meaning.
const EXIT_STATUS: [(&str, &str); 4] = [
    ("0", "Done."),
    (
        "1",
        "The work failed; the message names file, field and remedy, and no partial output is left.",
    ),
    ("2", "The command line is wrong."),
    (
        "129, 130, 143",
        "Stopped by SIGHUP, SIGINT or SIGTERM; partial outputs are removed.",
    ),
];

/// The environment variables that the command reads.
const ENVIRONMENT: [(&str, &str); 2] = [
    (
        "SEIDEL_LENSES",
        "Folder of own lens profiles, which library:NAME finds.",
    ),
    ("OCIO", "OpenColorIO config, unless --ocio names one."),
];

/// Returns the sections EXIT STATUS, ENVIRONMENT and EXAMPLES.
fn closing_sections(examples: Option<&str>) -> Roff {
    let mut roff = Roff::default();
    for (heading, terms) in [
        ("EXIT STATUS", &EXIT_STATUS[..]),
        ("ENVIRONMENT", &ENVIRONMENT),
    ] {
        roff.control("SH", [heading]);
        for (term, meaning) in terms {
            roff.control("TP", [])
                .text([bold(*term)])
                .text([roman(*meaning)]);
        }
    }
    if let Some(examples) = examples {
        let lines = examples.lines().filter(|line| *line != "Examples:");
        roff.control("SH", ["EXAMPLES"]).control("nf", []);
        for line in lines {
            roff.text([roman(line)]);
        }
        roff.control("fi", []);
    }
    roff
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

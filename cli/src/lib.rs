//! The `seidel` command as a library: one module per command, pictures and reports.
//!
//! Data flow one way: a command reads through `seidel_image_io`, calls `seidel_core`, and writes through
//! `seidel_image_io`. Nothing else opens a file.
#![forbid(unsafe_code)]

pub mod commands;
mod console;
mod defaults;
pub mod demo;
pub mod pictures;
mod progress;
pub mod report;
#[cfg(unix)]
mod signals;
mod terminal;
mod terms;
pub mod view;

pub use console::Console;
pub use progress::{ProgressBar, ProgressForm, ProgressOutput, ProgressStream};
#[cfg(unix)]
pub use signals::remove_partial_outputs_on_signals;

use clap::FromArgMatches;
use std::ffi::OsString;
use std::io::Write as _;

use terminal::TerminalStream;

/// Runs the command line `args` (program name first). Returns the exit status: 0 for success, 1 for failure, 2 for an
/// invalid command line. Output that cannot be written is a failure.
pub fn run(args: impl IntoIterator<Item = OsString>, console: &mut Console) -> u8 {
    let command_line: Vec<OsString> = args.into_iter().collect();
    let mut stderr = TerminalStream::of_messages(&mut *console.stderr);
    let mut stdout = TerminalStream::of_results(&mut *console.stdout);
    let mut streams = Console {
        stdout: &mut stdout,
        stderr: &mut stderr,
        progress: console.progress.clone(),
    };
    let status = run_command(&command_line, &mut streams);
    match stdout.finish() {
        Err(error) if status == 0 => {
            let remedy = "free some space or write elsewhere";
            let _ = writeln!(
                stderr,
                "error: standard output: cannot be written ({error}); {remedy}"
            );
            1
        }
        _ => status,
    }
}

fn run_command(command_line: &[OsString], console: &mut Console) -> u8 {
    let commands = commands::command();
    let folder = std::env::current_dir().unwrap_or_default();
    let has_ocio = std::env::var_os("OCIO").is_some_and(|path| !path.is_empty());
    let defaults = match defaults::with_defaults(&commands, command_line, &folder, has_ocio) {
        Ok(defaults) => defaults,
        Err(error) => {
            console.error(&error.to_string());
            return 2;
        }
    };
    let command_line = (defaults.as_ref()).map_or(command_line, |defaults| &defaults.line);
    let note = defaults.as_ref().map(|defaults| defaults.note.as_str());
    let parsed = (commands.try_get_matches_from(command_line))
        .and_then(|matches| commands::Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => {
            let error = commands::suggest_by_meaning(error, command_line);
            // Help and version arrive here too, with exit status 0.
            let text = error.render().to_string();
            let status = error.exit_code();
            let stream = if status == 0 {
                &mut *console.stdout
            } else {
                &mut *console.stderr
            };
            let _ = write!(stream, "{text}");
            if let Some(note) = note.filter(|_| status != 0) {
                console.note(note);
            }
            return u8::try_from(status).unwrap_or(2);
        }
    };
    let Err(error) = cli.command.run(command_line, note, console) else {
        return 0;
    };
    console.error(&error.to_string());
    match error {
        commands::CommandError::Usage(_) => 2,
        _ => 1,
    }
}

//! The `seidel` command as a library: one module a command, pictures and reports.
//!
//! Data flow one way: a command reads through `seidel_image_io`, calls `seidel_core`, and writes through
//! `seidel_image_io`. Nothing else opens a file.
#![forbid(unsafe_code)]

pub mod commands;
mod console;
pub mod demo;
pub mod pictures;
pub mod report;

pub use console::{Console, Progress};

use clap::Parser;
use std::ffi::OsString;

/// Runs the command line `args` (program name first). Returns the exit status: 0 done, 1 the work
/// failed, 2 the command line was wrong.
pub fn run(args: impl IntoIterator<Item = OsString>, console: &mut Console) -> u8 {
    let words: Vec<OsString> = args.into_iter().collect();
    let cli = match commands::Cli::try_parse_from(&words) {
        Ok(cli) => cli,
        Err(problem) => {
            // Help and version come this way too, with exit status 0.
            let text = problem.render().to_string();
            let status = problem.exit_code();
            let stream = if status == 0 {
                &mut *console.stdout
            } else {
                &mut *console.stderr
            };
            let _ = write!(stream, "{text}");
            return u8::try_from(status).unwrap_or(2);
        }
    };
    match cli.command.run(&words, console) {
        Ok(()) => 0,
        Err(commands::CommandError::Usage(problem)) => {
            let _ = writeln!(console.stderr, "error: {problem}");
            2
        }
        Err(problem) => {
            let _ = writeln!(console.stderr, "error: {problem}");
            1
        }
    }
}

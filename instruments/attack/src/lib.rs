//! Hostile runs of Seidel: damaged inputs in every reader, hostile calls of the C ABI, and runs of the whole command
//! that are killed, out of space or deprived of their inputs. Also long runs (`endurance`).
//!
//! A supervisor starts worker processes of this binary. A worker runs cases of one target and reports each over a pipe, so
//! that an abort or a hang ends a worker only. Every case is a function of target, seed and number.
//! The readers and their seeds serve a fuzzer, too (`fuzz`).
#![cfg(unix)]

mod allocator;
mod case;
mod endurance;
mod finding;
pub mod fuzz;
mod log;
mod mutations;
mod options;
mod process;
mod rng;
mod seeds;
mod supervisor;
mod targets;
mod worker;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser as _;

use options::Options;

/// First argument of a process of this binary that is the `seidel` command.
const AS_PROGRAM: &str = "--as-seidel";

/// Runs the attack as the command line says.
pub fn run() -> ExitCode {
    let mut words = std::env::args_os();
    let name = words.next().unwrap_or_default();
    if std::env::args_os()
        .nth(1)
        .is_some_and(|word| word == AS_PROGRAM)
    {
        words.next();
        return run_as_program(name, words.collect());
    }
    let options = Options::parse();
    if let Some(target) = &options.worker {
        return worker::run(target, &options);
    }
    let (result, what) = match options.endurance {
        Some(_) => (endurance::run(&options), "failures"),
        None => (supervisor::run(&options), "findings"),
    };
    match result {
        Ok(0) => ExitCode::SUCCESS,
        Ok(count) => {
            eprintln!("{count} {what}");
            ExitCode::FAILURE
        }
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::from(2)
        }
    }
}

/// Runs the `seidel` command, so that whole-program targets need no other binary.
fn run_as_program(name: OsString, words: Vec<OsString>) -> ExitCode {
    seidel::remove_partial_outputs_on_signals();
    let (mut stdout, mut stderr) = (std::io::stdout(), std::io::stderr());
    let mut console = seidel::Console {
        stdout: &mut stdout,
        stderr: &mut stderr,
        progress: seidel::ProgressOutput::hidden(),
    };
    let args = std::iter::once(name).chain(words);
    ExitCode::from(seidel::run(args, &mut console))
}

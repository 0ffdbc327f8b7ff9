//! The attack as a program.
#![cfg(unix)]

use std::process::ExitCode;

fn main() -> ExitCode {
    seidel_attack::run()
}

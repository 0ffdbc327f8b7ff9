//! `seidel-ofx-host`: all checks on any OpenFX plugin.

use std::process::ExitCode;

fn main() -> ExitCode {
    seidel_ofx_host::command::main()
}

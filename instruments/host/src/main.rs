//! `seidel-ofx-host`: tests an OpenFX plugin, or renders an image with it.

use std::process::ExitCode;

fn main() -> ExitCode {
    seidel_ofx_host::command::main()
}

//! The `seidel` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(unix)]
    seidel::remove_partial_outputs_on_signals();
    let mut stdout = std::io::stdout();
    let mut stderr = std::io::stderr();
    let status = seidel::run(
        std::env::args_os(),
        &mut seidel::Console {
            progress: seidel::ProgressOutput::stderr(),
            stdout: &mut stdout,
            stderr: &mut stderr,
        },
    );
    ExitCode::from(status)
}

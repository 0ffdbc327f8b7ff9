//! The plugin before a host that is nasty on purpose: every check of `tests/host`.

fn main() -> std::process::ExitCode {
    seidel_ofx_host::command::test("seidel_ofx", "seidel")
}

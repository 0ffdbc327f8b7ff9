//! The plugin in the adversarial host: every check of `tests/host`.

fn main() -> std::process::ExitCode {
    seidel_ofx_host::runner::test_main("seidel_ofx", "seidel")
}

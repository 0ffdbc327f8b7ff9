//! Every check of the test host on the plugin.

fn main() -> std::process::ExitCode {
    seidel_ofx_host::runner::test_main("seidel_ofx", "seidel")
}

//! Description of the machine that runs a benchmark.

use std::process::Command;

/// Processor, compiler and the libraries that count, one a line.
pub(crate) fn description(threads: usize) -> Vec<String> {
    let processor = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split(':').nth(1)?.trim().to_owned())
        });
    let load = std::fs::read_to_string("/proc/loadavg").ok();
    let load = load.as_deref().and_then(|text| text.split(' ').next());
    let compiler = Command::new("rustc").arg("--version").output().ok();
    let compiler = compiler.and_then(|output| String::from_utf8(output.stdout).ok());
    let unknown = "not known";
    vec![
        format!("Processor: {}", processor.as_deref().unwrap_or(unknown)),
        format!("Threads: {threads}"),
        format!(
            "Load of the machine at the end: {}",
            load.unwrap_or(unknown)
        ),
        format!(
            "Compiler: {}",
            compiler.as_deref().unwrap_or(unknown).trim()
        ),
        format!(
            "seidel-core {}, rustfft {}, realfft {}",
            env!("CARGO_PKG_VERSION"),
            locked("rustfft").unwrap_or(unknown),
            locked("realfft").unwrap_or(unknown)
        ),
    ]
}

/// The version of a package in the workspace's lock file.
fn locked(name: &str) -> Option<&'static str> {
    let lock = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.lock"));
    let entry = lock.split("[[package]]").find(|entry| {
        let mut lines = entry.lines();
        lines.any(|line| line == format!("name = \"{name}\""))
    })?;
    let line = entry.lines().find(|line| line.starts_with("version"))?;
    line.split('"').nth(1)
}

//! Peak memory of a render, each in a process of its own.

use super::aim::{Aim, Wanted};
use super::lens;
use super::plates::{plate, shot};
use seidel_core::{Result, Settings, apply, no_progress};
use std::process::Command;

/// The option with which this program renders one frame of so many columns, and prints [`bytes_of_render`].
pub(crate) const OPTION: &str = "--memory";

/// Returns the aims of memory.
pub(crate) fn aims() -> Vec<Aim> {
    [(1920, 300.0), (3840, 1.2 * 1024.0)]
        .map(|(width, most)| {
            eprintln!("memory: {width} x {}", width * 9 / 16);
            let bytes = bytes_of_child(width);
            Aim::new(
                format!("memory above the images, {width} x {}", width * 9 / 16),
                Wanted::AtMost(most),
                "MiB",
                bytes.map(|bytes| bytes as f64 / f64::from(1 << 20)),
            )
        })
        .into()
}

/// Renders a frame of the shot and returns the peak memory of this process above the plate, its depth and the result, bytes; zero where
/// the system does not report it.
pub(crate) fn bytes_of_render(width: usize) -> Result<u64> {
    let plate = plate(&shot(0), width)?;
    let lens = lens()?;
    // What drawing the plate took is no part of the peak.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let result = apply(&lens, &plate, &Settings::default(), &no_progress)?;
    let pixels = (result.width() * result.height()) as u64;
    // Three planes, their depth and three planes of the result.
    let images = pixels * 4 * (3 + 1 + 3);
    Ok(peak_bytes().map_or(0, |peak| peak.saturating_sub(images)))
}

/// Returns the peak memory of this process, where the system reports it.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// Returns what [`bytes_of_render`] gives in a new process.
fn bytes_of_child(width: usize) -> Option<u64> {
    let program = std::env::current_exe().ok()?;
    let output = Command::new(program)
        .args([OPTION, &width.to_string()])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let bytes: u64 = text.trim().parse().ok()?;
    (bytes > 0).then_some(bytes)
}

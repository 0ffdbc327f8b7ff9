//! Signals that end the command: partial outputs are removed first.

use std::path::Path;
use std::sync::Arc;
use std::thread;

use seidel_image_io::json::read_text;
use seidel_image_io::partial;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;
use signal_hook::iterator::Signals;

/// Limit of the length of a file of `/proc`, bytes.
const LIMIT_BYTES: u64 = 1 << 20;

/// Difference of exit status and number of a signal, by the convention of shells.
const STATUS_OF_SIGNALS: i32 = 128;

/// The signal of a write beyond the limit of file sizes, on all systems that have it. `signal_hook` does not name it.
#[cfg(unix)]
const SIGXFSZ: i32 = 25;

/// Removes partial outputs when SIGINT, SIGTERM or SIGHUP arrives, and ends the process with the exit status 128 + number.
/// Signals that the caller of the process ignores, as `nohup` does, stay ignored.
///
/// The process ends as before if the system does not allow this.
pub fn remove_partial_outputs_on_signals() {
    // A write beyond the limit of file sizes then fails as one on a full disk does, and its partial output is removed.
    #[cfg(unix)]
    let _ = flag::register(SIGXFSZ, Arc::default());
    let handled: Vec<i32> = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| !is_ignored(*signal))
        .collect();
    let Ok(mut signals) = Signals::new(handled) else {
        return;
    };
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            partial::remove_all();
            std::process::exit(STATUS_OF_SIGNALS + signal);
        }
    };
    // Without this thread the signals would be lost, so that the command could not be stopped.
    let started = thread::Builder::new()
        .name("signals".to_owned())
        .spawn(wait);
    started.expect("a process that starts can start one thread");
}

/// Returns whether the process was started with `signal` ignored. Where the system does not say, SIGHUP counts as ignored,
/// so that `nohup` works.
fn is_ignored(signal: i32) -> bool {
    match ignored_signals() {
        // Bit 0 is signal 1.
        Some(mask) => (mask >> (signal - 1)) & 1 == 1,
        None => signal == SIGHUP,
    }
}

/// Returns the signals that the process was started to ignore, as a mask whose bit 0 is signal 1; `None` without `/proc`.
fn ignored_signals() -> Option<u64> {
    ignored_mask(&read_text(Path::new("/proc/self/status"), LIMIT_BYTES).ok()?)
}

/// Returns the mask of ignored signals in the status of a process.
fn ignored_mask(status: &str) -> Option<u64> {
    let mut masks = status
        .lines()
        .filter_map(|line| line.strip_prefix("SigIgn:"));
    u64::from_str_radix(masks.next()?.trim(), 16).ok()
}

#[cfg(test)]
mod tests {
    use super::ignored_mask;

    #[test]
    fn the_mask_of_ignored_signals_is_found() {
        let status = "Name:\tx\nSigBlk:\t0000000000000002\nSigIgn:\t0000000000001001\nSigCgt:\t0\n";
        assert_eq!(ignored_mask(status), Some(0x1001));
        assert_eq!(ignored_mask("Name:\tx\n"), None);
    }
}

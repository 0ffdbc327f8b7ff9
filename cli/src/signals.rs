//! Signals that end the command: partial outputs are removed first.

use std::thread;

use seidel_image_io::partial;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// What shells add to the number of a signal for the exit status.
const STATUS_OF_SIGNALS: i32 = 128;

/// Removes partial outputs when SIGINT, SIGTERM or SIGHUP arrives, and ends the process with the exit status 128 + number.
/// Signals that the caller of the process ignores, as `nohup` does, stay ignored.
///
/// The process ends as before if the system does not allow this.
pub fn remove_partial_outputs_on_signals() {
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
    let status = std::fs::read_to_string("/proc/self/status");
    let mask = status.ok().and_then(|status| ignored_mask(&status));
    match mask {
        // Bit 0 is signal 1.
        Some(mask) => (mask >> (signal - 1)) & 1 == 1,
        None => signal == SIGHUP,
    }
}

/// Returns the mask of ignored signals in the status of a process, as Linux writes it.
fn ignored_mask(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    u64::from_str_radix(line?.trim(), 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mask_of_ignored_signals_is_found() {
        let status = "Name:\tx\nSigBlk:\t0000000000000002\nSigIgn:\t0000000000001001\nSigCgt:\t0\n";
        assert_eq!(ignored_mask(status), Some(0x1001));
        assert_eq!(ignored_mask("Name:\tx\n"), None);
    }
}

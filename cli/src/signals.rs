//! Signals that end the command: partial outputs are removed first.

use std::thread;

use seidel_image_io::partial;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use crate::process::ignored_signals;

/// Difference of exit status and number of a signal, by the convention of shells.
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
    match ignored_signals() {
        // Bit 0 is signal 1.
        Some(mask) => (mask >> (signal - 1)) & 1 == 1,
        None => signal == SIGHUP,
    }
}

//! How much of a run is done.

use std::sync::Mutex;

use crate::Console;
use crate::console::Progress;

/// What is done of a run, as a bar shows it.
pub(super) struct Shares {
    bar: Progress,
    shown: Mutex<f64>,
    count: usize,
}

impl Shares {
    /// Of a run that does `what` to `count` frames.
    pub(super) fn new(console: &Console, what: &str, count: usize) -> Self {
        Self {
            bar: console.progress(what),
            shown: Mutex::new(0.0),
            count,
        }
    }

    /// Tells that `part` of the frame at `index` is done.
    pub(super) fn tell(&self, index: usize, part: f64) {
        // A late word from another thread must not turn the bar back.
        let now = (index as f64 + part) / self.count as f64;
        if let Ok(mut shown) = self.shown.lock()
            && now > *shown
        {
            *shown = now;
            self.bar.set(now);
        }
    }

    /// Lets somebody speak while the bar is away.
    pub(super) fn hidden(&self, speak: impl FnOnce()) {
        self.bar.hidden(speak);
    }

    /// Takes the bar away.
    pub(super) fn clear(&self) {
        self.bar.clear();
    }
}

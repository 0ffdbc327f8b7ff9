//! Output of a command: results on stdout, notes and errors on stderr.

use std::io::Write;

use indicatif::{ProgressDrawTarget, ProgressStyle};

/// The two output streams of a command; tests replace them by buffers.
pub struct Console<'a> {
    /// Stream of results.
    pub stdout: &'a mut dyn Write,
    /// Stream of notes and errors.
    pub stderr: &'a mut dyn Write,
    /// Whether to draw progress bars, which only a terminal shows correctly.
    pub show_progress: bool,
}

impl Console<'_> {
    /// Prints a line of results. [`run`](crate::run) reports output that cannot be written.
    pub fn print(&mut self, line: impl AsRef<str>) {
        let _ = writeln!(self.stdout, "{}", line.as_ref());
    }

    /// Prints a note for the user on stderr.
    pub fn note(&mut self, line: impl AsRef<str>) {
        let _ = writeln!(self.stderr, "note: {}", line.as_ref());
    }

    /// Returns a progress bar labelled `label`; it is invisible unless [`Console::show_progress`] is set.
    pub fn progress_bar(&self, label: &str) -> ProgressBar {
        let target = if self.show_progress {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = indicatif::ProgressBar::with_draw_target(Some(PROGRESS_STEPS), target);
        if let Ok(style) =
            ProgressStyle::with_template("{msg} [{bar:30}] {percent:>3} %, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(label.to_owned());
        ProgressBar(bar)
    }
}

/// Resolution of progress bars.
const PROGRESS_STEPS: u64 = 1000;

/// A progress bar, cleared when dropped.
pub struct ProgressBar(indicatif::ProgressBar);

impl ProgressBar {
    /// Shows that `share` (0 to 1) of the work is done. Always returns true: as a progress callback it never cancels.
    pub fn show(&self, share: f64) -> bool {
        let position = (share.clamp(0.0, 1.0) * PROGRESS_STEPS as f64) as u64;
        // Threads report out of order; the bar does not go back.
        if position > self.0.position() {
            self.0.set_position(position);
        }
        true
    }

    /// Clears the bar.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }

    /// Calls `print` with the bar cleared, so that lines and bar do not mix.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.0.suspend(print)
    }
}

impl Drop for ProgressBar {
    fn drop(&mut self) {
        self.clear();
    }
}

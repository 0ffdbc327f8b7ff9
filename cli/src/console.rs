//! Where a command's words go: results to stdout, everything else to stderr.

use std::io::Write;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The two streams of a command, so that tests can read them.
pub struct Console<'a> {
    /// Results.
    pub stdout: &'a mut dyn Write,
    /// Warnings and errors.
    pub stderr: &'a mut dyn Write,
    /// Whether stderr is a terminal, where a progress bar helps.
    pub show_progress: bool,
}

impl Console<'_> {
    /// Writes a line of results. A closed pipe (`seidel ... | head`) is no error.
    pub fn say(&mut self, line: impl AsRef<str>) {
        let _ = writeln!(self.stdout, "{}", line.as_ref());
    }

    /// Writes a remark for the user to stderr.
    pub fn remark(&mut self, line: impl AsRef<str>) {
        let _ = writeln!(self.stderr, "note: {}", line.as_ref());
    }

    /// A progress bar over shares 0..1 of `what`; silent where nobody watches.
    pub fn progress(&self, what: &str) -> Progress {
        let target = if self.show_progress {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(PROGRESS_STEPS), target);
        if let Ok(style) =
            ProgressStyle::with_template("{msg} [{bar:30}] {percent:>3} %, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Progress(bar)
    }
}

const PROGRESS_STEPS: u64 = 1000;

/// A progress bar; it vanishes when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    /// Shows that `share` (0..1) of the work is done.
    pub fn set(&self, share: f64) {
        self.0
            .set_position((share.clamp(0.0, 1.0) * PROGRESS_STEPS as f64) as u64);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }

    /// Does `speak` with the bar out of the way, so that words and bar do not mix.
    pub fn hidden<T>(&self, speak: impl FnOnce() -> T) -> T {
        self.0.suspend(speak)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

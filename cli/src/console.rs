//! Output of a command: results on stdout, notes and errors on stderr.

use std::io::Write;

use serde_json::{Value, json};

use crate::progress::{ProgressBar, ProgressForm, ProgressOutput};
use crate::terms::with_options;

/// The output streams of a command; tests replace them by buffers.
pub struct Console<'a> {
    /// Stream of results.
    pub stdout: &'a mut dyn Write,
    /// Stream of notes and errors.
    pub stderr: &'a mut dyn Write,
    /// Output of progress.
    pub progress: ProgressOutput,
}

impl Console<'_> {
    /// Prints a line of results. [`run`](crate::run) reports output that cannot be written.
    pub fn print(&mut self, line: impl AsRef<str>) {
        let _ = writeln!(self.stdout, "{}", line.as_ref());
    }

    /// Prints a note for the user on stderr.
    pub fn note(&mut self, line: impl AsRef<str>) {
        self.say("note", line.as_ref());
    }

    /// Prints the error that ends the command on stderr.
    pub fn error(&mut self, error: &str) {
        self.say("error", error);
    }

    /// Prints `event` on stderr, for programs alone.
    pub(crate) fn event(&mut self, event: &Value) {
        if self.progress.is_json() {
            self.write_line(&event.to_string());
        }
    }

    /// Sets the form of progress, notes and errors.
    pub(crate) fn set_progress_form(&mut self, form: ProgressForm) {
        self.progress = self.progress.clone().with_form(form);
    }

    /// Starts the display of the progress of `task`.
    pub fn progress_bar(&self, task: &str) -> ProgressBar {
        self.progress.start(task)
    }

    fn say(&mut self, kind: &str, text: &str) {
        let text = with_options(text);
        let line = if self.progress.is_json() {
            json!({"event": kind, "text": text}).to_string()
        } else {
            format!("{kind}: {text}")
        };
        self.write_line(&line);
    }

    /// Writes a line to stderr by one call, so that it does not mix with lines of progress.
    fn write_line(&mut self, line: &str) {
        let _ = self.stderr.write_all(format!("{line}\n").as_bytes());
    }
}

//! Progress of long work: a bar on a terminal, lines in a log, JSON for programs.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use indicatif::{ProgressDrawTarget, ProgressState, ProgressStyle};
use serde_json::{Value, json};

/// The option of all commands that take long.
#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct ProgressArgs {
    /// Progress on stderr
    #[arg(long, help_heading = "Run", value_enum, value_name = "FORM", default_value_t = ProgressForm::Auto)]
    progress: ProgressForm,
}

impl ProgressArgs {
    pub(crate) fn form(self) -> ProgressForm {
        self.progress
    }
}

/// The form of progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ProgressForm {
    /// A bar on a terminal, lines elsewhere
    #[default]
    Auto,
    /// A line at every tenth of the work, and every minute; none in the first seconds
    Lines,
    /// One JSON object a line for progress, notes, finished frames and errors
    Json,
    /// Nothing
    None,
}

/// The stream that progress is written to.
pub type ProgressStream = Arc<Mutex<dyn Write + Send>>;

/// The stream and the form of progress.
#[derive(Clone)]
pub struct ProgressOutput {
    stream: ProgressStream,
    is_terminal: bool,
    form: ProgressForm,
}

impl ProgressOutput {
    /// Creates the output on the process's stderr.
    #[must_use]
    pub fn stderr() -> Self {
        Self {
            stream: Arc::new(Mutex::new(std::io::stderr())),
            is_terminal: std::io::stderr().is_terminal(),
            form: ProgressForm::Auto,
        }
    }

    /// Creates an output on `stream`, which is no terminal.
    #[must_use]
    pub fn stream(stream: ProgressStream) -> Self {
        Self {
            stream,
            is_terminal: false,
            form: ProgressForm::Auto,
        }
    }

    /// Creates an output that shows nothing.
    #[must_use]
    pub fn hidden() -> Self {
        Self {
            form: ProgressForm::None,
            ..Self::stream(Arc::new(Mutex::new(std::io::sink())))
        }
    }

    /// Returns the same output in another form.
    #[must_use]
    pub fn with_form(mut self, form: ProgressForm) -> Self {
        // A hidden output stays hidden unless a form is asked for.
        if form != ProgressForm::Auto {
            self.form = form;
        }
        self
    }

    /// Returns whether notes and errors are JSON too.
    pub(crate) fn is_json(&self) -> bool {
        self.form == ProgressForm::Json
    }

    /// Starts the display of the progress of `task`.
    pub(crate) fn start(&self, task: &str) -> ProgressBar {
        let display = match self.form {
            ProgressForm::Auto if self.is_terminal => Display::Bar(bar(task)),
            ProgressForm::Auto | ProgressForm::Lines => Display::Text(Schedule::LINES),
            ProgressForm::Json => Display::Text(Schedule::JSON),
            ProgressForm::None => Display::Hidden,
        };
        let bar = ProgressBar {
            task: task.to_owned(),
            output: self.clone(),
            started: Instant::now(),
            position: AtomicU64::new(0),
            last: Mutex::new(None),
            display,
        };
        bar.report();
        bar
    }
}

/// Resolution of progress.
const STEPS: u64 = 1000;

/// The progress of a task; a bar is cleared when dropped.
pub struct ProgressBar {
    task: String,
    output: ProgressOutput,
    started: Instant,
    /// Work done, in [`STEPS`].
    position: AtomicU64,
    /// The last report in text.
    last: Mutex<Option<Report>>,
    display: Display,
}

enum Display {
    Hidden,
    Bar(indicatif::ProgressBar),
    Text(Schedule),
}

impl ProgressBar {
    /// Shows that `share` (0 to 1) of the work is done. Always returns true: as a progress callback it never cancels.
    pub fn show(&self, share: f64) -> bool {
        let position = (share.clamp(0.0, 1.0) * STEPS as f64) as u64;
        // Threads report out of order; progress does not go back.
        if self.position.fetch_max(position, Ordering::Relaxed) < position {
            self.report();
        }
        true
    }

    /// Clears the bar.
    pub fn clear(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }

    /// Calls `print` with the bar cleared, so that lines and bar do not mix.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        match &self.display {
            Display::Bar(bar) => bar.suspend(print),
            _ => print(),
        }
    }

    fn report(&self) {
        let position = self.position.load(Ordering::Relaxed);
        match &self.display {
            Display::Hidden => {}
            Display::Bar(bar) => bar.set_position(position),
            Display::Text(schedule) => {
                let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
                let now = Report {
                    share: position as f64 / STEPS as f64,
                    elapsed: self.started.elapsed(),
                };
                if schedule.is_due(*last, now) {
                    *last = Some(now);
                    self.write(now);
                }
            }
        }
    }

    fn write(&self, now: Report) {
        let Report { share, elapsed } = now;
        let left = time_left(share, elapsed);
        let line = if self.output.is_json() {
            json!({
                "event": "progress", "task": self.task, "share": share,
                "elapsed_s": tenths(elapsed), "left_s": left.map(tenths),
            })
            .to_string()
        } else {
            format!("{}: {:.0} %{}", self.task, 100.0 * share, remark(left))
        };
        let stream = self.output.stream.lock();
        // One call, so that lines of other threads do not mix with this one. Nobody may be reading.
        let _ = (stream.unwrap_or_else(PoisonError::into_inner))
            .write_all(format!("{line}\n").as_bytes());
    }
}

impl Drop for ProgressBar {
    fn drop(&mut self) {
        self.clear();
    }
}

fn bar(task: &str) -> indicatif::ProgressBar {
    let bar = indicatif::ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    let left = |state: &ProgressState, line: &mut dyn std::fmt::Write| {
        let left = time_left(f64::from(state.fraction()), state.elapsed());
        let _ = line.write_str(&remark(left));
    };
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {percent:>3} %{left}") {
        bar.set_style(style.with_key("left", left));
    }
    bar.set_message(task.to_owned());
    bar
}

/// Work done, and the time since its start.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Report {
    share: f64,
    elapsed: Duration,
}

/// The times at which text is written.
#[derive(Debug, Clone, Copy)]
struct Schedule {
    /// Least time between two reports.
    least: Duration,
    /// Step of the share that makes a report due.
    step: f64,
    /// Time after which a report is due without that step.
    most: Duration,
    /// Reports of the start and the end.
    ends: Ends,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ends {
    Reported,
    Silent,
}

impl Schedule {
    const LINES: Self = Self {
        least: Duration::from_secs(5),
        step: 0.1,
        most: Duration::from_secs(60),
        ends: Ends::Silent,
    };
    const JSON: Self = Self {
        least: Duration::from_millis(200),
        step: 1.0 / STEPS as f64,
        most: Duration::from_secs(60),
        ends: Ends::Reported,
    };

    fn is_due(&self, last: Option<Report>, now: Report) -> bool {
        let is_end = last.is_none() || now.share >= 1.0;
        if is_end && self.ends == Ends::Reported {
            return true;
        }
        let last = last.unwrap_or(Report {
            share: 0.0,
            elapsed: Duration::ZERO,
        });
        let since = now.elapsed.saturating_sub(last.elapsed);
        // Half a step of rounding.
        let is_step = now.share >= last.share + self.step - 0.5 / STEPS as f64;
        since >= self.most || (since >= self.least && is_step)
    }
}

/// Work and time below which the rest cannot be estimated.
const LEAST_SHARE: f64 = 0.01;
const LEAST_TIME: Duration = Duration::from_secs(1);

/// Returns the time that the rest takes at the speed so far; `None` while too little is done to say.
fn time_left(share: f64, elapsed: Duration) -> Option<Duration> {
    if share >= 1.0 {
        return Some(Duration::ZERO);
    }
    let is_known = share >= LEAST_SHARE && elapsed >= LEAST_TIME;
    is_known.then(|| elapsed.mul_f64((1.0 - share) / share))
}

/// Returns the remark on the time left; empty at the end.
fn remark(left: Option<Duration>) -> String {
    left.filter(|left| !left.is_zero())
        .map_or_else(String::new, |left| format!(", {} left", in_words(left)))
}

/// Returns a duration in seconds, to tenths.
fn tenths(duration: Duration) -> Value {
    json!((duration.as_secs_f64() * 10.0).round() / 10.0)
}

/// Returns a duration as people say it.
fn in_words(duration: Duration) -> String {
    let seconds = duration.as_secs_f64().ceil() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min", seconds.div_ceil(60)),
        _ => format!("{} h {} min", seconds / 3600, seconds % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(share: f64, seconds: f64) -> Report {
        Report {
            share,
            elapsed: Duration::from_secs_f64(seconds),
        }
    }

    #[test]
    fn the_rest_is_not_estimated_before_there_is_a_speed() {
        let left = |share, seconds| time_left(share, Duration::from_secs_f64(seconds));
        assert_eq!(left(0.0, 0.0), None);
        assert_eq!(left(0.0, 30.0), None);
        assert_eq!(left(0.5, 0.2), None);
        assert_eq!(left(0.25, 10.0), Some(Duration::from_secs(30)));
        assert_eq!(left(1.0, 10.0), Some(Duration::ZERO));
        let words = |seconds| in_words(Duration::from_secs_f64(seconds));
        assert_eq!(
            [words(0.2), words(59.9), words(61.0)],
            ["1 s", "1 min", "2 min"]
        );
        assert_eq!(words(3720.0), "1 h 2 min");
    }

    #[test]
    fn lines_come_at_tenths_and_minutes_and_not_at_once() {
        let due = |last, now| Schedule::LINES.is_due(last, now);
        assert!(!due(None, report(0.0, 0.0)) && !due(None, report(1.0, 3.0)));
        assert!(due(None, report(0.1, 5.0)) && !due(None, report(0.09, 50.0)));
        let last = Some(report(0.3, 100.0));
        assert!(!due(last, report(0.5, 104.0)) && due(last, report(0.4, 105.0)));
        assert!(due(last, report(0.301, 160.0)));
    }

    #[test]
    fn programs_read_one_object_a_line_from_start_to_end() {
        let stream: Arc<Mutex<Vec<u8>>> = Arc::default();
        let output = ProgressOutput::stream(stream.clone()).with_form(ProgressForm::Json);
        let bar = output.start("fitting");
        for share in [0.1, 0.3, 0.2, 1.0, 0.9] {
            assert!(bar.show(share));
        }
        drop(bar);
        let text = String::from_utf8(stream.lock().expect("free").clone()).expect("text");
        let lines: Vec<Value> = text
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect();
        let shares: Vec<&Value> = lines.iter().map(|line| &line["share"]).collect();
        // The others come within the least time.
        assert_eq!(shares, [&json!(0.0), &json!(1.0)]);
        assert_eq!(lines[0]["task"], "fitting");
        assert_eq!(lines[0]["left_s"], Value::Null);
        assert_eq!(lines[1]["left_s"], 0.0);
    }

    #[test]
    fn a_hidden_output_writes_only_what_is_asked_for() {
        let stream: Arc<Mutex<Vec<u8>>> = Arc::default();
        let output = ProgressOutput::stream(stream.clone());
        for form in [ProgressForm::Auto, ProgressForm::Lines, ProgressForm::None] {
            output.clone().with_form(form).start("quick").show(1.0);
        }
        assert!(stream.lock().expect("free").is_empty());
    }
}

//! Runs checks, each in a process of its own.
//!
//! A plugin may crash or hang, checks count the threads of their process, and no check must affect the next.

use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, ExitCode, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::causes::root_causes;
use crate::checks::{ALL, Check, Report, find};
use crate::host::locked;
use crate::process::disable_error_dialogs;
use crate::subject::Subject;

/// The first argument of a process that runs one check.
const ONE_CHECK: &str = "--one-check";

/// The time after which a check counts as hung. The longest, on Seidel's plugin without release optimisation, take four
/// minutes on an idle core and fifteen on a busy one.
const TIMEOUT: Duration = Duration::from_secs(1200);

/// The interval at which a running check is polled.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// The number of checks that run at the same time.
const PARALLEL_CHECKS: usize = 2;

/// Prints a line; a closed pipe is no error.
macro_rules! print_line {
    ($($text:tt)*) => {{
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}
pub(crate) use print_line;

/// The result of one check.
#[derive(Debug)]
pub struct Outcome {
    /// The name of the check.
    pub check: &'static str,
    /// Its findings.
    pub report: Report,
    /// The time that it took.
    pub duration: Duration,
}

impl Outcome {
    /// Returns whether the check found no fault.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.report.faults.is_empty()
    }

    /// The result in one word, for files.
    #[must_use]
    pub fn result(&self) -> &'static str {
        if !self.passed() {
            "failed"
        } else if self.report.skipped.is_empty() {
            "passed"
        } else {
            "passed in part"
        }
    }

    /// Formats the result: one line, and one more for each fault or skipped part.
    #[must_use]
    pub fn lines(&self) -> String {
        let state = match self.result() {
            "failed" => "FAILED",
            "passed" => "ok",
            _ => "ok, in part",
        };
        let mut text = format!("{:<24} {state}", self.check);
        for skipped in &self.report.skipped {
            text.push_str(&format!("\n    skipped: {skipped}"));
        }
        for fault in &self.report.faults {
            text.push_str(&format!("\n    {fault}"));
        }
        text
    }
}

/// Runs a check in this process.
#[must_use]
pub fn run_in_process(check: &'static Check, subject: &Subject) -> Outcome {
    run(check, |report| (check.run)(subject, report))
}

/// Runs `work` as a check; an error is a fault.
fn run(check: &'static Check, work: impl FnOnce(&mut Report) -> Result<(), String>) -> Outcome {
    let start = Instant::now();
    let mut report = Report::default();
    if let Err(fault) = work(&mut report) {
        report.fault(fault);
    }
    Outcome {
        check: check.name,
        report,
        duration: start.elapsed(),
    }
}

/// Runs a check in a process of its own, which runs the same program. The program must call [`child_main`] first.
#[must_use]
pub fn run_isolated(check: &'static Check, subject: &Subject) -> Outcome {
    run(check, |report| run_child(check, subject, report))
}

fn run_child(check: &Check, subject: &Subject, report: &mut Report) -> Result<(), String> {
    let program = std::env::current_exe().map_err(|e| format!("unknown test program: {e}"))?;
    let mut child = Command::new(program)
        .arg(ONE_CHECK)
        .arg(check.name)
        .arg(&subject.file)
        .arg(subject.kind.name)
        .arg(subject.id.as_deref().unwrap_or(""))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| format!("the test program cannot be started: {e}"))?;
    let output = child.stdout.take();
    let reader = std::thread::spawn(move || {
        output.map_or_else(String::new, |output| {
            std::io::read_to_string(output).unwrap_or_default()
        })
    });
    let status = wait(&mut child);
    let output = reader.join().unwrap_or_default();
    for line in output.lines() {
        if let Some(fault) = line.strip_prefix("fault ") {
            report.fault(fault);
        } else if let Some(skipped) = line.strip_prefix("skipped ") {
            report.skip(skipped);
        }
    }
    match status {
        None => report.fault("hangs"),
        Some(status) if output.lines().any(|line| line == "done") && status.success() => {}
        Some(status) => report.fault(format!("crashes: {status}")),
    }
    Ok(())
}

/// Waits for a process. Kills it after [`TIMEOUT`] and returns nothing.
fn wait(child: &mut Child) -> Option<ExitStatus> {
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status),
            Ok(None) if start.elapsed() < TIMEOUT => std::thread::sleep(POLL_INTERVAL),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return None;
            }
        }
    }
}

/// Runs the check that [`run_isolated`] started this process for; returns nothing in other processes.
#[must_use]
pub fn child_main() -> Option<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [first, check, file, kind, id] = &arguments[..] else {
        return None;
    };
    if first != ONE_CHECK {
        return None;
    }
    let id = Some(id.clone()).filter(|id| !id.is_empty());
    let (Ok(subject), Some(check)) = (Subject::new(file.into(), kind, id), find(check)) else {
        return Some(ExitCode::from(2));
    };
    disable_error_dialogs();
    let outcome = run_in_process(check, &subject);
    let one_line = |text: &str| text.replace('\n', " ");
    for fault in &outcome.report.faults {
        print_line!("fault {}", one_line(fault));
    }
    for skipped in &outcome.report.skipped {
        print_line!("skipped {}", one_line(skipped));
    }
    print_line!("done");
    Some(ExitCode::SUCCESS)
}

/// Returns the checks whose names contain one of `filters`, or all without filters.
pub(crate) fn select(filters: &[String]) -> Vec<&'static Check> {
    (ALL.iter().copied())
        .filter(|check| filters.is_empty() || filters.iter().any(|f| check.name.contains(f)))
        .collect()
}

/// Runs the checks that `filters` select, each in a process of its own, and calls `report` after each.
pub fn run_all(
    subject: &Subject,
    filters: &[String],
    report: impl Fn(&Outcome) + Sync,
) -> Vec<Outcome> {
    let checks = select(filters);
    in_parallel(&checks, |check| {
        let outcome = run_isolated(check, subject);
        report(&outcome);
        outcome
    })
}

/// Calls `work` on all items, `PARALLEL_CHECKS` at a time, and returns the results in the order in which they are ready.
pub fn in_parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..PARALLEL_CHECKS {
            scope.spawn(|| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::SeqCst)) {
                    let result = work(item);
                    locked(&results).push(result);
                }
            });
        }
    });
    results.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// Prints the causes of faults, those of most checks first, and the number of failures. Succeeds if at least one check ran and
/// none failed.
pub(crate) fn summarize(outcomes: &[Outcome]) -> ExitCode {
    let failed = outcomes.iter().filter(|outcome| !outcome.passed()).count();
    let causes = root_causes(outcomes);
    if !causes.is_empty() {
        print_line!("causes, those of most checks first:");
    }
    for cause in causes {
        print_line!("  {}", cause.text);
        let plural = if cause.faults == 1 { "" } else { "s" };
        print_line!(
            "    {} fault{plural} of {}",
            cause.faults,
            cause.checks.join(", ")
        );
    }
    print_line!("{} checks, {failed} failed", outcomes.len());
    if failed == 0 && !outcomes.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Finds the plugin library that Cargo built beside this test.
///
/// # Errors
/// If it is not there.
pub fn built_plugin(library: &str) -> Result<PathBuf, String> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let name = format!("{DLL_PREFIX}{library}{DLL_SUFFIX}");
    let test = std::env::current_exe().map_err(|e| format!("unknown test program: {e}"))?;
    (test.ancestors().skip(1).take(2))
        .map(|folder| folder.join(&name))
        .find(|path| path.exists())
        .ok_or_else(|| {
            format!(
                "{name} is not beside {}; Cargo builds it for tests if the package is also an rlib",
                test.display()
            )
        })
}

/// The main function of a test without harness: runs all checks on the package's plugin `library`.
#[must_use]
pub fn test_main(library: &str, kind: &str) -> ExitCode {
    if let Some(code) = child_main() {
        return code;
    }
    let filters: Vec<String> = (std::env::args().skip(1))
        .filter(|a| !a.starts_with('-'))
        .collect();
    let subject = match built_plugin(library).and_then(|file| Subject::new(file, kind, None)) {
        Ok(subject) => subject,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let outcomes = run_all(&subject, &filters, |outcome| {
        print_line!("{}", outcome.lines());
    });
    summarize(&outcomes)
}

//! The command line of the host, for its own binary and for tests that are binaries of their own.
//!
//! Every check runs in a process of its own: a plugin may crash or hang, its threads are counted, and nothing of one
//! check is left for the next.

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;
use std::time::Duration;

use crate::checks::{ALL, Check, Report, find};
use crate::host::locked;
use crate::shot::Shot;
use crate::subject::{Subject, kinds};

/// Writes a line; that nobody reads it any more is no reason to panic.
macro_rules! say {
    ($($text:tt)*) => {{
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

/// The first argument of a process that does one check.
const ONE: &str = "--one-check";

/// How long a check may take before it is said to hang. Checks take seconds.
const PATIENCE: Duration = Duration::from_secs(300);

/// What came of one check.
#[derive(Debug)]
pub struct Outcome {
    /// Its name.
    pub check: &'static str,
    /// What it found, as far as it got.
    pub report: Report,
}

impl Outcome {
    /// Whether nothing is wrong.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.report.faults.is_empty()
    }

    /// One line, and one more for each fault.
    #[must_use]
    pub fn lines(&self) -> String {
        let state = if !self.passed() {
            "FAILED"
        } else if self.report.skipped.is_empty() {
            "ok"
        } else {
            "ok, in part"
        };
        let mut text = format!("{:<22} {state}", self.check);
        for skipped in &self.report.skipped {
            text.push_str(&format!("\n    not looked at: {skipped}"));
        }
        for fault in &self.report.faults {
            text.push_str(&format!("\n    {fault}"));
        }
        text
    }
}

/// Does one check in this very process.
#[must_use]
pub fn here(check: &'static Check, subject: &Subject) -> Outcome {
    let mut report = Report::default();
    if let Err(why) = (check.run)(subject, &mut report) {
        report.fault(why);
    }
    Outcome {
        check: check.name,
        report,
    }
}

/// Does one check in a process of its own. The binary of this process must call `if_child` first of all.
#[must_use]
pub fn apart(check: &'static Check, subject: &Subject) -> Outcome {
    let mut report = Report::default();
    if let Err(why) = child(check, subject, &mut report) {
        report.fault(why);
    }
    Outcome {
        check: check.name,
        report,
    }
}

fn child(check: &Check, subject: &Subject, report: &mut Report) -> Result<(), String> {
    let program = std::env::current_exe().map_err(|why| format!("no program to run: {why}"))?;
    let mut child = Command::new(program)
        .arg(ONE)
        .arg(check.name)
        .arg(&subject.file)
        .arg(subject.kind.name)
        .arg(subject.id.as_deref().unwrap_or(""))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|why| format!("cannot be run: {why}"))?;
    let output = child.stdout.take();
    let reader = std::thread::spawn(move || {
        output.map_or_else(String::new, |output| {
            std::io::read_to_string(output).unwrap_or_default()
        })
    });
    let mut waited = Duration::ZERO;
    let step = Duration::from_millis(5);
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break Some(status),
            Ok(None) if waited < PATIENCE => {
                std::thread::sleep(step);
                waited += step;
            }
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
        }
    };
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

/// What a process does that was started to do one check; nothing if it was not.
#[must_use]
pub fn if_child() -> Option<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [first, check, file, kind, id] = &arguments[..] else {
        return None;
    };
    if first != ONE {
        return None;
    }
    let subject = subject(
        file.into(),
        kind,
        Some(id.clone()).filter(|id| !id.is_empty()),
    );
    let (Ok(subject), Some(check)) = (subject, find(check)) else {
        return Some(ExitCode::from(2));
    };
    let outcome = here(check, &subject);
    let flat = |text: &str| text.replace('\n', " ");
    for fault in &outcome.report.faults {
        say!("fault {}", flat(fault));
    }
    for skipped in &outcome.report.skipped {
        say!("skipped {}", flat(skipped));
    }
    say!("done");
    Some(ExitCode::SUCCESS)
}

/// A subject of a kind that is known by name.
///
/// # Errors
/// If no kind is called so.
pub fn subject(file: PathBuf, kind: &str, id: Option<String>) -> Result<Subject, String> {
    let all = kinds();
    let kind = (all.iter().find(|k| k.name == kind)).ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|k| k.name).collect();
        format!("--kind {kind}: is not one of {}", names.join(", "))
    })?;
    Ok(Subject { file, id, kind })
}

/// Checks whose names contain one of `wanted`, or all; two at a time, each told as it ends.
pub fn all(subject: &Subject, wanted: &[String], tell: impl Fn(&Outcome) + Sync) -> Vec<Outcome> {
    let checks: Vec<&'static Check> = (ALL.iter())
        .filter(|check| wanted.is_empty() || wanted.iter().any(|w| check.name.contains(w)))
        .copied()
        .collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                    let Some(check) = checks.get(at) else {
                        break;
                    };
                    let outcome = apart(check, subject);
                    let mut done = locked(&done);
                    tell(&outcome);
                    done.push(outcome);
                }
            });
        }
    });
    done.into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A plugin that cargo has built for the package whose test this process is, by the name of its library.
///
/// # Errors
/// If it is not beside the test.
pub fn built(library: &str) -> Result<PathBuf, String> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let name = format!("{DLL_PREFIX}{library}{DLL_SUFFIX}");
    let own = std::env::current_exe().map_err(|why| format!("no program: {why}"))?;
    (own.ancestors().skip(1).take(2))
        .map(|folder| folder.join(&name))
        .find(|path| path.exists())
        .ok_or_else(|| {
            format!(
                "{name} is not beside {}; it is built if the package is also an rlib",
                own.display()
            )
        })
}

/// The whole of a test, a binary of its own, that all checks pass on a package's plugin.
#[must_use]
pub fn test(library: &str, kind: &str) -> ExitCode {
    if let Some(code) = if_child() {
        return code;
    }
    let wanted: Vec<String> = (std::env::args().skip(1))
        .filter(|a| !a.starts_with('-'))
        .collect();
    let subject = match built(library).and_then(|file| subject(file, kind, None)) {
        Ok(subject) => subject,
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
    };
    let outcomes = all(&subject, &wanted, |outcome| say!("{}", outcome.lines()));
    let failed = outcomes.iter().filter(|outcome| !outcome.passed()).count();
    say!("{} checks, {failed} failed", outcomes.len());
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

const HELP: &str = "\
Usage: seidel-ofx-host PLUGIN [--kind KIND] [--id ID] [--here] [CHECK...]

Runs all checks, or those whose names contain CHECK, on the plugin in a binary (.ofx) or bundle; one line a check, exit
status 1 if any fails.

  --kind KIND  what is known of the plugin: any (the default), box, seidel
  --id ID      the plugin's identifier, where the binary has several
  --here       in this process, not each in one of its own: for debuggers and memory checkers
  --list       what the checks are

       seidel-ofx-host PLUGIN --render OUT --feed CLIP=FILE... [--set KNOB=VALUE...]

Renders one picture to OUT, .exr or .png (for displays of sRGB), and checks nothing but that it is well rendered.

  --feed CLIP=FILE[:CHANNEL]  feeds a clip with an OpenEXR file: its colour, or one channel
  --set KNOB=VALUE            sets a parameter by its name: a number, numbers parted by commas, on or off, the name
                              of a choice, a text; presses a button
  --host HOST                 the kind of host: complete (the default), nuke, resolve, natron, ...
  --time TIME                 the frame, 0 unless told
  --half                      writes it at half its size, means of two by two pixels
  --overlay                   draws what the plugin's overlay draws over the picture";

/// The whole command.
#[must_use]
pub fn main() -> ExitCode {
    if let Some(code) = if_child() {
        return code;
    }
    match asked(std::env::args().skip(1)) {
        Ok(code) => code,
        Err(why) => {
            eprintln!("{why}; see --help");
            ExitCode::from(2)
        }
    }
}

/// What stands before and after the first `=`.
fn parted(option: &str, words: &str) -> Result<(String, String), String> {
    let parts = words.split_once('=');
    let (name, value) = parts.ok_or_else(|| format!("{option} {words}: has no `=`"))?;
    Ok((name.to_owned(), value.to_owned()))
}

/// A clip, its file, and the channel after a colon, where no file is called so.
fn feed(words: &str) -> Result<(String, PathBuf, Option<String>), String> {
    let (clip, file) = parted("--feed", words)?;
    let whole = PathBuf::from(&file);
    Ok(match file.rsplit_once(':') {
        Some((path, channel)) if !whole.exists() => {
            (clip, PathBuf::from(path), Some(channel.to_owned()))
        }
        _ => (clip, whole, None),
    })
}

fn asked(mut arguments: impl Iterator<Item = String>) -> Result<ExitCode, String> {
    let mut file = None;
    let mut kind = "any".to_owned();
    let mut id = None;
    let mut in_place = false;
    let mut wanted = Vec::new();
    let mut shot = Shot::default();
    let mut render = None;
    let mut half = false;
    while let Some(argument) = arguments.next() {
        let mut value = || {
            arguments
                .next()
                .ok_or_else(|| format!("{argument}: needs a value"))
        };
        match argument.as_str() {
            "--kind" => kind = value()?,
            "--id" => id = Some(value()?),
            "--here" => in_place = true,
            "--render" => render = Some(PathBuf::from(value()?)),
            "--feed" => shot.feeds.push(feed(&value()?)?),
            "--set" => shot.settings.push(parted(&argument, &value()?)?),
            "--host" => shot.host = value()?,
            "--time" => {
                let time = value()?;
                shot.time = time
                    .parse()
                    .map_err(|_| format!("--time {time}: is not a number"))?;
            }
            "--overlay" => shot.overlay = true,
            "--half" => half = true,
            "--help" | "-h" => {
                say!("{HELP}");
                return Ok(ExitCode::SUCCESS);
            }
            "--list" => {
                for check in ALL {
                    say!("{:<22} {}", check.name, check.about);
                }
                return Ok(ExitCode::SUCCESS);
            }
            option if option.starts_with('-') => return Err(format!("{option}: is no option")),
            _ if file.is_none() => file = Some(PathBuf::from(argument)),
            _ => wanted.push(argument),
        }
    }
    let file = file.ok_or("no plugin is named")?;
    if let Some(render) = render {
        (shot.plugin, shot.id) = (file, id);
        let made = shot.taken();
        let made = made.map(|picture| if half { picture.halved() } else { picture });
        let done = made.and_then(|picture| crate::files::write(&render, &picture));
        return Ok(done.map_or_else(
            |why| {
                eprintln!("{why}");
                ExitCode::FAILURE
            },
            |()| ExitCode::SUCCESS,
        ));
    }
    let subject = subject(file, &kind, id)?;
    let outcomes = if in_place {
        (ALL.iter())
            .filter(|check| wanted.is_empty() || wanted.iter().any(|w| check.name.contains(w)))
            .map(|check| {
                let outcome = here(check, &subject);
                say!("{}", outcome.lines());
                outcome
            })
            .collect()
    } else {
        all(&subject, &wanted, |outcome| say!("{}", outcome.lines()))
    };
    let failed = outcomes.iter().filter(|outcome| !outcome.passed()).count();
    say!("{} checks, {failed} failed", outcomes.len());
    Ok(if failed == 0 && !outcomes.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

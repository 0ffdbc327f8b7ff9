//! Runs of the `seidel` command: time, memory and end of a run, and the rules that every run keeps.

use std::ffi::OsString;
use std::fs::{self, File};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::allocator::BOUND_BYTES;
use crate::case::Case;
use crate::finding::Kind;

/// Time after which a run is killed: also on a machine with much else to do.
const HUNG: Duration = Duration::from_secs(120);

/// Processor time after which a run is killed, seconds.
const HUNG_PROCESSOR_S: u64 = 20;

/// Memory of the command before it reads anything, bytes: its code, and stacks of its threads.
const BASELINE_BYTES: usize = 128 << 20;

/// Address space of a run, bytes, which protects the machine.
const ADDRESS_BYTES: u64 = 6 << 30;

/// A run of the command.
pub(crate) struct Run {
    words: Vec<OsString>,
    /// Limit of the length of files, bytes.
    pub(crate) file_limit: Option<u64>,
    /// The stdout of the run; a file in the folder of the case if `None`.
    pub(crate) stdout: Option<File>,
}

/// The end of a run.
#[derive(Debug)]
pub(crate) struct Ended {
    /// Exit status, unless a signal ended the run.
    pub(crate) status: Option<i32>,
    pub(crate) signal: Option<i32>,
    pub(crate) stderr: String,
    /// Largest resident memory, bytes.
    pub(crate) memory: usize,
    /// Time of the processor, seconds.
    pub(crate) processor_s: f64,
    /// Whether the limit of the length of files cut the message.
    pub(crate) is_cut: bool,
    /// Whether it was killed because it did not end.
    pub(crate) is_hung: bool,
}

impl Run {
    /// Creates a run of the command in the folder of the case.
    pub(crate) fn new(words: Vec<OsString>) -> Self {
        Self {
            words,
            file_limit: None,
            stdout: None,
        }
    }

    /// Starts the run.
    pub(crate) fn start(self, case: &Case) -> Running {
        let create = |name: &str| {
            let path = case.folder.join(name);
            File::create(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        };
        let mut command = Command::new(&case.program[0]);
        command
            .args(&case.program[1..])
            .args(&self.words)
            .current_dir(case.folder)
            .env_remove("OCIO")
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::null())
            .stdout(self.stdout.unwrap_or_else(|| create("stdout")))
            .stderr(create("stderr"));
        let file_limit = self.file_limit;
        let limit = move || {
            limit_resource(libc::RLIMIT_AS, ADDRESS_BYTES);
            limit_resource(libc::RLIMIT_CORE, 0);
            limit_resource(libc::RLIMIT_CPU, HUNG_PROCESSOR_S);
            if let Some(bytes) = file_limit {
                limit_resource(libc::RLIMIT_FSIZE, bytes);
                // SAFETY: without an action a write over the limit fails, as on a full disk, instead of ending the process.
                unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
            }
            Ok(())
        };
        // SAFETY: the closure calls functions only that are safe between fork and exec, and allocates nothing.
        unsafe { command.pre_exec(limit) };
        let child = command.spawn();
        Running {
            file_limit,
            child: child.unwrap_or_else(|e| panic!("the command does not start: {e}")),
            started: Instant::now(),
        }
    }

    /// Runs to the end.
    pub(crate) fn end(self, case: &Case) -> Ended {
        self.start(case).wait(case.folder)
    }
}

fn limit_resource(resource: libc::__rlimit_resource_t, value: u64) {
    let limit = libc::rlimit {
        rlim_cur: value,
        rlim_max: value,
    };
    // SAFETY: the struct is valid for the call.
    unsafe { libc::setrlimit(resource, &limit) };
}

/// A run that goes on.
pub(crate) struct Running {
    child: Child,
    file_limit: Option<u64>,
    started: Instant,
}

impl Running {
    /// Sends a signal.
    pub(crate) fn send(&self, signal: i32) {
        // SAFETY: the child was not waited for, so that its number is still its own.
        unsafe { libc::kill(self.child.id() as i32, signal) };
    }

    /// Waits for the end, and kills a run that hangs.
    pub(crate) fn wait(self, folder: &Path) -> Ended {
        let mut is_hung = false;
        let mut pause = Duration::from_micros(300);
        loop {
            let mut status = 0;
            // SAFETY: zero is valid for numbers.
            let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
            let id = self.child.id() as i32;
            // SAFETY: both pointers are valid, and the child is not waited for elsewhere.
            let ended = unsafe { libc::wait4(id, &mut status, libc::WNOHANG, &mut usage) };
            if ended != 0 {
                let stderr = fs::read(folder.join("stderr")).unwrap_or_default();
                let has_exited = libc::WIFEXITED(status);
                return Ended {
                    status: has_exited.then(|| libc::WEXITSTATUS(status)),
                    signal: (!has_exited).then(|| libc::WTERMSIG(status)),
                    is_cut: self
                        .file_limit
                        .is_some_and(|limit| stderr.len() as u64 >= limit),
                    stderr: String::from_utf8_lossy(&stderr).into_owned(),
                    memory: usage.ru_maxrss as usize * 1024,
                    processor_s: (usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) as f64
                        + (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) as f64 * 1e-6,
                    is_hung,
                };
            }
            if !is_hung && self.started.elapsed() > HUNG {
                is_hung = true;
                self.send(libc::SIGKILL);
            }
            std::thread::sleep(pause);
            pause = (pause * 5 / 4).min(Duration::from_millis(4));
        }
    }
}

/// Names of files that a message may be about.
pub(crate) struct Names<'a> {
    /// Parts of the command line, one of which an error must contain.
    pub(crate) known: &'a [String],
}

/// Reports everything wrong with the end of a run: its status, memory and message.
pub(crate) fn check_end(case: &mut Case, ended: &Ended, names: &Names) {
    let stderr = ended.stderr.trim();
    if ended.is_hung {
        let text = format!("no end within {} s", HUNG.as_secs());
        case.report(Kind::Slow, text);
        return;
    }
    if let Some(signal) = ended.signal {
        // The hard limit on the time of the processor kills.
        if signal == libc::SIGKILL && ended.processor_s >= HUNG_PROCESSOR_S as f64 - 1.0 {
            let text = format!("no end within {HUNG_PROCESSOR_S} s of the processor");
            case.report(Kind::Slow, text);
            return;
        }
        case.report(Kind::Abort, format!("signal {signal}: {stderr}"));
        return;
    }
    if stderr.contains("panicked at") || ended.status == Some(101) {
        case.report(Kind::Panic, stderr);
    } else if !matches!(ended.status, Some(0..=2)) {
        case.report(Kind::Abort, format!("status {:?}: {stderr}", ended.status));
    }
    if ended.memory > BASELINE_BYTES + BOUND_BYTES {
        case.report(Kind::Memory, format!("{} MiB", ended.memory >> 20));
    }
    if stderr.chars().any(|c| c.is_control() && c != '\n') {
        case.report(Kind::Message, format!("control characters: {stderr}"));
    }
    if matches!(ended.status, Some(1 | 2)) && !ended.is_cut {
        let names_one = names
            .known
            .iter()
            .any(|name| stderr.contains(name.as_str()));
        if stderr.is_empty() || (ended.status == Some(1) && !names_one) {
            case.report(
                Kind::Message,
                format!("names no file and no option: {stderr}"),
            );
        }
    }
}

/// Reports and removes partial outputs in the folder of the case and those below it.
pub(crate) fn check_leftovers(case: &mut Case, folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(".seidel-") && name.ends_with(".part") {
            case.report(Kind::Leftover, name);
            // The next case begins without it.
            remove(&entry.path());
        } else if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            check_leftovers(case, &entry.path());
        }
    }
}

/// Removes files and folders of the case, whatever they are.
pub(crate) fn remove(path: &Path) {
    let is_folder = fs::symlink_metadata(path).is_ok_and(|m| m.is_dir());
    // Best effort: most are missing.
    let _ = if is_folder {
        fs::remove_dir_all(path)
    } else {
        fs::remove_file(path)
    };
}

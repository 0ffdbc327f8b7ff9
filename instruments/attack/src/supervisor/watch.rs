//! One worker process: its lines, its end, and its restart behind the case that ended it.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::allocator::REFUSED;
use crate::finding::{Finding, Kind};
use crate::options::Options;
use crate::targets::Target;

/// Time after which a case counts as hung: also on a machine with much else to do.
const HUNG: Duration = Duration::from_secs(120);

/// The same for whole programs, whose runs the worker itself limits.
const HUNG_PROGRAM: Duration = Duration::from_secs(600);

/// Most restarts within a slice: a target that fails this often has been found out.
const MAX_RESTARTS: usize = 200;

/// The cases that a worker runs.
pub(super) struct Slice {
    pub(super) target: &'static Target,
    pub(super) first: u64,
    pub(super) cases: Option<u64>,
    pub(super) seed: u64,
    pub(super) until: Option<Instant>,
}

/// The folders of a worker, in memory where the system has such a place.
pub(super) struct WorkerFolder {
    /// Holds the folder of cases and that of kept inputs.
    folder: tempfile::TempDir,
    /// The stderr of the worker.
    stderr: tempfile::NamedTempFile,
}

impl WorkerFolder {
    pub(super) fn new() -> Result<Self, String> {
        let memory = Path::new("/dev/shm");
        let place = if memory.is_dir() {
            memory.to_path_buf()
        } else {
            std::env::temp_dir()
        };
        let mut builder = tempfile::Builder::new();
        let builder = builder.prefix("seidel-attack-");
        let failed = |e: std::io::Error| format!("{}: {e}", place.display());
        Ok(Self {
            folder: builder.tempdir_in(&place).map_err(failed)?,
            stderr: builder.tempfile_in(&place).map_err(failed)?,
        })
    }

    /// Returns the folder in which cases run.
    fn of_cases(&self) -> PathBuf {
        self.folder.path().join("case")
    }

    /// Returns the folder of kept inputs, a folder a case.
    fn kept(&self) -> PathBuf {
        self.folder.path().join("kept")
    }

    /// Returns the folder with the inputs of a case: those that the worker kept, or those of a case that ended the worker.
    pub(super) fn inputs_of(&self, number: u64) -> PathBuf {
        let kept = self.kept().join(number.to_string());
        if kept.is_dir() { kept } else { self.of_cases() }
    }

    /// Removes all inputs.
    fn clear(&self) -> Result<(), String> {
        for folder in [self.of_cases(), self.kept()] {
            // Best effort: a file that remains is overwritten by the next case.
            let _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        Ok(())
    }

    /// Returns the last words of the worker on stderr.
    fn last_words(&self) -> String {
        let mut bytes = Vec::new();
        if let Ok(mut file) = File::open(self.stderr.path()) {
            // Best effort: the words are an addition to the exit status.
            let _ = file.read_to_end(&mut bytes);
        }
        let tail = bytes.len().saturating_sub(300);
        String::from_utf8_lossy(&bytes[tail..]).trim().to_owned()
    }
}

/// Runs workers on the cases of a slice. Returns the number of runs.
pub(super) fn run_worker(
    slice: &Slice,
    options: &Options,
    folder: &WorkerFolder,
    found: &mut dyn FnMut(u64, Finding),
) -> Result<u64, String> {
    let mut state = Progress {
        runs: 0,
        next: slice.first,
    };
    let last = slice.cases.map(|count| slice.first + count);
    for _ in 0..MAX_RESTARTS {
        // The folder of the last case stays, so that its inputs can be kept.
        if last.is_some_and(|last| state.next >= last) {
            break;
        }
        folder.clear()?;
        if watch(slice, options, folder, found, &mut state)? == End::Done {
            break;
        }
    }
    Ok(state.runs)
}

/// The progress of a slice over its workers.
struct Progress {
    runs: u64,
    next: u64,
}

#[derive(PartialEq, Eq)]
enum End {
    Done,
    Restart,
}

fn watch(
    slice: &Slice,
    options: &Options,
    folder: &WorkerFolder,
    found: &mut dyn FnMut(u64, Finding),
    state: &mut Progress,
) -> Result<End, String> {
    let mut child = start(slice, options, folder, state.next)?;
    let lines = read_lines(&mut child);
    let hung = if slice.target.is_program() {
        HUNG_PROGRAM
    } else {
        HUNG
    };
    let mut begun: Option<u64> = None;
    loop {
        match lines.recv_timeout(hung) {
            Ok(line) => {
                let mut words = line.splitn(4, ' ');
                let verb = words.next().unwrap_or_default();
                let number = words.next().and_then(|n| n.parse().ok()).unwrap_or(0);
                match verb {
                    "begin" => {
                        begun = Some(number);
                        state.next = number + 1;
                    }
                    "end" => {
                        state.runs += 1;
                        begun = None;
                        // Best effort, to save memory. The inputs of a last case stay, as they may be asked for.
                        if slice.cases != Some(1) {
                            let _ = fs::remove_dir_all(folder.kept().join(number.to_string()));
                        }
                        if slice.until.is_some_and(|until| Instant::now() >= until) {
                            stop(&mut child);
                            return Ok(End::Done);
                        }
                    }
                    "finding" => {
                        let kind = words.next().and_then(Kind::named);
                        let text = words.next().unwrap_or_default().to_owned();
                        if let Some(kind) = kind {
                            found(number, Finding { kind, text });
                        }
                    }
                    _ => {}
                }
            }
            Err(RecvTimeoutError::Timeout) => {
                stop(&mut child);
                state.runs += 1;
                let text = format!("no end within {} s", hung.as_secs());
                found(begun.unwrap_or(state.next), Finding::new(Kind::Slow, text));
                return Ok(behind(begun));
            }
            Err(RecvTimeoutError::Disconnected) => {
                let status = child.wait().map_err(|e| e.to_string())?;
                if status.success() {
                    return Ok(End::Done);
                }
                state.runs += 1;
                found(begun.unwrap_or(state.next), of_status(status, folder));
                return Ok(behind(begun));
            }
        }
    }
}

/// A worker that ended before its first case would end there again.
fn behind(begun: Option<u64>) -> End {
    match begun {
        Some(_) => End::Restart,
        None => End::Done,
    }
}

fn of_status(status: std::process::ExitStatus, folder: &WorkerFolder) -> Finding {
    let words = folder.last_words();
    if words.contains(REFUSED) {
        let text = format!("more than 1 GiB over the start of the case: {words}");
        return Finding::new(Kind::Memory, text);
    }
    let end = match status.signal() {
        Some(signal) => format!("signal {signal}"),
        None => format!("{status}"),
    };
    Finding::new(Kind::Abort, format!("{end}: {words}"))
}

fn start(
    slice: &Slice,
    options: &Options,
    folder: &WorkerFolder,
    first: u64,
) -> Result<Child, String> {
    let own = std::env::current_exe().map_err(|e| e.to_string())?;
    let stderr = File::create(folder.stderr.path()).map_err(|e| e.to_string())?;
    let mut command = Command::new(own);
    command
        .args(["--worker", slice.target.name])
        .args(["--first", &first.to_string()])
        .args(["--seed", &slice.seed.to_string()])
        .arg("--folder")
        .arg(folder.of_cases())
        .arg("--kept")
        .arg(folder.kept());
    if let Some(cases) = slice.cases {
        let left = slice.first + cases - first;
        command.args(["--cases", &left.to_string()]);
    }
    if slice.cases == Some(1) || first > slice.first {
        command.arg("--no-twins");
    }
    if let Some(program) = &options.program {
        command.arg("--program").arg(program);
    }
    // One thread a worker: the cores are shared by workers.
    command
        .env("RAYON_NUM_THREADS", "1")
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(stderr);
    command.spawn().map_err(|e| format!("a worker: {e}"))
}

fn read_lines(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = channel();
    if let Some(stdout) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines() {
                let Ok(line) = line else { break };
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
    }
    receiver
}

fn stop(child: &mut Child) {
    // Best effort: it may have ended by itself.
    let _ = child.kill();
    let _ = child.wait();
}

//! Signals at random instants: no partial output remains, and outputs are old or new files and folders as a whole.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::program::Program;
use super::{Attack, Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::process::{Names, Run, check_end, check_leftovers, remove};

pub(crate) static TARGET: Target = Target {
    name: "kill",
    about: "SIGINT, SIGTERM, SIGHUP and SIGKILL at random instants of a run",
    weight: 1.0,
    method: Method::Program(|folder| {
        Program::new(folder);
        Box::new(Kill {
            sound: vec![None; LINES.len()],
        })
    }),
};

/// Content of an output file before a run.
const OLD: &[u8] = b"an older output";

/// Frames of the sequence.
const FRAMES: [u32; 3] = [1, 2, 3];

const SIGNALS: [i32; 4] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP, libc::SIGKILL];

/// A command line with its outputs, each of which is old or new as a whole.
struct Line {
    words: &'static str,
    outputs: &'static [&'static str],
    /// Whether outputs are folders, which do not exist before the run.
    are_folders: bool,
}

const LINES: [Line; 4] = [
    Line {
        words: "apply --lens lens.json --distance 2 --quality draft --frames 1-3 in.%d.exr -o out.%d.exr",
        outputs: &["out.1.exr", "out.2.exr", "out.3.exr"],
        are_folders: false,
    },
    Line {
        words: "psf --lens lens.json --like set --out out",
        outputs: &["out"],
        are_folders: true,
    },
    Line {
        words: "fit set --model moments -o out.json",
        outputs: &["out.json"],
        are_folders: false,
    },
    Line {
        words: "lut -o out.cube --in-space ACEScg --out-space ACES2065-1 --size 9 --range 0,1",
        outputs: &["out.cube"],
        are_folders: false,
    },
];

/// The files of an output by their path within it; the path of an output that is a file itself is empty.
type Files = BTreeMap<PathBuf, Vec<u8>>;

struct Kill {
    /// A run of each line without a signal.
    sound: Vec<Option<SoundRun>>,
}

#[derive(Clone)]
struct SoundRun {
    /// The files of each output.
    outputs: Vec<Files>,
    time: Duration,
}

impl Line {
    fn run(&self) -> Run {
        Run::new(self.words.split(' ').map(OsString::from).collect())
    }

    /// Puts the outputs into their state before the run.
    fn reset(&self, case: &mut Case) {
        for name in self.outputs {
            remove(&case.folder.join(name));
            if !self.are_folders {
                case.write(name, OLD);
            }
        }
    }

    fn files(&self, folder: &Path) -> Vec<Files> {
        let outputs = self.outputs.iter();
        outputs.map(|name| files_of(&folder.join(name))).collect()
    }

    /// Runs without a signal.
    fn run_sound(&self, case: &mut Case) -> SoundRun {
        for frame in FRAMES {
            let from = case.folder.join("plate.exr");
            let copied = fs::copy(from, case.folder.join(format!("in.{frame}.exr")));
            assert!(copied.is_ok(), "the attack cannot copy a plate");
        }
        self.reset(case);
        let started = Instant::now();
        let ended = self.run().end(case);
        let time = started.elapsed();
        assert_eq!(ended.status, Some(0), "{}", ended.stderr);
        let outputs = self.files(case.folder);
        SoundRun { outputs, time }
    }

    fn check_outputs(&self, case: &mut Case, sound: &SoundRun) {
        let old = if self.are_folders {
            Files::new()
        } else {
            Files::from([(PathBuf::new(), OLD.to_vec())])
        };
        let found = self.files(case.folder);
        for ((name, found), new) in self.outputs.iter().zip(&found).zip(&sound.outputs) {
            if *found != old && found != new {
                let bytes: usize = found.values().map(Vec::len).sum();
                let text = format!(
                    "{name} is neither old nor new ({} files, {bytes} bytes)",
                    found.len()
                );
                case.report(Kind::SilentChange, text);
            }
        }
    }
}

/// Returns the files of an output: a file, or a folder with folders; none if it does not exist.
fn files_of(output: &Path) -> Files {
    let mut files = Files::new();
    let mut rest = vec![PathBuf::new()];
    while let Some(at) = rest.pop() {
        let path = if at.as_os_str().is_empty() {
            output.to_path_buf()
        } else {
            output.join(&at)
        };
        if path.is_dir() {
            let entries = fs::read_dir(&path).into_iter().flatten().flatten();
            rest.extend(entries.map(|entry| at.join(entry.file_name())));
        } else if let Ok(bytes) = fs::read(&path) {
            files.insert(at, bytes);
        }
    }
    files
}

impl Attack for Kill {
    fn seeds(&self) -> usize {
        SIGNALS.len() * LINES.len()
    }

    fn run(&mut self, case: &mut Case) {
        let seed = case.seed_index(self.seeds());
        let signal = SIGNALS[seed % SIGNALS.len()];
        let (line, sound) = (&LINES[seed / SIGNALS.len()], &mut self.sound);
        let sound = &mut sound[seed / SIGNALS.len()];
        let sound = sound.get_or_insert_with(|| line.run_sound(case));
        case.is_accepted = true;
        line.reset(case);
        let running = line.run().start(case);
        if case.inputs == Inputs::Damaged {
            std::thread::sleep(sound.time.mul_f64(1.1 * case.rng.share()));
            running.send(signal);
        }
        let ended = running.wait(case.folder);
        let expected = [Some(0), Some(128 + signal)];
        let is_by_signal = ended.signal == Some(signal);
        if !is_by_signal && !expected.contains(&ended.status) {
            let names = Names {
                known: &[String::new()],
            };
            check_end(case, &ended, &names);
            let text = format!("signal {signal}: {:?}: {}", ended.status, ended.stderr);
            case.report(Kind::Abort, text);
        }
        line.check_outputs(case, sound);
        if signal == libc::SIGKILL {
            // The next run of the same outputs removes what is left.
            let again = line.run().end(case);
            if again.status != Some(0) {
                case.report(Kind::Abort, format!("the next run fails: {}", again.stderr));
            }
            if line.files(case.folder) != sound.outputs {
                case.report(Kind::SilentChange, "the next run gives other outputs");
            }
        }
        check_leftovers(case, case.folder);
    }
}

//! Signals at random instants: no partial output remains, and outputs are old or new files as a whole.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use super::program::Program;
use super::{Attack, Sort, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::process::{Names, Run, check_end, check_leftovers, remove};

pub(crate) static TARGET: Target = Target {
    name: "kill",
    about: "SIGINT, SIGTERM, SIGHUP and SIGKILL at random instants of a run",
    sort: Sort::Program,
    weight: 1.0,
    start: |folder| {
        Program::new(folder);
        Box::new(Kill {
            sound: Vec::new(),
            time: Duration::ZERO,
        })
    },
};

/// Content of an output before a run.
const OLD: &[u8] = b"an older output";

/// Frames of a run.
const FRAMES: [u32; 3] = [1, 2, 3];

const SIGNALS: [i32; 4] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP, libc::SIGKILL];

struct Kill {
    /// Outputs of a run without a signal, and its duration.
    sound: Vec<Vec<u8>>,
    time: Duration,
}

fn run() -> Run {
    let line =
        "apply --lens lens.json --distance 2 --quality draft --frames 1-3 in.%d.exr -o out.%d.exr";
    Run::new(line.split(' ').map(OsString::from).collect())
}

fn out(folder: &Path, frame: u32) -> std::path::PathBuf {
    folder.join(format!("out.{frame}.exr"))
}

impl Kill {
    /// Runs once without a signal.
    fn run_sound(&mut self, case: &mut Case) {
        for frame in FRAMES {
            let from = case.folder.join("plate.exr");
            let copied = fs::copy(from, case.folder.join(format!("in.{frame}.exr")));
            assert!(copied.is_ok(), "the attack cannot copy a plate");
        }
        let started = Instant::now();
        let ended = run().end(case);
        self.time = started.elapsed();
        assert_eq!(ended.status, Some(0), "{}", ended.stderr);
        self.sound = FRAMES
            .iter()
            .map(|&frame| fs::read(out(case.folder, frame)).unwrap_or_default())
            .collect();
    }
}

impl Attack for Kill {
    fn seeds(&self) -> usize {
        SIGNALS.len()
    }

    fn run(&mut self, case: &mut Case) {
        if self.sound.is_empty() {
            self.run_sound(case);
        }
        case.is_accepted = true;
        for frame in FRAMES {
            remove(&out(case.folder, frame));
            case.write(&format!("out.{frame}.exr"), OLD);
        }
        let signal = SIGNALS[case.seed_index(SIGNALS.len())];
        let running = run().start(case);
        if case.inputs == Inputs::Damaged {
            std::thread::sleep(self.time.mul_f64(1.1 * case.rng.share()));
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
        self.check_outputs(case);
        if signal == libc::SIGKILL {
            // The next run of the same outputs removes what is left.
            let again = run().end(case);
            if again.status != Some(0) {
                case.report(Kind::Abort, format!("the next run fails: {}", again.stderr));
            }
            let is_new = (FRAMES.iter().zip(&self.sound))
                .all(|(&frame, new)| fs::read(out(case.folder, frame)).is_ok_and(|b| b == *new));
            if !is_new {
                case.report(Kind::SilentChange, "the next run gives other outputs");
            }
        }
        check_leftovers(case, case.folder);
    }
}

impl Kill {
    fn check_outputs(&self, case: &mut Case) {
        for (&frame, new) in FRAMES.iter().zip(&self.sound) {
            let bytes = fs::read(out(case.folder, frame)).unwrap_or_default();
            if bytes != OLD && bytes != *new {
                let text = format!(
                    "out.{frame}.exr is neither old nor new ({} bytes)",
                    bytes.len()
                );
                case.report(Kind::SilentChange, text);
            }
        }
    }
}

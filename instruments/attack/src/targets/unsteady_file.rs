//! Inputs that vanish, grow or are truncated while they are read, and inputs and outputs that are no files.

use std::ffi::{CString, OsString};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::Duration;

use super::program::{Program, known_names};
use super::{Attack, Method, Target};
use crate::case::{Case, Inputs};
use crate::process::{Names, Run, check_end, check_leftovers, remove};

pub(crate) static TARGET: Target = Target {
    name: "unsteady-file",
    about: "inputs that vanish, grow or are truncated; pipes, devices, folders and loops of links",
    weight: 1.0,
    method: Method::Program(|folder| {
        Box::new(Unsteady {
            program: Program::new(folder),
        })
    }),
};

struct Unsteady {
    program: Program,
}

/// A command line with the input that is made unsteady.
struct Line {
    words: &'static str,
    input: &'static str,
}

const LINES: [Line; 7] = [
    Line {
        words: "apply --lens lens.json --distance 2 --quality draft plate.exr -o out.exr",
        input: "plate.exr",
    },
    Line {
        words: "apply --lens lens.json --distance 2 --quality draft plate.exr -o out.exr",
        input: "lens.json",
    },
    Line {
        words: "apply --lens lens.json --depth depth.exr --quality draft plate.exr -o out.exr",
        input: "depth.exr",
    },
    Line {
        words: "lut plate.exr -o out.exr --ocio config.ocio --in-space Camera --out-space ACEScg",
        input: "config.ocio",
    },
    Line {
        words: "info plate.exr",
        input: "plate.exr",
    },
    Line {
        words: "psf --lens lens.json --like set --out out",
        input: "set/manifest.json",
    },
    Line {
        words: "apply --lens lens.json --distance 2 --quality draft plate.exr -o out.exr",
        input: "out.exr",
    },
];

impl Attack for Unsteady {
    fn seeds(&self) -> usize {
        LINES.len()
    }

    fn run(&mut self, case: &mut Case) {
        let line = &LINES[case.seed_index(LINES.len())];
        for name in [
            "plate.exr",
            "lens.json",
            "config.ocio",
            "depth.exr",
            "set/manifest.json",
            "out.exr",
            "out",
        ] {
            remove(&case.folder.join(name));
        }
        self.program.write_sound(case.folder);
        let copied = fs::copy(case.folder.join("plate.exr"), case.folder.join("depth.exr"));
        assert!(copied.is_ok(), "the attack cannot copy a plate");
        let words: Vec<OsString> = line.words.split(' ').map(OsString::from).collect();
        let known = known_names(&words);
        let disturber = match case.inputs {
            Inputs::Sound => None,
            Inputs::Damaged => disturb(case, &case.folder.join(line.input)),
        };
        let ended = Run::new(words).end(case);
        if let Some(disturber) = disturber {
            // Its result does not matter: the file may be gone.
            let _ = disturber.join();
        }
        case.is_accepted = ended.status == Some(0);
        check_end(case, &ended, &Names { known: &known });
        check_leftovers(case, case.folder);
    }
}

/// Replaces the input, or changes it after a random time in another thread.
fn disturb(case: &mut Case, path: &Path) -> Option<JoinHandle<()>> {
    let pause = Duration::from_micros(case.rng.below(25_000) as u64);
    let length = case.rng.below(4000) as u64;
    let owned = path.to_path_buf();
    let later = |change: fn(&Path, u64)| {
        Some(std::thread::spawn(move || {
            std::thread::sleep(pause);
            change(&owned, length);
        }))
    };
    match case.rng.below(12) {
        0 => later(|path, _| remove(path)),
        1 => later(|path, length| {
            if let Ok(file) = OpenOptions::new().write(true).open(path) {
                let _ = file.set_len(length);
            }
        }),
        2 | 3 => later(|path, length| {
            if let Ok(mut file) = OpenOptions::new().append(true).open(path) {
                let _ = file.write_all(&vec![0x5a; 40 * length as usize]);
            }
        }),
        kind => {
            remove(path);
            match kind {
                4 => make_pipe(path),
                5 => drop(symlink("/dev/zero", path)),
                6 => drop(symlink("/dev/full", path)),
                7 => drop(fs::create_dir(path)),
                8 => drop(symlink(path, path)),
                9 => drop(symlink("no-such-file", path)),
                10 => drop(symlink("/dev/null", path)),
                _ => drop(symlink(path.parent().unwrap_or(path), path)),
            }
            None
        }
    }
}

/// Creates a named pipe that nobody writes to.
fn make_pipe(path: &Path) {
    let Ok(name) = CString::new(path.as_os_str().as_bytes()) else {
        return;
    };
    // SAFETY: the name ends with a zero.
    unsafe { libc::mkfifo(name.as_ptr(), 0o600) };
}

//! Full disks: a limit on the length of files at random lengths, and a full device as standard output.

use std::ffi::OsString;
use std::fs::File;

use super::program::{COMMANDS, Program, command_of, known_names};
use super::{Attack, Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::process::{Names, Run, check_end, check_leftovers, remove};

pub(crate) static TARGET: Target = Target {
    name: "full-disk",
    about: "writes that fail at random lengths, and a full standard output",
    weight: 1.0,
    method: Method::Program(|folder| {
        Program::new(folder);
        Box::new(FullDisk)
    }),
};

struct FullDisk;

/// Outputs of the commands.
const OUTPUTS: [&str; 10] = [
    "out.exr",
    "out.png",
    "out.tif",
    "out.dpx",
    "out.hdr",
    "out.json",
    "out.svg",
    "out.cube",
    "out",
    "sheet.png",
];

impl Attack for FullDisk {
    fn seeds(&self) -> usize {
        COMMANDS.len()
    }

    fn run(&mut self, case: &mut Case) {
        let line = command_of(case);
        let words: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
        for name in OUTPUTS {
            remove(&case.folder.join(name));
        }
        let known = known_names(&words);
        let mut run = Run::new(words);
        // Standard output is limited too, as it is a file here.
        let is_stdout_full = case.rng.once_in(3);
        if case.inputs == Inputs::Damaged {
            if is_stdout_full {
                run.stdout = File::options().write(true).open("/dev/full").ok();
            } else {
                run.file_limit = Some(case.rng.below(6000) as u64);
            }
        }
        let ended = run.end(case);
        case.is_accepted = ended.status == Some(0);
        check_end(case, &ended, &Names { known: &known });
        check_leftovers(case, case.folder);
        let output = OUTPUTS.iter().find(|name| case.folder.join(name).exists());
        if let (Some(1), false, Some(name)) = (ended.status, is_stdout_full, output) {
            case.report(
                Kind::Leftover,
                format!("{name} after a failure: {}", ended.stderr),
            );
        }
    }
}

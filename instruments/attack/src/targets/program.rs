//! Runs of the whole command with damaged inputs and hostile values of options.

mod commands;

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use seidel_image_io::plate::{PlateFile, PlateOptions};

use super::{Attack, Method, Target};
use crate::case::{Case, Inputs};
use crate::finding::Kind;
use crate::mutations::{BINARY, EXR, JSON, Mutation, PNG, TEXT, TIFF, text};
use crate::process::{Names, Run, check_end, check_leftovers, remove};
use crate::seeds::{self, exr, lenses, photographs, raster, texts};

pub(crate) use commands::{COMMANDS, command_of};

pub(crate) static TARGET: Target = Target {
    name: "program",
    about: "runs of every command with damaged inputs and hostile values of options",
    weight: 6.0,
    method: Method::Program(|folder| Box::new(Program::new(folder))),
};

/// An input file with its seed.
pub(crate) struct Input {
    pub(crate) name: &'static str,
    pub(crate) seeds: Vec<Vec<u8>>,
    mutations: &'static [Mutation],
}

/// Inputs of commands.
pub(crate) struct Program {
    inputs: Vec<Input>,
    /// Names in the folder before the first case.
    names: BTreeSet<OsString>,
    /// Index of the input that the last case damaged.
    damaged: Option<usize>,
}

impl Program {
    /// Makes all inputs in `folder`.
    pub(crate) fn new(folder: &Path) -> Self {
        let plate = folder.join("plate.exr");
        exr::write_plate(&plate);
        let set = folder.join("set");
        lenses::write_set(&set, 24);
        let list = "psf/0000.exr\npsf/0001.exr\npsf/0002.exr\npsf/0003.exr\n";
        let input = |name, seeds, mutations| Input {
            name,
            seeds,
            mutations,
        };
        let mut plates = vec![seeds::read(&plate)];
        plates.extend(exr::files(folder).into_iter().skip(1).take(20));
        let inputs = vec![
            input("plate.exr", plates, EXR),
            input("plate.png", raster::png(folder), PNG),
            input("plate.tif", raster::tiff(folder), TIFF),
            input("plate.dpx", raster::dpx(folder), BINARY),
            input("plate.hdr", raster::hdr(folder), BINARY),
            input("plate.jpg", raster::jpeg(), BINARY),
            input("photo.dng", photographs::dng(), TIFF),
            input("lens.json", vec![lenses::lens().into_bytes()], JSON),
            input(
                "set/manifest.json",
                vec![seeds::read(&set.join("manifest.json"))],
                JSON,
            ),
            input(
                "set/psf/0001.exr",
                vec![seeds::read(&set.join("psf/0001.exr"))],
                EXR,
            ),
            input("table.csv", texts::animations(), TEXT),
            input("list.txt", vec![list.as_bytes().to_vec()], TEXT),
            input("config.ocio", texts::configs(), TEXT),
        ];
        let mut program = Self {
            inputs,
            names: BTreeSet::new(),
            damaged: None,
        };
        program.write_sound(folder);
        program.names = names_in(folder).collect();
        program
    }

    /// Writes the first seed of every input.
    pub(crate) fn write_sound(&self, folder: &Path) {
        for input in &self.inputs {
            raster::write(&folder.join(input.name), &input.seeds[0]);
        }
    }

    /// Damages one of the inputs that the command reads. Returns its index.
    fn damage_input(&self, case: &mut Case, words: &[OsString]) -> Option<usize> {
        let is_read = |input: &Input| {
            let first = input.name.split('/').next().unwrap_or_default();
            words.iter().any(|word| word == first)
        };
        let read: Vec<usize> = (0..self.inputs.len())
            .filter(|&k| is_read(&self.inputs[k]))
            .collect();
        if read.is_empty() {
            return None;
        }
        let index = *case.rng.pick(&read);
        let input = &self.inputs[index];
        let seed = case.rng.pick(&input.seeds).clone();
        let bytes = case.damage(seed, &input.seeds, input.mutations);
        case.write(input.name, &bytes);
        Some(index)
    }
}

/// Names of outputs of all commands.
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

impl Attack for Program {
    fn seeds(&self) -> usize {
        COMMANDS.len()
    }

    fn run(&mut self, case: &mut Case) {
        let line = command_of(case);
        let mut words: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
        if case.inputs == Inputs::Damaged {
            if !case.rng.once_in(4) {
                self.damaged = self.damage_input(case, &words);
            }
            if self.damaged.is_none() || case.rng.once_in(4) {
                change_word(case, &mut words);
            }
        }
        let shown: Vec<u8> = words.join(OsStr::new("\n")).as_bytes().to_vec();
        case.write("words.txt", &shown);
        let known = known_names(&words);
        let ended = Run::new(words).end(case);
        case.is_accepted = ended.status == Some(0);
        check_end(case, &ended, &Names { known: &known });
        check_leftovers(case, case.folder);
        if ended.status == Some(0) {
            check_finite(case);
        } else if case.inputs == Inputs::Sound {
            case.report(Kind::Refused, ended.stderr);
        } else if OUTPUTS.iter().any(|name| case.folder.join(name).is_file())
            && ended.status == Some(2)
        {
            case.report(Kind::Leftover, "an output of a refused command line");
        }
    }

    fn clean_up(&mut self, folder: &Path) {
        if let Some(index) = self.damaged.take() {
            let input = &self.inputs[index];
            raster::write(&folder.join(input.name), &input.seeds[0]);
        }
        // A later case must not read what this one wrote: alone it would end otherwise.
        for name in names_in(folder).filter(|name| !self.names.contains(name)) {
            remove(&folder.join(name));
        }
    }
}

fn names_in(folder: &Path) -> impl Iterator<Item = OsString> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name())
}

/// Returns the parts of a command line that an error may name: files and options.
pub(crate) fn known_names(words: &[OsString]) -> Vec<String> {
    let text = words.iter().map(|word| word.to_string_lossy().into_owned());
    let mut known: Vec<String> = text.filter(|word| !word.is_empty()).collect();
    // Messages about settings have their names without dashes, and control characters of words as escapes.
    let names = known.iter().filter_map(|word| word.strip_prefix("--"));
    let names: Vec<String> = names
        .filter(|name| !name.is_empty())
        .map(str::to_owned)
        .collect();
    known.extend(names);
    // A channel of a file is named without its file, and the file without its channel.
    let files = known.iter().filter_map(|word| word.split_once(':'));
    let files: Vec<String> = files.map(|(file, _)| file.to_owned()).collect();
    known.extend(files.into_iter().filter(|file| !file.is_empty()));
    known.extend([r"\u001b[2J", r"\u202ex"].map(str::to_owned));
    known.extend(
        [
            "manifest.json",
            "psf/",
            "--",
            "standard output",
            "/dev/stdout",
        ]
        .map(str::to_owned),
    );
    known
}

/// Replaces a value of an option by a hostile one, or adds, drops or repeats a word.
fn change_word(case: &mut Case, words: &mut Vec<OsString>) {
    const VALUES: [&str; 22] = [
        "",
        " ",
        "..",
        "-",
        "--",
        "=",
        "%d",
        "####",
        "inf",
        "R=0",
        "R=1,R=2",
        "0,0",
        "1,2,3",
        "auto",
        "@",
        "a:b",
        "lens.json",
        "set",
        "missing.exr",
        "plate.exr:Z",
        "\u{1b}[2J",
        "\u{202e}x",
    ];
    let at = 1 + case.rng.below(words.len() - 1);
    let number = OsString::from(*case.rng.pick(&text::NUMBERS));
    match case.rng.below(9) {
        0 => {
            words.remove(at);
        }
        1 => words.insert(at, words[at].clone()),
        2 => words[at] = OsStr::from_bytes(b"\xff\xfe.exr").into(),
        3 => words[at] = "x".repeat(*case.rng.pick(&[255, 5000])).into(),
        4 | 5 => words[at] = OsString::from(*case.rng.pick(&VALUES)),
        _ => {
            // Mostly the value of a number.
            let is_number = |w: &OsString| {
                w.to_string_lossy()
                    .starts_with(|c: char| c.is_ascii_digit())
            };
            let numbers: Vec<usize> = (1..words.len()).filter(|&k| is_number(&words[k])).collect();
            let at = if numbers.is_empty() {
                at
            } else {
                *case.rng.pick(&numbers)
            };
            words[at] = number;
        }
    }
}

/// Reports samples of outputs that are not finite, where inputs were.
fn check_finite(case: &mut Case) {
    let path = case.folder.join("out.exr");
    if !path.is_file() {
        return;
    }
    match PlateFile::open(&path, &PlateOptions::default()) {
        Ok(out) => {
            let input = PlateFile::open(&case.folder.join("plate.exr"), &PlateOptions::default());
            let was_finite = input.is_ok_and(|input| input.non_finite().is_empty());
            if let (Some(bad), true) = (out.non_finite().first(), was_finite) {
                case.report(Kind::SilentChange, bad.to_string());
            }
        }
        Err(error) => {
            // Output without colour is possible where the input has none.
            if fs::metadata(&path).is_ok_and(|m| m.len() == 0) {
                case.report(Kind::SilentChange, error.to_string());
            }
        }
    }
}

//! Lists of observations: `--only`, `--except`, by the command in this process.

use std::ffi::OsString;
use std::path::Path;

use super::{Attack, Sort, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::lenses;

const NAME: &str = "list.txt";

pub(crate) static TARGET: Target = Target {
    name: "lists",
    about: "lists of observations and of channel scales, by the command in this process",
    sort: Sort::InProcess,
    weight: 0.5,
    start: |folder| Box::new(Lists::new(folder)),
};

struct Lists {
    seeds: Vec<Vec<u8>>,
}

impl Lists {
    fn new(folder: &Path) -> Self {
        let set = lenses::write_set(&folder.join("set"), 2);
        let names: Vec<&str> = set.observations.iter().map(|o| o.file.as_str()).collect();
        let list = format!("# a list\n{}\n\n", names.join("\n"));
        let one = format!("{}\n", names[0]);
        Self {
            seeds: vec![list.into_bytes(), one.into_bytes()],
        }
    }
}

impl Attack for Lists {
    fn seeds(&self) -> usize {
        self.seeds.len()
    }

    fn run(&mut self, case: &mut Case) {
        let bytes = case.damaged(&self.seeds, TEXT);
        let path = case.write(NAME, &bytes);
        let words: Vec<OsString> = vec![
            "seidel".into(),
            "eval".into(),
            // The lens is missing on purpose where the list is valid: only the list is read in full.
            "--lens".into(),
            write_lens(case).into(),
            "--only".into(),
            path.into(),
            "--splits".into(),
            "2".into(),
            case.folder.join("set").into(),
        ];
        let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
        let mut console = seidel::Console {
            stdout: &mut stdout,
            stderr: &mut stderr,
            progress: seidel::ProgressOutput::hidden(),
        };
        let status = seidel::run(words, &mut console);
        let message = String::from_utf8_lossy(&stderr).into_owned();
        case.is_accepted = status == 0;
        if status != 0 {
            // A valid list may leave too few observations of the set.
            let is_of_set = message.contains("manifest.json") || message.contains("set:");
            case.check_error(&message, if is_of_set { "" } else { NAME });
        }
        if message.chars().any(|c| c.is_control() && c != '\n') {
            case.report(Kind::Message, format!("control characters: {message}"));
        }
    }
}

/// Writes the lens once.
fn write_lens(case: &mut Case) -> std::path::PathBuf {
    let path = case.folder.join("lens.json");
    if !path.exists() {
        case.write("lens.json", lenses::lens().as_bytes());
    }
    path
}

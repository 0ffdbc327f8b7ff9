//! Lists of observations: `--only`, `--except`, by the command in this process.

use std::ffi::OsString;
use std::path::Path;

use super::reader::Reader;
use super::{Method, Target};
use crate::case::Case;
use crate::finding::Kind;
use crate::mutations::TEXT;
use crate::seeds::lenses;

pub(crate) static TARGET: Target = Target {
    name: "lists",
    about: "lists of observations and of channel scales, by the command in this process",
    weight: 0.5,
    method: Method::Reader(Reader {
        file: "list.txt",
        seeds: lists,
        mutations: |_| TEXT,
        read,
    }),
};

fn lists(folder: &Path) -> Vec<Vec<u8>> {
    let set = lenses::write_set(&folder.join("set"), 2);
    let names: Vec<&str> = set.observations.iter().map(|o| o.file.as_str()).collect();
    let list = format!("# a list\n{}\n\n", names.join("\n"));
    let one = format!("{}\n", names[0]);
    vec![list.into_bytes(), one.into_bytes()]
}

fn read(case: &mut Case, path: &Path) {
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
        case.check_error(&message, if is_of_set { "" } else { "list.txt" });
    }
    if message.chars().any(|c| c.is_control() && c != '\n') {
        case.report(Kind::Message, format!("control characters: {message}"));
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

//! Files that follow from the core's table of knobs: settings in Python, comments in the C header, and the table of the guide.

mod guide;
pub(crate) mod header;
mod python;

use std::fs;
use std::path::Path;

use seidel_core::{Knob, KnobKind};

/// Returns each file that is generated whole, with its text.
pub(crate) fn files() -> [(&'static str, String); 2] {
    [(python::PATH, python::text()), (guide::PATH, guide::text())]
}

/// Writes the files; returns a report.
pub(crate) fn write(root: &Path) -> Result<String, String> {
    let files = files();
    for (path, text) in &files {
        fs::write(root.join(path), text).map_err(|e| format!("{path}: {e}"))?;
    }
    let paths = files.map(|(path, _)| path);
    Ok(format!("knobs: wrote {}", paths.join(" and ")))
}

/// Returns the default of a knob; `None` for a number that is left out.
fn default_text(knob: &Knob) -> Option<String> {
    match &knob.kind {
        KnobKind::Number(number) => number.default.map(|value| value.to_string()),
        KnobKind::Choice(choice) => Some(choice.options[choice.default].word.to_owned()),
        KnobKind::Switch(switch) => Some(if switch.default { "on" } else { "off" }.to_owned()),
    }
}

/// Breaks `text` into lines of at most `width` characters.
fn lines(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

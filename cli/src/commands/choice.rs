//! Selection of the observations of a set by lists of names.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::ObservationSet;

use super::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::json::{TEXT_LIMIT_BYTES, read_text};

/// Options that select observations.
#[derive(Debug, Args)]
#[command(next_help_heading = "Choice of observations")]
pub(super) struct ChoiceArgs {
    /// Text file with the observations to use, one per line, such as psf/0003.exr; empty lines and lines that start with #
    /// are ignored
    #[arg(long, value_name = "FILE")]
    only: Option<PathBuf>,
    /// Text file with the observations to leave out, in the same format
    #[arg(long, value_name = "FILE")]
    except: Option<PathBuf>,
}

impl ChoiceArgs {
    /// Keeps the selected observations in `sets`; a name selects from every set that has it.
    pub(super) fn restrict(&self, sets: &mut [ObservationSet]) -> Result<(), CommandError> {
        let lists = [
            (self.only.as_deref().map(names).transpose()?, true),
            (self.except.as_deref().map(names).transpose()?, false),
        ];
        let lists: Vec<_> = lists
            .into_iter()
            .filter_map(|(list, keep)| Some((list?, keep)))
            .collect();
        for (list, _) in &lists {
            list.check(sets)?;
        }
        for (list, keep) in &lists {
            for set in sets.iter_mut() {
                let kept = |file: &String| list.names.contains(file) == *keep;
                set.observations.retain(|o| kept(&o.file));
            }
            if sets.iter().all(|set| set.observations.is_empty()) {
                let remedy = "choose at least one observation";
                return Err(FileError::new(&list.path, "", "leaves no observation", remedy).into());
            }
        }
        Ok(())
    }

    /// Returns a description of the selection for the provenance; empty without a selection.
    pub(super) fn describe(&self) -> String {
        let part = |word: &str, path: &Option<PathBuf>| {
            path.as_deref().map_or(String::new(), |p| {
                format!(", {word} {}", super::short_name(p))
            })
        };
        part("only", &self.only) + &part("except", &self.except)
    }
}

/// A list of observation names from a file.
struct Names {
    path: PathBuf,
    names: HashSet<String>,
    /// The names with their lines, counted from 1.
    lines: Vec<(usize, String)>,
}

fn names(path: &Path) -> Result<Names, CommandError> {
    let text = read_text(path, TEXT_LIMIT_BYTES)?;
    let lines = text.lines().enumerate();
    let lines = lines.map(|(index, line)| (index + 1, line.trim().to_owned()));
    let lines: Vec<(usize, String)> = lines
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .collect();
    Ok(Names {
        path: path.to_path_buf(),
        names: lines.iter().map(|(_, name)| name.clone()).collect(),
        lines,
    })
}

impl Names {
    /// Rejects names that no set has. The message gives the line and not the name: the file may be another one by mistake,
    /// whose content does not belong in a log.
    fn check(&self, sets: &[ObservationSet]) -> Result<(), CommandError> {
        let known: HashSet<&str> = sets
            .iter()
            .flat_map(|set| &set.observations)
            .map(|o| o.file.as_str())
            .collect();
        let mut unknown = (self.lines.iter()).filter(|(_, name)| !known.contains(name.as_str()));
        let Some((line, _)) = unknown.next() else {
            return Ok(());
        };
        let more = match unknown.count() {
            0 => String::new(),
            1 => ", and neither does 1 more line".to_owned(),
            count => format!(", and neither do {count} more lines"),
        };
        Err(FileError::new(
            &self.path,
            format!("line {line}"),
            format!("names no observation of any set{more}"),
            "write the names as `file` has them in the manifest",
        )
        .into())
    }
}

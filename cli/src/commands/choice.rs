//! Which observations of a set take part: those named in a file, or all but those.

use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::observations::ObservationSet;

use super::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::json::{TEXT_LIMIT_BYTES, read_text};

/// Options about which observations take part.
#[derive(Debug, Args)]
pub(super) struct ChoiceArgs {
    /// Use only the observations named in this text file: one a line, such as psf/0003.exr; empty
    /// lines and those that begin with # are skipped
    #[arg(long, value_name = "FILE")]
    only: Option<PathBuf>,
    /// Leave out the observations named in this text file, likewise
    #[arg(long, value_name = "FILE")]
    except: Option<PathBuf>,
}

impl ChoiceArgs {
    /// Leaves in `sets` the chosen observations; a name holds for every set that has it.
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

    /// What was chosen, in words; empty where all take part.
    pub(super) fn describe(&self) -> String {
        let part = |word: &str, path: &Option<PathBuf>| {
            path.as_deref().map_or(String::new(), |p| {
                format!(", {word} {}", super::short_name(p))
            })
        };
        part("only", &self.only) + &part("except", &self.except)
    }
}

/// Observations named in a file.
struct Names {
    path: PathBuf,
    names: Vec<String>,
}

fn names(path: &Path) -> Result<Names, CommandError> {
    let text = read_text(path, TEXT_LIMIT_BYTES)?;
    let lines = text.lines().map(str::trim);
    Ok(Names {
        path: path.to_path_buf(),
        names: lines
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
            .map(str::to_owned)
            .collect(),
    })
}

impl Names {
    /// Refuses names that no set has.
    fn check(&self, sets: &[ObservationSet]) -> Result<(), CommandError> {
        let known: std::collections::HashSet<&str> = sets
            .iter()
            .flat_map(|set| &set.observations)
            .map(|o| o.file.as_str())
            .collect();
        let mut unknown = self.names.iter().filter(|n| !known.contains(n.as_str()));
        let Some(first) = unknown.next() else {
            return Ok(());
        };
        let more = match unknown.count() {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        Err(FileError::new(
            &self.path,
            "",
            format!("names `{first}`{more}, which no observation is called"),
            "write the names as `file` has them in the manifest",
        )
        .into())
    }
}

//! The error type of everything that opens files.

use std::fmt;
use std::path::{Path, PathBuf};

use seidel_optics::error::{Error, Fault};

/// The result of an operation on a file.
pub type Result<T> = std::result::Result<T, FileError>;

/// An error about a file: where, what is wrong and what to do about it.
///
/// It is displayed as `FILE: FIELD: PROBLEM; REMEDY`, or as one line for each fault.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// A single fault.
    One {
        /// The path of the file, as the user gave it.
        file: PathBuf,
        /// The field, channel or line at fault; empty for the file as a whole.
        field: String,
        /// The fault.
        problem: String,
        /// Advice to the user.
        remedy: String,
    },
    /// All faults that were found in an observation set.
    Many {
        /// The path of the manifest.
        file: PathBuf,
        /// The faults, in the order of the manifest.
        faults: Vec<Fault>,
    },
}

impl FileError {
    /// Creates an error about one `field` of `file`, or about the whole file if `field` is empty.
    pub fn new(
        file: impl Into<PathBuf>,
        field: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::One {
            file: file.into(),
            field: field.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// Returns the problem alone, without file, field and remedy.
    pub fn problem(&self) -> String {
        match self {
            Self::One { problem, .. } => problem.clone(),
            Self::Many { .. } => self.to_string(),
        }
    }

    /// Creates an error from all faults of the observation set whose manifest is `file`.
    pub fn many(file: impl Into<PathBuf>, faults: Vec<Fault>) -> Self {
        Self::Many {
            file: file.into(),
            faults,
        }
    }

    /// Creates an error from one of the core about values read from or meant for `file`.
    pub fn from_core(file: impl Into<PathBuf>, error: Error) -> Self {
        Self::new(file, error.place, error.problem, error.remedy)
    }

    /// Creates an error from one of the operating system; `action` is the passive infinitive of the failed
    /// operation, such as "be read".
    pub fn io(file: &Path, action: &str, error: &std::io::Error) -> Self {
        use std::io::ErrorKind;
        let remedy = match error.kind() {
            ErrorKind::NotFound => "check the path",
            ErrorKind::PermissionDenied => "check the permissions of the file and its folder",
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
                "free some space or write elsewhere"
            }
            _ => "check that the file and its disk are in order",
        };
        Self::new(file, "", format!("cannot {action} ({error})"), remedy)
    }

    /// Creates the error of a damaged or truncated file.
    pub(crate) fn damaged(file: &Path, problem: &str) -> Self {
        Self::new(
            file,
            "",
            format!("is damaged or truncated ({problem})"),
            "copy or render the file again",
        )
    }

    /// Returns the same error, with the folder `to` in place of `from` at the start of its path.
    pub(crate) fn moved(mut self, from: &Path, to: &Path) -> Self {
        let (Self::One { file, .. } | Self::Many { file, .. }) = &mut self;
        if let Ok(within) = file.strip_prefix(from) {
            // Joining nothing would add a slash.
            *file = if within.as_os_str().is_empty() {
                to.to_path_buf()
            } else {
                to.join(within)
            };
        }
        self
    }

    /// Returns the path of the file.
    pub fn file(&self) -> &Path {
        match self {
            Self::One { file, .. } | Self::Many { file, .. } => file,
        }
    }

    /// Converts the error into faults of observation `index`, whose tile the manifest calls `name`.
    pub(crate) fn into_faults(self, index: usize, name: &str) -> Vec<Fault> {
        match self {
            Self::Many { faults, .. } => faults,
            Self::One {
                field,
                problem,
                remedy,
                ..
            } => vec![Fault {
                observation: Some(index),
                file: name.to_owned(),
                field: if field.is_empty() {
                    "file".to_owned()
                } else {
                    field
                },
                problem,
                remedy,
            }],
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One {
                file,
                field,
                problem,
                remedy,
            } => {
                write!(f, "{}: ", file.display())?;
                if !field.is_empty() {
                    write!(f, "{field}: ")?;
                }
                write!(f, "{problem}; {remedy}")
            }
            Self::Many { file, faults } => match faults.as_slice() {
                [fault] => write!(f, "{}: {fault}", file.display()),
                _ => {
                    write!(f, "{}: {} faults", file.display(), faults.len())?;
                    for fault in faults {
                        write!(f, "\n  {fault}")?;
                    }
                    Ok(())
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_for_one_problem_and_one_a_fault() {
        let one = FileError::new("a.exr", "channel R", "is missing", "add it");
        assert_eq!(one.to_string(), "a.exr: channel R: is missing; add it");
        let whole = FileError::new("a.exr", "", "is empty", "write it again");
        assert_eq!(whole.to_string(), "a.exr: is empty; write it again");
        let mut faults = one.into_faults(3, "psf/0003.exr");
        assert_eq!(
            FileError::many("m.json", faults.clone()).to_string(),
            "m.json: observation 3 (psf/0003.exr) channel R: is missing; add it"
        );
        faults.extend(whole.into_faults(4, "b.exr"));
        let text = FileError::many("m.json", faults).to_string();
        assert_eq!(text.lines().count(), 3, "{text}");
        assert!(text.contains("observation 4 (b.exr) file: is empty"));
    }
}

//! Exceptions: the errors of the core and of files, with their kind and remedy.

use pyo3::prelude::*;
use seidel_core::{ErrorKind, Fault, Knob};
use seidel_image_io::FileError;

/// A failed call.
pub(crate) enum Failure {
    /// An error of the core.
    Core(seidel_core::Error),
    /// An error about a file or an observation set.
    File(FileError),
    /// All faults of an observation set that was made from arrays.
    Faults(Vec<Fault>),
    /// An exception of Python, such as one that the progress callback raised.
    Python(PyErr),
    /// A panic of the core.
    Panic,
}

pub(crate) type Result<T> = std::result::Result<T, Failure>;

/// An exception of the package before it is created: its class in `seidel._errors` and its attributes.
struct Exception {
    class: &'static str,
    kind: &'static str,
    message: String,
    place: String,
    remedy: String,
}

impl Failure {
    /// Creates the failure of the argument `name`.
    pub(crate) fn argument(
        name: &str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Core(seidel_core::Error::new(name, problem, remedy))
    }

    /// Creates the failure of a call that its progress callback stopped.
    pub(crate) fn cancelled() -> Self {
        Self::Core(seidel_core::Error::cancelled("the call"))
    }
}

impl From<seidel_core::Error> for Failure {
    fn from(mut error: seidel_core::Error) -> Self {
        if let Some(knob) = Knob::named(&error.place) {
            error.place = format!("settings.{}", knob.identifier());
        }
        error.remedy = in_python(&error.remedy);
        Self::Core(error)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        let exception = match failure {
            Failure::Python(error) => return error,
            Failure::Core(error) => Exception::of_core(&error),
            Failure::File(error) => Exception::of_file(&error),
            Failure::Faults(faults) => Exception {
                class: "InvalidInput",
                kind: "invalid_input",
                remedy: remedies(&faults),
                message: FileError::many("observations", faults).to_string(),
                place: "observations".to_owned(),
            },
            Failure::Panic => Exception {
                class: "InternalError",
                kind: "internal",
                message:
                    "an internal error stopped the call; please report it with the call's arguments"
                        .to_owned(),
                place: String::new(),
                remedy: "please report it with the call's arguments".to_owned(),
            },
        };
        Python::attach(|py| exception.create(py).unwrap_or_else(|error| error))
    }
}

impl Exception {
    fn of_core(error: &seidel_core::Error) -> Self {
        let (class, kind) = match error.kind() {
            ErrorKind::Unsupported => ("Unsupported", "unsupported"),
            ErrorKind::InsufficientData => ("InsufficientData", "insufficient_data"),
            ErrorKind::Cancelled => ("Cancelled", "cancelled"),
            _ => ("InvalidInput", "invalid_input"),
        };
        Self {
            class,
            kind,
            message: error.to_string(),
            place: error.place.clone(),
            remedy: error.remedy.clone(),
        }
    }

    fn of_file(error: &FileError) -> Self {
        let remedy = match error {
            FileError::One { remedy, .. } => remedy.clone(),
            FileError::Many { faults, .. } => remedies(faults),
        };
        Self {
            class: "FileError",
            kind: "file",
            message: error.to_string(),
            place: error.file().display().to_string(),
            remedy,
        }
    }

    /// Creates the exception; an exception of Python if that fails.
    fn create(&self, py: Python<'_>) -> PyResult<PyErr> {
        let class = py.import("seidel._errors")?.getattr(self.class)?;
        let exception = class.call1((&self.message,))?;
        exception.setattr("kind", self.kind)?;
        exception.setattr("place", &self.place)?;
        exception.setattr("remedy", &self.remedy)?;
        Ok(PyErr::from_value(exception))
    }
}

/// Returns the distinct remedies of `faults`.
fn remedies(faults: &[Fault]) -> String {
    let mut remedies: Vec<&str> = Vec::new();
    for fault in faults {
        if !remedies.contains(&fault.remedy.as_str()) {
            remedies.push(&fault.remedy);
        }
    }
    remedies.join("; ")
}

/// Terms of the core, each with what a program in Python gives for it.
const TERMS: [(&str, &str); 7] = [
    ("Image::replace_non_finite", "Settings(scrub=True)"),
    (
        "give depth_m (null for infinity)",
        "give depth, in metres (math.inf for infinity)",
    ),
    ("null for infinity", "math.inf for infinity"),
    ("depth kind", "depth kind (DepthPass.kind)"),
    ("depth unit", "depth unit (DepthPass.unit)"),
    (
        "near and far distances",
        "near and far distances (DepthPass.near and far)",
    ),
    (
        "distances are along the ray",
        "distances are along the ray (DepthPass.along_ray)",
    ),
];

/// Returns `message` with the names of Python for the [`TERMS`] of the core.
pub(crate) fn in_python(message: &str) -> String {
    let replaced = |message: String, (term, name): &(&str, &str)| message.replacen(term, name, 1);
    TERMS.iter().fold(message.to_owned(), replaced)
}

/// Issues doubts about a depth pass, one sentence each, as `seidel.DepthWarning`s.
pub(crate) fn warn_of_depth(py: Python<'_>, doubts: &[String]) -> PyResult<()> {
    if doubts.is_empty() {
        return Ok(());
    }
    let category = py.import("seidel._errors")?.getattr("DepthWarning")?;
    let issue = py.import("warnings")?.getattr("warn")?;
    for doubt in doubts {
        issue.call1((in_python(doubt), &category))?;
    }
    Ok(())
}

/// Issues `warnings`, one sentence each, as `UserWarning`s of Python.
pub(crate) fn warn<S: AsRef<str>>(py: Python<'_>, warnings: &[S]) -> PyResult<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    let issue = py.import("warnings")?.getattr("warn")?;
    for warning in warnings {
        issue.call1((warning.as_ref(),))?;
    }
    Ok(())
}

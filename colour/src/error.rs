//! What can go wrong with colour, and how it is said.

/// Result of an operation on colour.
pub type Result<T> = std::result::Result<T, ColourError>;

/// A refusal that names the config, the place in it, what is wrong and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{config}: {}{problem}; {remedy}", place(field))]
pub struct ColourError {
    /// The config as it was given, or another text at fault.
    pub config: String,
    /// The space, role or line at fault; empty for the config as a whole.
    pub field: String,
    /// What is wrong with it.
    pub problem: String,
    /// What the user can do.
    pub remedy: String,
}

fn place(field: &str) -> String {
    match field {
        "" => String::new(),
        field => format!("{field}: "),
    }
}

impl ColourError {
    /// A refusal of one `field` of `config`, or of all of it where `field` is empty.
    pub fn new(
        config: impl Into<String>,
        field: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            config: config.into(),
            field: field.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

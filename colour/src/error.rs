//! Errors of colour management.

/// Result of an operation on colour.
pub type Result<T> = std::result::Result<T, ColourError>;

/// An error that names the config, the place in it, the problem and a remedy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{config}: {}{problem}; {remedy}", place(field))]
pub struct ColourError {
    /// Name of the config or other text at fault.
    pub config: String,
    /// Space, role or line at fault; empty for the config as a whole.
    pub field: String,
    /// The problem there.
    pub problem: String,
    /// The remedy: what the user can do.
    pub remedy: String,
}

fn place(field: &str) -> String {
    if field.is_empty() {
        String::new()
    } else {
        format!("{field}: ")
    }
}

impl ColourError {
    /// Creates an error about one `field` of `config`, or about all of it if `field` is empty.
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

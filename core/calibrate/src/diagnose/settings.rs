//! Settings of a diagnosis.

/// Settings of [`super::diagnose`].
#[derive(Debug, Clone)]
pub struct Settings {
    /// Identifiers of the effects to try; all if empty.
    pub library: Vec<String>,
    /// Whether pairs of effects are tried.
    pub pairs: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            library: Vec::new(),
            pairs: true,
        }
    }
}

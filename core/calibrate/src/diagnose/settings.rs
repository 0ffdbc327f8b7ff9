//! Settings of a diagnosis.

use super::pair::TileResponse;
use seidel_optics::observations::ObservationSet;

/// Settings of [`super::diagnose`].
#[derive(Debug, Clone)]
pub struct DiagnosisSettings {
    /// Identifiers of the effects to try; all if empty.
    pub library: Vec<String>,
    /// Whether pairs of effects are tried.
    pub pairs: bool,
    /// The set that the lens was fitted to; needed where its profile does not say what its model leaves.
    pub design: Option<ObservationSet>,
    /// Responses of the estimator of the tiles, by observation and channel; none for measured tiles.
    pub responses: Vec<Vec<TileResponse>>,
}

impl Default for DiagnosisSettings {
    fn default() -> Self {
        Self {
            library: Vec::new(),
            pairs: true,
            design: None,
            responses: Vec::new(),
        }
    }
}

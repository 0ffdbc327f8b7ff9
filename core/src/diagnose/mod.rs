//! The sim-to-real gap: where a lens and observations differ, which effect the lens lacks, and how far the
//! gap shrinks once it is added.

mod diagnosis;
mod pair;
mod settings;

pub use diagnosis::{
    Cause, Diagnosis, Example, Gap, Order, Pair, Place, Shape, TileGap, Value, Verdict,
};
pub use pair::{PairEstimate, PairSettings, Picture, estimate_pair};
pub use settings::{Progress, Settings};

use crate::error::{Error, Result};
use crate::observations::ObservationSet;
use crate::profile::LensProfile;

/// Diagnoses the gap between `lens` and `seen`.
///
/// # Errors
/// A lens described by moments, another frame or channels than the lens's, unknown distances where the
/// lens depends on them, too few observations, and a stop on request.
pub fn diagnose(
    _lens: &LensProfile,
    _seen: &ObservationSet,
    _settings: &Settings,
    _progress: &Progress,
) -> Result<Diagnosis> {
    Err(Error::new("diagnosis", "is not built", "wait"))
}

//! The gap between a lens and measured PSFs, and its causes.

use seidel_calibrate::diagnose::{self, Diagnosis, Settings as DiagnosisSettings};
use seidel_optics::Progress;
use seidel_optics::error::Result;
use seidel_optics::observations::ObservationSet;

use crate::lens::Lens;

/// Diagnoses the gap between `lens` and the measured PSFs of `set`: which effects the lens lacks, and how far the gap
/// closes on PSFs held out once they are added.
///
/// # Errors
/// A lens described by moments, a set of another frame or other channels, too few observations, an unknown effect, and
/// cancellation by `progress`.
pub fn diagnose(
    lens: &Lens,
    set: &ObservationSet,
    settings: &DiagnosisSettings,
    progress: &Progress,
) -> Result<Diagnosis> {
    diagnose::diagnose(lens.profile(), set, settings, progress)
}

//! The gap between a lens and measured PSFs, and its causes.

use seidel_calibrate::diagnose::{self, Diagnosis, DiagnosisSettings};
use seidel_optics::Progress;
use seidel_optics::error::Result;
use seidel_optics::observations::ObservationSet;

use crate::lens::Lens;

/// Diagnoses the gap between `lens` and the measured PSFs of `set`: the effects that the lens lacks, their probabilities,
/// and how far the gap closes on held-out PSFs once they are added. It takes minutes for a hundred PSFs in three channels.
///
/// ```no_run
/// # fn gap(lens: &seidel_core::Lens, set: &seidel_core::ObservationSet) -> seidel_core::Result<()> {
/// use seidel_core::{DiagnosisSettings, Lens, diagnose, no_progress};
///
/// let diagnosis = diagnose(lens, set, &DiagnosisSettings::default(), &no_progress)?;
/// let causes = diagnosis.added.join(", ");
/// let corrected = Lens::new(diagnosis.corrected)?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// A lens fitted as [`Model::Moments`](crate::Model::Moments), a set of another frame or other channels, too few
/// observations, an unknown effect, and cancellation by `progress`.
pub fn diagnose(
    lens: &Lens,
    set: &ObservationSet,
    settings: &DiagnosisSettings,
    progress: &Progress,
) -> Result<Diagnosis> {
    diagnose::diagnose(lens.profile(), set, settings, progress)
}

//! The gap between a lens and PSFs estimated from a pair of pictures.

use seidel_calibrate::diagnose::{
    self, Diagnosis, DiagnosisSettings, PairEstimate, PairImage, PairSettings, estimate_pair,
};
use seidel_optics::error::{ErrorKind, Result};
use seidel_optics::field::ImagePoint;
use seidel_optics::profile::LensProfile;
use seidel_optics::{Progress, effects};

use crate::lens::Lens;

/// Share of the progress that an estimate of PSFs takes, and that it and its diagnosis take: there may be two of both.
const ESTIMATE_SHARE: f64 = 0.1;
const PASS_SHARE: f64 = 0.5;

/// A pair of pictures of one flat scene, one sharp, one through the lens, with the channels of the lens.
#[derive(Debug, Clone)]
pub struct PicturePair<'a> {
    /// The sharp picture.
    pub reference: PairImage<'a>,
    /// The picture through the lens.
    pub observed: PairImage<'a>,
    /// Position of the optical axis, frame pixels; that of the lens if `None`.
    pub axis: Option<ImagePoint>,
    /// Settings of the estimate of PSFs.
    pub estimate: PairSettings,
}

/// A diagnosis, and the PSFs that it is of.
#[derive(Debug, Clone)]
pub struct PictureDiagnosis {
    /// The diagnosis.
    pub diagnosis: Diagnosis,
    /// The estimated PSFs, with the camera and pixel pitch of the lens: pictures do not say theirs.
    pub estimate: PairEstimate,
}

/// Estimates PSFs from `pair` and diagnoses the gap between them and `lens`, as [`diagnose`](crate::diagnose()) does. If effects are
/// found, it does both once more from the corrected lens: estimates deviate from the lens that they start from by only a part of
/// the difference where the pictures show little.
///
/// All effects but `tone_curve` are tried if `settings.library` is empty: a tone curve acts on the light of a plate, which PSFs
/// do not show. `settings.responses` are ignored.
///
/// # Errors
/// Those of [`estimate_pair`] and of [`diagnose`](crate::diagnose()), and an axis outside the frame.
pub fn diagnose_pictures(
    lens: &Lens,
    pair: &PicturePair,
    settings: &DiagnosisSettings,
    progress: &Progress,
) -> Result<PictureDiagnosis> {
    let stage = |start: f64, length: f64| move |share| progress(start + length * share);
    let rest = PASS_SHARE - ESTIMATE_SHARE;
    let profile = lens.profile();
    let estimate = pair.estimated_from(profile, &stage(0.0, ESTIMATE_SHARE))?;
    let mut found = diagnosed(profile, estimate, settings, &stage(ESTIMATE_SHARE, rest))?;
    if !found.diagnosis.added.is_empty() {
        let corrected = found.diagnosis.corrected.clone();
        match pair.estimated_from(&corrected, &stage(PASS_SHARE, ESTIMATE_SHARE)) {
            Ok(again) => {
                let share = stage(PASS_SHARE + ESTIMATE_SHARE, rest);
                found = diagnosed(profile, again, settings, &share)?;
            }
            Err(error) if error.kind() != ErrorKind::Cancelled => {
                found.diagnosis.remarks.push(format!(
                    "PSFs could not be estimated again from the corrected lens: {error}"
                ));
            }
            Err(error) => return Err(error),
        }
    }
    progress(1.0);
    Ok(found)
}

impl PicturePair<'_> {
    /// Estimates the PSFs, starting from those of `lens`.
    fn estimated_from(&self, lens: &LensProfile, progress: &Progress) -> Result<PairEstimate> {
        let frame = match self.axis {
            Some(axis) => lens.frame.with_axis(axis)?,
            None => lens.frame,
        };
        let placed = LensProfile {
            frame,
            ..lens.clone()
        };
        let (sharp, plate) = (&self.reference, &self.observed);
        let mut estimate = estimate_pair(&placed, sharp, plate, &self.estimate, progress)?;
        estimate.set.camera = lens.camera.clone();
        estimate.set.pixel_pitch_um = lens.pixel_pitch_um;
        Ok(estimate)
    }
}

/// Diagnoses `lens` against `estimate`.
fn diagnosed(
    lens: &LensProfile,
    estimate: PairEstimate,
    settings: &DiagnosisSettings,
    progress: &Progress,
) -> Result<PictureDiagnosis> {
    let all = || {
        let shown = effects::ALL.iter().filter(|e| e.description().in_pictures);
        shown.map(|effect| effect.id().to_owned()).collect()
    };
    let settings = DiagnosisSettings {
        library: Some(settings.library.clone())
            .filter(|library| !library.is_empty())
            .unwrap_or_else(all),
        responses: estimate.responses.clone(),
        ..settings.clone()
    };
    Ok(PictureDiagnosis {
        diagnosis: diagnose::diagnose(lens, &estimate.set, &settings, progress)?,
        estimate,
    })
}

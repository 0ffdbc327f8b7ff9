//! Diagnosis of the gap between a lens and PSFs estimated from a pair of pictures.

use pyo3::prelude::*;
use seidel_core::calibrate::diagnose::{
    Diagnosis, PairEstimate, PairGeometry, PairImage, PairSettings, estimate_pair,
};
use seidel_core::profile::LensProfile;
use seidel_core::{DiagnosisSettings, ImagePoint, Progress, effects};

use crate::array::ArrayPlanes;
use crate::depth::object_distance;
use crate::error::{Failure, Result};
use crate::lens::Lens;
use crate::observations::{self, ObservationSet};
use crate::worker::CallOptions;

/// Share of the progress that an estimate of PSFs takes, and that it and its diagnosis take: there may be two of both.
const ESTIMATE_SHARE: f64 = 0.1;
const PASS_SHARE: f64 = 0.5;

/// A pair of pictures with the settings of their diagnosis.
struct PicturePair {
    lens: LensProfile,
    /// The lens with the axis of the pictures.
    axis: Option<ImagePoint>,
    reference: ArrayPlanes,
    observed: ArrayPlanes,
    pair: PairSettings,
    settings: DiagnosisSettings,
}

/// A diagnosis with the PSFs that it is of.
pub(crate) struct PictureDiagnosis {
    pub(crate) diagnosis: Diagnosis,
    pub(crate) estimate: PairEstimate,
}

impl PicturePair {
    /// Estimates the PSFs, starting from those of `lens`.
    fn estimate(&self, lens: &LensProfile, progress: &Progress) -> Result<PairEstimate> {
        let frame = match self.axis {
            Some(axis) => lens.frame.with_axis(axis)?,
            None => lens.frame,
        };
        let placed = LensProfile {
            frame,
            ..lens.clone()
        };
        let (reference, observed) = (image(&self.reference), image(&self.observed));
        let mut estimate = estimate_pair(&placed, &reference, &observed, &self.pair, progress)?;
        // The pictures do not say which camera took them.
        estimate.set.camera = lens.camera.clone();
        estimate.set.pixel_pitch_um = lens.pixel_pitch_um;
        Ok(estimate)
    }

    /// Diagnoses the lens against `estimate`.
    fn diagnose_against(
        &self,
        estimate: PairEstimate,
        progress: &Progress,
    ) -> Result<PictureDiagnosis> {
        let settings = DiagnosisSettings {
            responses: estimate.responses.clone(),
            ..self.settings.clone()
        };
        let lens = seidel_core::Lens::new(self.lens.clone())?;
        Ok(PictureDiagnosis {
            diagnosis: seidel_core::diagnose(&lens, &estimate.set, &settings, progress)?,
            estimate,
        })
    }

    /// Diagnoses the lens, a second time against PSFs estimated from the corrected lens: they deviate less from it.
    fn diagnose(&self, progress: &Progress) -> Result<PictureDiagnosis> {
        let stage = |start: f64, length: f64| move |share| progress(start + length * share);
        let rest = PASS_SHARE - ESTIMATE_SHARE;
        let estimate = self.estimate(&self.lens, &stage(0.0, ESTIMATE_SHARE))?;
        let mut found = self.diagnose_against(estimate, &stage(ESTIMATE_SHARE, rest))?;
        if !found.diagnosis.added.is_empty() {
            let corrected = found.diagnosis.corrected.clone();
            match self.estimate(&corrected, &stage(PASS_SHARE, ESTIMATE_SHARE)) {
                Ok(again) => {
                    let share = stage(PASS_SHARE + ESTIMATE_SHARE, rest);
                    found = self.diagnose_against(again, &share)?;
                }
                Err(Failure::Core(error)) if !is_cancelled(&error) => {
                    found.diagnosis.remarks.push(format!(
                        "PSFs could not be estimated again from the corrected lens: {error}"
                    ));
                }
                Err(error) => return Err(error),
            }
        }
        let count = found.estimate.set.observations.len();
        found.diagnosis.remarks.push(format!(
            "{count} PSFs were estimated from reference and observed; they were not measured"
        ));
        found.diagnosis.remarks.extend(found.estimate.remarks());
        progress(1.0);
        Ok(found)
    }
}

fn is_cancelled(error: &seidel_core::Error) -> bool {
    error.kind() == seidel_core::ErrorKind::Cancelled
}

fn image(array: &ArrayPlanes) -> PairImage<'_> {
    PairImage {
        width: array.layout.width,
        height: array.layout.height,
        planes: &array.planes,
        quantisation: None,
    }
}

/// Reads a picture with the channels of `lens`.
fn read(name: &str, array: &Bound<'_, PyAny>, lens: &[&str]) -> Result<ArrayPlanes> {
    let read = ArrayPlanes::read(name, array)?;
    if read.planes.len() != lens.len() {
        return Err(Failure::argument(
            name,
            format!("has {} channels", read.planes.len()),
            format!("give those of the lens: {}", lens.join(", ")),
        ));
    }
    let width = read.layout.width;
    for (plane, channel) in read.planes.iter().zip(lens) {
        if let Some(at) = plane.iter().position(|sample| !sample.is_finite()) {
            return Err(Failure::argument(
                name,
                format!(
                    "is {} in {channel} at row {}, column {}",
                    plane[at],
                    at / width,
                    at % width
                ),
                "give finite samples",
            ));
        }
    }
    Ok(read)
}

/// Adds the function to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(diagnose_pictures, module)?)
}

/// Finds the effects that `lens` lacks against a pair of pictures of one flat scene with fine texture: one sharp, one through
/// the real lens, registered pixel by pixel. PSFs are estimated from the pair and diagnosed as by `diagnose`.
///
/// - `lens`: a lens of the kind `"pupil"`.
/// - `reference`, `observed`: the sharp picture and that through the lens, rows x columns x channels, `float32` or `float16`,
///   scene-linear, in the order of `lens.channels`. One of them fills the frame of the lens.
/// - `distance`: distance of the scene in metres, `math.inf` for infinity; needed where the blur depends on it.
/// - `patch`: side of the estimated tiles in pixels: odd, and larger than the widest blur.
/// - `axis`: position (x, y) of the optical axis, frame pixels; that of the lens if `None`.
/// - `clip`: level from which pixels are treated as clipped and ignored; none if `None`. Pictures converted from integers need
///   it, just below full scale.
/// - `reference_pixels`: `"points"` where the picture through the lens was blurred from the sharp one by a program, `"areas"`
///   where both are photographs.
/// - `geometry`: `"undistorted"` or `"distorted"` by the lens; measured if `None`.
/// - `only`, `pairs`, `design`, `threads`, `progress`: as for `diagnose`. All effects but `tone_curve` are tried if `only` is `None`.
///
/// Returns a `Diagnosis`, whose `estimated` holds the PSFs. Raises `InvalidInput`, `Unsupported` for a lens fitted in moments,
/// `InsufficientData` and `Cancelled`.
#[pyfunction]
#[pyo3(signature = (
    lens, reference, observed, *, distance=None, patch=33, axis=None, clip=None, reference_pixels="points", geometry=None,
    only=None, pairs=true, design=None, threads=0, progress=None
))]
#[expect(clippy::too_many_arguments, reason = "the keyword arguments of Python")]
fn diagnose_pictures(
    lens: &Bound<'_, Lens>,
    reference: &Bound<'_, PyAny>,
    observed: &Bound<'_, PyAny>,
    distance: Option<f64>,
    patch: usize,
    axis: Option<(f64, f64)>,
    clip: Option<f32>,
    reference_pixels: &str,
    geometry: Option<&str>,
    only: Option<Vec<String>>,
    pairs: bool,
    design: Option<&Bound<'_, PyAny>>,
    threads: u32,
    progress: Option<&Bound<'_, PyAny>>,
) -> Result<super::diagnose::Diagnosis> {
    let py = lens.py();
    let core = lens.get().core();
    let channels = core.profile().channel_names();
    let unknown = |name: &str, given: &str, remedy: &str| {
        Failure::argument(name, format!("is {given:?}"), remedy)
    };
    let design = design.map(observations::read).transpose()?;
    // A tone curve acts on the light of a plate, not on its PSFs.
    let all = || {
        let ids = effects::ALL.iter().map(|effect| effect.id().to_owned());
        ids.filter(|id| id != "tone_curve").collect()
    };
    let pair = PicturePair {
        lens: core.profile().clone(),
        axis: axis.map(|(x, y)| ImagePoint::new(x, y)),
        reference: read("reference", reference, &channels)?,
        observed: read("observed", observed, &channels)?,
        pair: PairSettings {
            side: patch,
            distance: object_distance(distance)?,
            clip,
            area_means: match reference_pixels {
                "points" => false,
                "areas" => true,
                other => {
                    let remedy = "give \"points\" or \"areas\"";
                    return Err(unknown("reference_pixels", other, remedy));
                }
            },
            geometry: match geometry {
                None => PairGeometry::Measured,
                Some("undistorted") => PairGeometry::Undistorted,
                Some("distorted") => PairGeometry::Distorted,
                Some(other) => {
                    let remedy = "give \"undistorted\", \"distorted\" or None";
                    return Err(unknown("geometry", other, remedy));
                }
            },
            ..PairSettings::default()
        },
        settings: DiagnosisSettings {
            library: only.unwrap_or_else(all),
            pairs,
            design: design.map(|named| named.set),
            ..DiagnosisSettings::default()
        },
    };
    let options = CallOptions { threads, progress };
    let found = options.run(py, move |progress| pair.diagnose(progress))?;
    let estimated = ObservationSet::measured(found.estimate.set)?;
    super::diagnose::Diagnosis::new(py, found.diagnosis, Some(Py::new(py, estimated)?))
}

//! Diagnosis of the gap between a lens and PSFs estimated from a pair of pictures.

use pyo3::prelude::*;
use seidel_core::diagnosis::{PairGeometry, PairImage, PairSettings};
use seidel_core::{DiagnosisSettings, ImagePoint, PicturePair};

use crate::array::ArrayPlanes;
use crate::depth::object_distance;
use crate::error::{Failure, Result};
use crate::lens::Lens;
use crate::observations::{self, ObservationSet};
use crate::worker::CallOptions;

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
    let reference = read("reference", reference, &channels)?;
    let observed = read("observed", observed, &channels)?;
    let axis = axis.map(|(x, y)| ImagePoint::new(x, y));
    let estimate = PairSettings {
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
    };
    let settings = DiagnosisSettings {
        library: only.unwrap_or_default(),
        pairs,
        design: design.map(|named| named.set),
        ..DiagnosisSettings::default()
    };
    let options = CallOptions { threads, progress };
    let found = options.run(py, move |progress| {
        let pair = PicturePair {
            reference: image(&reference),
            observed: image(&observed),
            axis,
            estimate,
        };
        let found = seidel_core::diagnose_pictures(&core, &pair, &settings, progress)?;
        Ok(found)
    })?;
    let estimated = ObservationSet::measured(found.estimate.set)?;
    super::diagnose::Diagnosis::new(py, found.diagnosis, Some(Py::new(py, estimated)?))
}

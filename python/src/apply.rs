//! Applying the blur of a lens to an image.

use std::sync::Arc;

use pyo3::prelude::*;
use seidel_core::{LensSession, Severity};

use crate::array::ResultSamples;
use crate::error::{Result, warn_of_depth};
use crate::lens::Lens;
use crate::plate::ArrayPlate;
use crate::settings::CallSettings;
use crate::worker::CallOptions;

/// Adds the function to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(apply, module)?)
}
/// Applies the blur of `lens` to `image`; near surfaces occlude far ones where `depth` varies.
///
/// - `image`: array of rows x columns (Y), or rows x columns x channels (Y, YA, RGB, RGBA, or 7 channels: RGBA and the alphas
///   of R, G and B), `float32` or `float16`, scene-linear. Views with any strides are read in place.
/// - `depth`: object distance in metres along the optical axis (`math.inf` for infinity), an array of rows x columns of such
///   distances, or a `DepthPass`. A lens that was measured at several distances needs it.
/// - `holdout`: matte of an object that will be merged in front later, an array of rows x columns from 0 to 1, or a `Holdout`
///   with its depth. The light of the image is held out where the matte covers it, sharp to the pixel.
/// - `mask`: an array of rows x columns from 0 to 1: the weight of the blurred image against its own pixels, or with
///   `Settings(mask_scales="blur")` a factor of the blur of each pixel.
/// - `background`: a `Background`, the image without its foreground. It shows where the blur of the foreground uncovers it.
/// - `settings`: a `Settings`; the defaults use the lens as measured.
/// - `progress`: called about fifty times a second with the share done, 0 to 1. It stops the call by an exception, or by
///   returning `False`. Ctrl-C stops the call too.
///
/// Returns a new array of the shape and sample type of `image`.
///
/// A depth pass that seems to have another meaning than stated causes a `DepthWarning`.
///
/// Raises `InvalidInput` for arrays and settings that are not valid, `Unsupported` for what this lens cannot do, and
/// `Cancelled`.
#[pyfunction]
#[pyo3(signature = (lens, image, depth=None, *, holdout=None, mask=None, background=None, settings=None, progress=None))]
#[expect(clippy::too_many_arguments, reason = "the arguments of Python")]
fn apply<'py>(
    lens: &Bound<'py, Lens>,
    image: &Bound<'py, PyAny>,
    depth: Option<&Bound<'py, PyAny>>,
    holdout: Option<&Bound<'py, PyAny>>,
    mask: Option<&Bound<'py, PyAny>>,
    background: Option<&Bound<'py, PyAny>>,
    settings: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyAny>> {
    let py = image.py();
    let settings = CallSettings::read(py, settings)?;
    let mut read = ArrayPlate::read(image, depth, &settings)?;
    read.add_holdout(holdout, &settings)?;
    read.add_mask(mask)?;
    if background.is_some() {
        settings.check_fill("background")?;
    }
    read.add_background(background, &settings)?;
    let ArrayPlate { plate, layout } = read;
    let options = CallOptions {
        threads: settings.threads,
        progress,
    };
    let lens = lens.get().core();
    let (samples, doubts) = options.run(py, move |progress| {
        let session = Arc::new(LensSession::new(&lens, &settings.core)?);
        if session.is_neutral() {
            let image = seidel_core::apply(&lens, &plate, &settings.core, progress)?;
            return Ok((ResultSamples::of_image(&image, &layout), Vec::new()));
        }
        let plate = session.prepare(plate)?;
        let findings = plate.depth_findings()?.into_iter();
        let doubts = findings.filter(|finding| finding.severity == Severity::Warning);
        let doubts: Vec<_> = doubts
            .map(|doubt| format!("depth: {}: {doubt}", doubt.severity))
            .collect();
        let image = plate.to_image(plate.apply(progress)?)?;
        Ok((ResultSamples::of_image(&image, &layout), doubts))
    })?;
    warn_of_depth(py, &doubts)?;
    samples.into_array(py, &layout)
}

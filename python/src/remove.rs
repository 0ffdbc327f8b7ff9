//! Removing the blur of a lens from an image.

use pyo3::prelude::*;

use crate::array::ResultSamples;
use crate::error::Result;
use crate::lens::Lens;
use crate::plate::ArrayPlate;
use crate::settings::CallSettings;
use crate::worker::CallOptions;

/// Adds the function to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(remove, module)?)
}
/// Removes the blur of the `lens` that `image` was taken with.
///
/// - `image`: array of rows x columns (Y), or rows x columns x channels (Y, YA, RGB or RGBA), `float32` or `float16`,
///   scene-linear. Views with any strides are read in place.
/// - `depth`: object distance in metres along the optical axis (`math.inf` for infinity), an array of rows x columns of such
///   distances, or a `DepthPass`; the depth is that of the sharp image. A lens that was measured at several distances needs it.
/// - `background`: a `Background`, the image without its foreground through the same lens, blur included. It makes the edges of
///   the foreground sharp, which keep their blur otherwise.
/// - `settings`: a `Settings`; the defaults use the lens as measured.
/// - `progress`: called about fifty times a second with the share done, 0 to 1. It stops the call by an exception, or by
///   returning `False`. Ctrl-C stops the call too.
///
/// Returns a new array of the shape and sample type of `image`.
///
/// Raises `InvalidInput` for arrays and settings that are not valid, `Unsupported` for what this lens cannot do, and
/// `Cancelled`.
///
/// Clipped highlights that the lens does not explain keep their blur.
#[pyfunction]
#[pyo3(signature = (lens, image, depth=None, *, background=None, settings=None, progress=None))]
fn remove<'py>(
    lens: &Bound<'py, Lens>,
    image: &Bound<'py, PyAny>,
    depth: Option<&Bound<'py, PyAny>>,
    background: Option<&Bound<'py, PyAny>>,
    settings: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyAny>> {
    let py = image.py();
    let settings = CallSettings::read(py, settings)?;
    let mut read = ArrayPlate::read(image, depth, &settings)?;
    read.add_background(background, &settings)?;
    let ArrayPlate { plate, layout } = read;
    let options = CallOptions {
        threads: settings.threads,
        progress,
    };
    let lens = lens.get().core();
    let samples = options.run(py, move |progress| {
        let image = seidel_core::remove(&lens, &plate, &settings.core, progress)?;
        Ok(ResultSamples::of_image(&image, &layout))
    })?;
    samples.into_array(py, &layout)
}

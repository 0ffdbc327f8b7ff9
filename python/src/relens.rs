//! The blur of one lens replaced by that of another.

use pyo3::prelude::*;

use crate::array::ResultSamples;
use crate::error::Result;
use crate::lens::Lens;
use crate::plate::ArrayPlate;
use crate::settings::CallSettings;
use crate::worker::CallOptions;

/// Adds the function to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(relens, module)?)
}
/// Removes the blur of the lens `from_lens`, with which `image` was taken, and applies that of `to_lens`. The image keeps
/// its grain.
///
/// - `image`: array of rows x columns (Y), or rows x columns x channels (Y, YA, RGB or RGBA), `float32` or `float16`,
///   scene-linear. Views with any strides are read in place.
/// - `depth`: object distance in metres along the optical axis (`math.inf` for infinity), an array of rows x columns of such
///   distances, or a `DepthPass`. A lens that was measured at several distances needs it.
/// - `settings`: a `Settings`; it holds for both lenses, but `from_...` and `to_...` for one of them; `strength` and `grain` are
///   not used.
/// - `progress`: called about fifty times a second with the share done, 0 to 1. It stops the call by an exception, or by
///   returning `False`. Ctrl-C stops the call too.
///
/// Returns a new array of the shape and sample type of `image`.
///
/// Raises `InvalidInput` for arrays and settings that are not valid, `Unsupported` for what this lens cannot do, and
/// `Cancelled`.
#[pyfunction]
#[pyo3(signature = (from_lens, to_lens, image, depth=None, *, settings=None, progress=None))]
fn relens<'py>(
    from_lens: &Bound<'py, Lens>,
    to_lens: &Bound<'py, Lens>,
    image: &Bound<'py, PyAny>,
    depth: Option<&Bound<'py, PyAny>>,
    settings: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyAny>> {
    let py = image.py();
    let settings = CallSettings::read(py, settings)?;
    let ArrayPlate { plate, layout } = ArrayPlate::read(image, depth, &settings)?;
    let options = CallOptions {
        threads: settings.threads,
        progress,
    };
    let (from, to) = (from_lens.get().core(), to_lens.get().core());
    let samples = options.run(py, move |progress| {
        let image = seidel_core::relens(&from, &to, &plate, &settings.core, progress)?;
        Ok(ResultSamples::of_image(&image, &layout))
    })?;
    samples.into_array(py, &layout)
}

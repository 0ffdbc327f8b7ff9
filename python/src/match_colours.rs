//! Colour fringes taken off an image, without sharpening it.

use pyo3::prelude::*;

use crate::array::ResultSamples;
use crate::error::Result;
use crate::lens::Lens;
use crate::plate::ArrayPlate;
use crate::settings::CallSettings;
use crate::worker::CallOptions;

/// Adds the function to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(match_colours, module)?)
}
/// Takes the lateral and axial colour of the `lens` that `image` was taken with off it, and sharpens nothing else: every
/// colour gets the blur, and the place, of the colour whose blur is of middle size. As `seidel remove --only-chroma`.
///
/// - `image`: array of rows x columns x channels (RGB or RGBA), `float32` or `float16`, scene-linear. Views with any strides
///   are read in place. Alpha does not change.
/// - `depth`: object distance in metres along the optical axis (`math.inf` for infinity), an array of rows x columns of such
///   distances, or a `DepthPass`. A lens that was measured at several distances needs it.
/// - `settings`: a `Settings`; `grain` is not used.
/// - `progress`: called about fifty times a second with the share done, 0 to 1. It stops the call by an exception, or by
///   returning `False`. Ctrl-C stops the call too.
///
/// Returns a new array of the shape and sample type of `image`.
///
/// Raises `InvalidInput` for arrays and settings that are not valid and images of one colour, `Unsupported` for what this
/// lens cannot do, and `Cancelled`.
#[pyfunction]
#[pyo3(signature = (lens, image, depth=None, *, settings=None, progress=None))]
fn match_colours<'py>(
    lens: &Bound<'py, Lens>,
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
    let lens = lens.get().core();
    let samples = options.run(py, move |progress| {
        let image = seidel_core::match_colours(&lens, &plate, &settings.core, progress)?;
        Ok(ResultSamples::of_image(&image, &layout))
    })?;
    samples.into_array(py, &layout)
}

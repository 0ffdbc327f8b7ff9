//! Focus: the distance that a pixel shows, and the circle of confusion of every pixel.

use std::sync::Arc;

use pyo3::prelude::*;
use seidel_core::{Depth, LensSession, ObjectDistance, PreparedDepth};

use crate::array::{ResultSamples, SampleType};
use crate::depth;
use crate::error::{Failure, Result};
use crate::lens::Lens;
use crate::plate::{ArrayPlate, geometry};
use crate::settings::CallSettings;
use crate::worker::CallOptions;

/// Adds the functions to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(distance_at, module)?)?;
    module.add_function(wrap_pyfunction!(circle_of_confusion, module)?)
}

/// Returns the object distance at a pixel of a depth pass, in metres along the optical axis: the median of a disc of 3 pixels'
/// radius, so that noise and fine gaps do not count. As `Settings.focus_distance` it focuses on what the pixel shows, as
/// `--focus-at` of the command does. It is `math.inf` where the disc is empty or at infinity.
///
/// - `depth`: an array of rows x columns of distances in metres, or a `DepthPass`.
/// - `x`, `y`: the pixel, right and down from the top-left corner of the array, counted from 0.
/// - `settings`: a `Settings`, whose display window and pixel aspect count where distances are along the ray.
///
/// Raises `InvalidInput` for a depth that is not valid, and a pixel outside it.
#[pyfunction]
#[pyo3(signature = (lens, depth, x, y, *, settings=None))]
fn distance_at(
    lens: &Bound<'_, Lens>,
    depth: &Bound<'_, PyAny>,
    x: usize,
    y: usize,
    settings: Option<&Bound<'_, PyAny>>,
) -> Result<f64> {
    let settings = CallSettings::read(lens.py(), settings)?;
    let (pass, layout) = depth::read_alone("depth", depth)?;
    if x >= layout.width || y >= layout.height {
        return Err(Failure::argument(
            &format!("pixel ({x}, {y})"),
            "lies outside the depth pass",
            format!("give x below {} and y below {}", layout.width, layout.height),
        ));
    }
    let session = LensSession::new(&lens.get().core(), &settings.core)?;
    let depth = PreparedDepth::new(&session, &geometry(&layout, &settings)?, Depth::Pass(pass))?;
    Ok(match depth.distance_at(x, y, layout.width) {
        ObjectDistance::Metres(metres) => metres,
        ObjectDistance::Infinity | ObjectDistance::Unknown => f64::INFINITY,
    })
}

/// Returns the circle of confusion of every pixel of `image`, as `--show coc-px` of the command: an array of rows x columns,
/// `float32`, the diameter in image pixels, negative in front of the focus. It is that of the even disc with the variance of the
/// blur.
///
/// - `image`, `depth`, `settings`: those of `apply`.
///
/// Raises the exceptions of `apply`.
#[pyfunction]
#[pyo3(signature = (lens, image, depth=None, *, settings=None))]
fn circle_of_confusion<'py>(
    lens: &Bound<'py, Lens>,
    image: &Bound<'py, PyAny>,
    depth: Option<&Bound<'py, PyAny>>,
    settings: Option<&Bound<'py, PyAny>>,
) -> Result<Bound<'py, PyAny>> {
    let py = image.py();
    let settings = CallSettings::read(py, settings)?;
    let ArrayPlate { plate, layout } = ArrayPlate::read(image, depth, &settings)?;
    let options = CallOptions {
        threads: settings.threads,
        progress: None,
    };
    let lens = lens.get().core();
    let samples = options.run(py, move |_| {
        let session = Arc::new(LensSession::new(&lens, &settings.core)?);
        let map = session.prepare(plate)?.blur_map()?;
        let pixels = 0..map.diameter_px.len();
        let diameters: Vec<f32> = pixels.map(|index| map.signed_diameter_px(index)).collect();
        Ok(ResultSamples::of_planes(&[&diameters], SampleType::Float))
    })?;
    samples.into_array(py, &layout.of_plane())
}

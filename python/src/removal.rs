//! Removal of blur with its maps, and the share of a lens's blur that an image shows.

use std::sync::Arc;

use pyo3::prelude::*;
use seidel_core::{LensSession, NoiseGain, Plate, Progress, Settings};

use crate::array::{ArrayLayout, ResultSamples, SampleType};
use crate::error::Result;
use crate::lens::Lens;
use crate::plate::ArrayPlate;
use crate::settings::CallSettings;
use crate::worker::CallOptions;

/// The result of `remove_with_maps`.
#[pyclass(frozen, get_all, module = "seidel")]
pub(crate) struct Removal {
    /// The sharp image, an array of the shape and sample type of the given one: what `remove` returns.
    image: Py<PyAny>,
    /// Share of each pixel's detail that the given image determines, 0 to 1: a `float32` array with a channel for each colour.
    confidence: Py<PyAny>,
    /// Amplification of noise at each pixel, an array as `confidence`; `None` unless it was asked for.
    noise_gain: Option<Py<PyAny>>,
    /// Standard deviation of the noise of each colour, scene-linear, as given or estimated.
    noise: Vec<f64>,
}

#[pymethods]
impl Removal {
    fn __repr__(&self) -> String {
        format!("<seidel.Removal, noise {:?}>", self.noise)
    }
}

/// Adds the functions to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Removal>()?;
    module.add_function(wrap_pyfunction!(remove_with_maps, module)?)?;
    module.add_function(wrap_pyfunction!(blur_share, module)?)
}

/// Removes the blur of the `lens` that `image` was taken with, and says how far the result can be relied on.
///
/// The arguments are those of `remove`. With `noise_gain` the amplification of noise is measured, which takes as long again.
///
/// Returns a `Removal`: the sharp image, the confidence, the noise and its amplification.
#[pyfunction]
#[pyo3(signature = (lens, image, depth=None, *, background=None, noise_gain=false, settings=None, progress=None))]
fn remove_with_maps<'py>(
    lens: &Bound<'py, Lens>,
    image: &Bound<'py, PyAny>,
    depth: Option<&Bound<'py, PyAny>>,
    background: Option<&Bound<'py, PyAny>>,
    noise_gain: bool,
    settings: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> Result<Removal> {
    let py = image.py();
    let settings = CallSettings::read(py, settings)?;
    let mut read = ArrayPlate::read(image, depth, &settings)?;
    read.add_background(background, &settings)?;
    let ArrayPlate { plate, layout } = read;
    let options = CallOptions {
        threads: settings.threads,
        progress,
    };
    let maps = layout.of_maps(plate.image.colours.len());
    let request = Request {
        lens: lens.get().core(),
        layout,
        noise_gain: if noise_gain {
            NoiseGain::Measure
        } else {
            NoiseGain::Skip
        },
    };
    let found = options.run(py, move |progress| {
        request.remove(plate, &settings.core, progress)
    })?;
    let gain = found
        .noise_gain
        .map(|samples| samples.into_array(py, &maps));
    Ok(Removal {
        image: found.image.into_array(py, &layout)?.unbind(),
        confidence: found.confidence.into_array(py, &maps)?.unbind(),
        noise_gain: gain.transpose()?.map(Bound::unbind),
        noise: found.noise,
    })
}

/// A removal to do.
struct Request {
    lens: Arc<seidel_core::Lens>,
    layout: ArrayLayout,
    noise_gain: NoiseGain,
}

/// The samples of a [`Removal`].
struct RemovalSamples {
    image: ResultSamples,
    confidence: ResultSamples,
    noise_gain: Option<ResultSamples>,
    noise: Vec<f64>,
}

impl Request {
    fn remove(
        &self,
        plate: Plate,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<RemovalSamples> {
        let session = Arc::new(LensSession::new(&self.lens, &settings.of_measured_lens())?);
        let measures = self.noise_gain == NoiseGain::Measure;
        let samples = |planes: &[Vec<f32>]| {
            let planes: Vec<&[f32]> = planes.iter().map(Vec::as_slice).collect();
            ResultSamples::of_planes(&planes, SampleType::Float)
        };
        if session.is_neutral() || settings.removal.strength == 0.0 {
            // The image stays as it is, so all of it is known and its noise is not amplified.
            let image = seidel_core::remove(&self.lens, &plate, settings, progress)?;
            let ones = vec![vec![1.0; image.width() * image.height()]; image.colours.len()];
            return Ok(RemovalSamples {
                image: ResultSamples::of_image(&image, &self.layout),
                confidence: samples(&ones),
                noise_gain: measures.then(|| samples(&ones)),
                noise: vec![0.0; image.colours.len()],
            });
        }
        let plate = session.prepare(plate)?;
        let removed = plate.remove(self.noise_gain, progress)?;
        let image = removed.sharp_image(&plate)?;
        let mut noise = removed.noise();
        noise.truncate(image.colours.len());
        Ok(RemovalSamples {
            image: ResultSamples::of_image(&image, &self.layout),
            confidence: samples(&removed.confidence()),
            noise_gain: measures.then(|| samples(removed.noise_gain())),
            noise,
        })
    }
}

/// Returns the blur that `image` shows as a share of the blur of `lens`: 1 where nothing speaks against the lens, below 1 where
/// the image is sharper than the lens would have made it.
///
/// The arguments are those of `remove`. The command does this check before a removal and scales `Settings.amount` by the share
/// if it is below 1 (`--lens-check adjust`).
#[pyfunction]
#[pyo3(signature = (lens, image, depth=None, *, settings=None, progress=None))]
fn blur_share<'py>(
    lens: &Bound<'py, Lens>,
    image: &Bound<'py, PyAny>,
    depth: Option<&Bound<'py, PyAny>>,
    settings: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> Result<f64> {
    let py = image.py();
    let settings = CallSettings::read(py, settings)?;
    let plate = ArrayPlate::read(image, depth, &settings)?.plate;
    let options = CallOptions {
        threads: settings.threads,
        progress,
    };
    let lens = lens.get().core();
    options.run(py, move |progress| {
        let session = Arc::new(LensSession::new(&lens, &settings.core.of_measured_lens())?);
        Ok(session.prepare(plate)?.blur_share(progress)?)
    })
}

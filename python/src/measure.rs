//! PSFs measured in photographs of point lights.

use pyo3::prelude::*;
use seidel_core::ImagePoint;
use seidel_measure::{Calibration, LightSettings, TileSize};

use crate::error::{Failure, Result, warn};
use crate::observations::ObservationSet;
use crate::photographs::{Levels, PhotographArgs, PhotographSource};
use crate::worker::CallOptions;

/// The result of `measure_lights`.
#[pyclass(frozen, get_all, module = "seidel")]
pub(crate) struct LightMeasurement {
    /// The lights that were kept: an `ObservationSet`, to which a lens can be fitted.
    observations: Py<ObservationSet>,
    /// The lights that were left out, a list of `LeftOut`.
    left_out: Vec<Py<LeftOut>>,
    /// Number of hot pixels of each photograph.
    hot_pixels: Vec<usize>,
    /// Width of a tile away from the borders, pixels.
    tile_size: usize,
}

/// A light that was left out of a measurement.
#[pyclass(frozen, get_all, module = "seidel")]
pub(crate) struct LeftOut {
    /// Name of the photograph.
    source: String,
    /// Position, frame pixels.
    x: f64,
    /// Position, frame pixels.
    y: f64,
    /// The reason, such as `"clipped"` or `"faint"`.
    why: &'static str,
    /// The value that led to it.
    value: f64,
    /// The limit that it crossed.
    limit: f64,
    /// The quantity of `value` and `limit`, with its unit.
    quantity: &'static str,
}

#[pymethods]
impl LightMeasurement {
    fn __repr__(&self) -> String {
        let (kept, left_out) = (self.observations.get().count(), self.left_out.len());
        format!("<seidel.LightMeasurement: {kept} lights kept, {left_out} left out>")
    }
}

#[pymethods]
impl LeftOut {
    fn __repr__(&self) -> String {
        let Self {
            source,
            x,
            y,
            why,
            value,
            limit,
            quantity,
        } = self;
        format!(
            "<seidel.LeftOut {why} at ({x:.1}, {y:.1}) in {source}: {quantity} {value:.3}, limit {limit:.3}>"
        )
    }
}

/// Adds the function and its results to `module`.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<LightMeasurement>()?;
    module.add_class::<LeftOut>()?;
    module.add_function(wrap_pyfunction!(measure_lights, module)?)
}

/// Finds point lights (pinholes, LEDs, stars) in photographs of one camera at one setting, and cuts a PSF tile around each.
///
/// - `photographs`: a photograph, or a sequence of them: paths of raw files (DNG; TIFF, PNG or PGM of 16 bits; FITS; linear
///   OpenEXR or TIFF), or arrays of counts. Arrays are rows x columns, of a sensor with the mosaic `cfa`, or rows x columns x 3
///   of linear R, G and B; `uint16`, `float32` or `float16`. Raw pixels are never interpolated.
/// - `distance`: distance of the lights in metres from the entrance pupil, `math.inf` for infinity: one for each photograph, or
///   one for all.
/// - `channels`: channels to measure; all if `None`.
/// - `axis`: position (x, y) of the optical axis, frame pixels; the centre of the frame if `None`.
/// - `dark`, `flat`: photographs with the cap on at the same exposure, and of an evenly lit surface.
/// - `cfa`: colours of the top-left 2 x 2 pixels, such as `"RGGB"`, or `"none"`; that of the file if `None`.
/// - `black`, `white`: black level and clipping level, counts. If `None`: those of a file, or a guess with a `UserWarning`; 0 and
///   none for arrays of floats. Arrays of integers need `white`.
/// - `encoding`: `"linear"` or `"srgb"`, for files that are not raw.
/// - `tile_size`: width of the tiles, 7 to 1023 pixels; as wide as the lights need if `None`.
/// - `min_snr`: least signal over noise of a light.
/// - `threads`: most threads; 0 for one each core.
///
/// Returns a `LightMeasurement`: the `ObservationSet`, and the lights that were left out with their reasons. Limits of the result
/// are issued as `UserWarning`s. Ctrl-C stops it.
///
/// Raises `FileError`, `InvalidInput`, and `InsufficientData` where no light was found or kept.
#[pyfunction]
#[pyo3(signature = (
    photographs, *, distance=None, channels=None, axis=None, dark=None, flat=None, cfa=None, black=None, white=None,
    encoding=None, tile_size=None, min_snr=None, threads=0
))]
#[expect(clippy::too_many_arguments, reason = "the keyword arguments of Python")]
fn measure_lights(
    photographs: &Bound<'_, PyAny>,
    distance: Option<&Bound<'_, PyAny>>,
    channels: Option<Vec<String>>,
    axis: Option<(f64, f64)>,
    dark: Option<&Bound<'_, PyAny>>,
    flat: Option<&Bound<'_, PyAny>>,
    cfa: Option<&str>,
    black: Option<f32>,
    white: Option<f32>,
    encoding: Option<&str>,
    tile_size: Option<usize>,
    min_snr: Option<f64>,
    threads: u32,
) -> Result<LightMeasurement> {
    let py = photographs.py();
    let levels = Levels { black, white };
    let args = PhotographArgs::new(cfa, encoding, levels, channels.unwrap_or_default())?;
    let lights = args.sources("photograph", photographs, distance)?;
    let frames = |name, given: Option<&Bound<'_, PyAny>>| {
        given.map_or(Ok(Vec::new()), |given| args.sources(name, given, None))
    };
    let (darks, flats) = (frames("dark", dark)?, frames("flat", flat)?);
    let settings = LightSettings {
        tile: tile(tile_size)?,
        min_snr: min_snr.unwrap_or(LightSettings::default().min_snr),
        ..LightSettings::default()
    };
    let options = CallOptions {
        threads,
        progress: None,
    };
    let found = options.run(py, move |progress| {
        let mut warnings = Vec::new();
        let mut read = |sources: Vec<PhotographSource>| {
            let mut read = Vec::new();
            for source in sources {
                let one = source.read(&args)?;
                warnings.extend(one.warnings);
                read.push(one.photograph);
                if !progress(0.0) {
                    return Err(Failure::cancelled());
                }
            }
            Ok(read)
        };
        let (photographs, darks, flats) = (read(lights)?, read(darks)?, read(flats)?);
        let calibration = Calibration::new(&darks, &flats)?;
        let measured = seidel_measure::measure_lights(photographs, &calibration, &settings)?;
        if let Some(refusal) = measured.refusal() {
            return Err(refusal.clone().into());
        }
        warnings.extend(measured.warnings.iter().cloned());
        let point = axis.map(|(x, y)| ImagePoint::new(x, y));
        let set = measured.observations(point)?;
        Ok((measured, set, warnings))
    })?;
    let (measured, set, warnings) = found;
    warn(py, &warnings)?;
    let left_out = measured.left_out.iter().map(|light| {
        let left_out = LeftOut {
            source: measured.photographs[light.photograph].name.clone(),
            x: light.x,
            y: light.y,
            why: light.why.name(),
            value: light.value,
            limit: light.limit,
            quantity: light.why.quantity(),
        };
        Py::new(py, left_out)
    });
    Ok(LightMeasurement {
        left_out: left_out.collect::<PyResult<_>>()?,
        observations: Py::new(py, ObservationSet::measured(set)?)?,
        hot_pixels: measured.hot_pixels,
        tile_size: measured.tile_px,
    })
}

/// Returns the size of tiles that the argument `tile_size` asks for.
fn tile(size: Option<usize>) -> Result<TileSize> {
    match size {
        None => Ok(TileSize::Auto),
        Some(size) if TileSize::RANGE.contains(&size) => Ok(TileSize::Pixels(size)),
        Some(size) => Err(Failure::argument(
            "tile_size",
            format!("is {size}"),
            format!(
                "give {} to {} pixels, or None",
                TileSize::RANGE.start(),
                TileSize::RANGE.end()
            ),
        )),
    }
}

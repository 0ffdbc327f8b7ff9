//! `seidel.Lens`: a fitted lens.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use seidel_core::profile::LensDescription;
use seidel_core::{Controls, Image, ImagePoint, LensProfile, Settings};
use seidel_image_io::lens_profile;

use crate::array::{ArrayLayout, ResultSamples};
use crate::depth::object_distance;
use crate::error::{Result, warn};
use crate::fit::{self, FitArgs};
use crate::look::put_look;
use crate::worker::CallOptions;

/// A fitted lens: its point-spread function (PSF) at any point of the field, channel and object distance.
///
/// Lenses do not change, and any number of threads may use one. They can be compared and pickled.
#[pyclass(frozen, eq, module = "seidel")]
pub(crate) struct Lens {
    core: Arc<seidel_core::Lens>,
}

impl PartialEq for Lens {
    fn eq(&self, other: &Self) -> bool {
        self.core.profile() == other.core.profile()
    }
}

impl Lens {
    /// Creates the lens that `profile` describes.
    pub(crate) fn of_profile(profile: LensProfile) -> Result<Self> {
        Ok(Self {
            core: Arc::new(seidel_core::Lens::new(profile)?),
        })
    }

    /// The lens of the core.
    pub(crate) fn core(&self) -> Arc<seidel_core::Lens> {
        Arc::clone(&self.core)
    }
}

#[pymethods]
impl Lens {
    /// Reads a lens profile, a file that `save` or `seidel fit` wrote.
    ///
    /// Raises `FileError` for a file that cannot be read or is not a valid profile.
    #[staticmethod]
    fn load(path: PathBuf) -> Result<Self> {
        Self::of_profile(lens_profile::read(&path)?)
    }

    /// Reads a lens from the text of a lens profile.
    ///
    /// Raises `InvalidInput`, which names the field at fault.
    #[staticmethod]
    fn from_json(text: &str) -> Result<Self> {
        Ok(Self {
            core: Arc::new(seidel_core::Lens::from_json(text)?),
        })
    }

    /// Returns the lens profile as JSON, the text of the file that `save` writes.
    ///
    /// Raises `Unsupported` for a lens with a picture of the aperture.
    fn to_json(&self) -> Result<String> {
        self.core.profile().check_storable()?;
        Ok(self.core.to_json())
    }

    /// Writes the lens profile to `path`, whole or not at all.
    ///
    /// Raises `FileError`, also for a lens with a picture of the aperture: profiles hold none.
    fn save(&self, path: PathBuf) -> Result<()> {
        Ok(lens_profile::write(&path, self.core.profile())?)
    }

    /// Fits a lens to one or more observation sets of one camera: `ObservationSet`s, or paths of folders with a
    /// `manifest.json`.
    ///
    /// - `model`: `"reduced"` (third order, ray by ray), `"extended"` (fifth order, and further effects that held-out PSFs ask
    ///   for), `"moments"` (S1..S10 by channel and distance, the fastest), or `"auto"`: `"extended"` where held-out PSFs show
    ///   that `"reduced"` is not enough.
    /// - `axis`: position of the optical axis, (x, y) in frame pixels, or `"free"` to estimate it; that of the sets if `None`.
    /// - `use_all`: fit all PSFs and hold none out to score the lens.
    /// - `law_only`: describe the lens by smooth functions of distance alone.
    /// - `threads`: most threads; 0 for one each core.
    /// - `progress`: as for `apply`.
    ///
    /// It takes from a second (`"moments"`) to minutes. Limits of the result are issued as `UserWarning`s.
    ///
    /// Raises `FileError` for sets with faults, `InvalidInput`, and `InsufficientData` for too few PSFs.
    #[staticmethod]
    #[pyo3(signature = (observations, *, model="auto", axis=None, use_all=false, law_only=false, threads=0, progress=None))]
    fn fit(
        observations: &Bound<'_, PyAny>,
        model: &str,
        axis: Option<&Bound<'_, PyAny>>,
        use_all: bool,
        law_only: bool,
        threads: u32,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self> {
        let args = FitArgs {
            model,
            axis,
            use_all,
            law_only,
            call: CallOptions { threads, progress },
        };
        fit::fit(observations, &args)
    }

    /// Returns the PSF at frame pixel (`x`, `y`) for an object at `distance`.
    ///
    /// - `x`, `y`: frame pixels; x right, y down, (0, 0) at the outer corner of the top-left pixel.
    /// - `distance`: metres along the optical axis from the entrance pupil, `math.inf` for infinity; needed if
    ///   `depends_on_depth`.
    /// - `size`: rows and columns, 1 to 4096.
    /// - `psf_model`: identifier such as `"pupil"` or `"gaussian"`; the best for the lens if `None`.
    ///
    /// Returns a `float32` array of `size` x `size` x channels, in the order of `channels`. Each channel is integrated over
    /// pixels, has a sum of 1, and has its centroid at the centre of the array.
    ///
    /// Raises `InvalidInput`, for instance for a PSF that lies outside the array, and `Unsupported` for a model that cannot
    /// draw this lens.
    #[pyo3(signature = (x, y, distance=None, *, size=33, psf_model=None))]
    fn psf<'py>(
        &self,
        py: Python<'py>,
        x: f64,
        y: f64,
        distance: Option<f64>,
        size: usize,
        psf_model: Option<String>,
    ) -> Result<Bound<'py, PyAny>> {
        let distance = object_distance(distance)?;
        let names = self.core.predictor().channel_names().to_vec();
        let layout = ArrayLayout::of_tile(size, names.len());
        let options = CallOptions {
            threads: 0,
            progress: None,
        };
        let lens = self.core();
        let samples = options.run(py, move |_| {
            let at = ImagePoint::new(x, y);
            let tiles = lens.psf_at(at, distance, size, psf_model.as_deref())?;
            let planes = tiles.iter().map(|tile| tile.samples().to_vec()).collect();
            let image = Image::new(size, size, names, planes)?;
            Ok(ResultSamples::of_image(&image, &layout))
        })?;
        samples.into_array(py, &layout)
    }

    /// Returns the lens focused, stopped down, with its sensor shifted or with another look.
    ///
    /// - `focus_distance`: metres, may be `math.inf`; as measured if `None`.
    /// - `f_number`: as measured if `None`. Below the measured one the blur is extrapolated, with a `UserWarning`.
    /// - `sensor_shift_um`: micrometres away from the lens; negative towards it.
    /// - `focal_length_mm`: focal length to scale the lens and its frame to; f-number and focus distance stay.
    /// - `look`: a `Look`, which acts on the lens as the other arguments set it. A lens with an aperture picture cannot be saved.
    ///
    /// Raises `Unsupported` for a lens fitted in moments.
    #[pyo3(signature = (*, focus_distance=None, f_number=None, sensor_shift_um=None, focal_length_mm=None, look=None))]
    fn adjusted(
        &self,
        py: Python<'_>,
        focus_distance: Option<f64>,
        f_number: Option<f64>,
        sensor_shift_um: Option<f64>,
        focal_length_mm: Option<f64>,
        look: Option<Bound<'_, PyAny>>,
    ) -> Result<Self> {
        let focus_distance = focus_distance.map(|metres| object_distance(Some(metres)));
        let controls = Controls {
            focus_distance: focus_distance.transpose()?,
            f_number,
            sensor_shift_um,
            focal_length_mm,
        };
        let mut core = self.core.with_controls(&controls)?;
        if let Some(look) = look {
            let mut settings = Settings::default();
            put_look(&look, &mut settings)?;
            core = core.with_look(&settings.look)?;
        }
        let core = Arc::new(core);
        warn(py, &self.core.profile().control_warnings(&controls))?;
        Ok(Self { core })
    }

    /// Width and height of the frame, pixels.
    #[getter]
    fn frame_size(&self) -> (u32, u32) {
        let frame = self.core.profile().frame;
        (frame.width_px(), frame.height_px())
    }

    /// Position (x, y) of the optical axis, frame pixels.
    #[getter]
    fn optical_axis(&self) -> (f64, f64) {
        let axis = self.core.profile().frame.axis();
        (axis.x_px, axis.y_px)
    }

    /// Names of the channels.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.core.predictor().channel_names().to_vec()
    }

    /// Kind of the lens: `"moments"`, or `"pupil"` for one that is traced ray by ray.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.core.profile().description {
            LensDescription::Moments(_) => "moments",
            LensDescription::Pupil(_) => "pupil",
        }
    }

    /// Whether the blur depends on the object distance.
    #[getter]
    fn depends_on_depth(&self) -> bool {
        self.core.predictor().depends_on_depth()
    }

    /// Squeeze of an anamorphic lens; 1 for a spherical one.
    #[getter]
    fn squeeze(&self) -> f64 {
        self.core.squeeze()
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.frame_size();
        let channels = self.channels().join(", ");
        format!(
            "<seidel.Lens of kind {}: {width} x {height} px, channels {channels}>",
            self.kind()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Result<(Bound<'py, PyAny>, (String,))> {
        let from_json = slf.get_type().getattr("from_json")?;
        Ok((from_json, (slf.get().to_json()?,)))
    }
}

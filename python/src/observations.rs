//! `seidel.ObservationSet`: measured PSFs, from files or from arrays.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use seidel_core::{Frame, ImagePoint, ObjectDistance, Observation, Tile};
use seidel_image_io::observation_set::{self as manifest, ReadOptions};

use crate::array::ArrayPlanes;
use crate::depth::object_distance;
use crate::error::{Failure, Result, warn};

/// A set with the name by which provenance and messages call it.
#[derive(Clone)]
pub(crate) struct NamedSet {
    pub(crate) set: seidel_core::ObservationSet,
    pub(crate) name: String,
}

/// PSFs observed with one camera at one setting: a tile a channel for each point of light.
#[pyclass(frozen, module = "seidel")]
pub(crate) struct ObservationSet {
    named: NamedSet,
}

/// The attributes of `seidel.Observation`, which documents them.
#[derive(FromPyObject)]
struct ObservationArgs<'py> {
    x: f64,
    y: f64,
    distance: Option<f64>,
    tile: Bound<'py, PyAny>,
}

impl ObservationArgs<'_> {
    fn read(&self, index: usize, channels: usize) -> Result<Observation> {
        let name = format!("observation {index}: tile");
        let ArrayPlanes { layout, planes } = ArrayPlanes::read(&name, &self.tile)?;
        if planes.len() != channels {
            return Err(Failure::argument(
                &name,
                format!("has {} channels", planes.len()),
                format!("give one for each of the set's {channels}"),
            ));
        }
        let tiles = planes.into_iter();
        let tiles = tiles.map(|plane| Tile::new(layout.width, layout.height, plane));
        let tiles = tiles.collect::<seidel_core::Result<_>>()?;
        let centre = ImagePoint::new(self.x, self.y);
        let distance = object_distance(self.distance)?;
        Ok(Observation::new(
            format!("tile-{index:04}"),
            centre,
            distance,
            tiles,
        ))
    }
}

impl ObservationSet {
    /// The set of a measurement.
    ///
    /// # Errors
    /// All faults of all observations.
    pub(crate) fn measured(set: seidel_core::ObservationSet) -> Result<Self> {
        Self::checked(set, "photographs")
    }

    fn checked(set: seidel_core::ObservationSet, name: &str) -> Result<Self> {
        let faults = set.faults();
        if !faults.is_empty() {
            return Err(Failure::Faults(faults));
        }
        Ok(Self {
            named: NamedSet {
                set,
                name: name.to_owned(),
            },
        })
    }

    /// Number of observations.
    pub(crate) fn count(&self) -> usize {
        self.named.set.observations.len()
    }
}

#[pymethods]
impl ObservationSet {
    /// Creates a set from arrays.
    ///
    /// - `frame_size`: width and height of the full frame, pixels.
    /// - `channels`: names of the channels, such as `["R", "G", "B"]`, in the order of the tiles.
    /// - `observations`: a sequence of `Observation`s.
    /// - `axis`: position (x, y) of the optical axis, frame pixels; the centre of the frame if `None`.
    /// - `pixel_pitch_um`: distance of the sensor's pixels, micrometres, if known.
    ///
    /// Raises `InvalidInput`, which lists all faults of all observations.
    #[new]
    #[pyo3(signature = (frame_size, channels, observations, *, axis=None, pixel_pitch_um=None))]
    fn new(
        frame_size: (u32, u32),
        channels: Vec<String>,
        observations: Vec<ObservationArgs<'_>>,
        axis: Option<(f64, f64)>,
        pixel_pitch_um: Option<f64>,
    ) -> Result<Self> {
        let point = axis.map(|(x, y)| ImagePoint::new(x, y));
        let frame = Frame::new(frame_size.0, frame_size.1, point)?;
        let observations = observations.iter().enumerate();
        let observations =
            observations.map(|(index, observation)| observation.read(index, channels.len()));
        let observations = observations.collect::<Result<_>>()?;
        let mut set = seidel_core::ObservationSet::new(frame, channels, observations);
        set.axis_stated = axis.is_some();
        set.pixel_pitch_um = pixel_pitch_um;
        Self::checked(set, "arrays")
    }

    /// Reads the set in a folder with a `manifest.json`, or that of a manifest file.
    ///
    /// With `skip_bad`, observations with faults are left out, with a `UserWarning` for each fault.
    ///
    /// Raises `FileError`, which lists all faults of all observations.
    #[staticmethod]
    #[pyo3(signature = (path, *, skip_bad=false))]
    fn load(py: Python<'_>, path: PathBuf, skip_bad: bool) -> Result<Self> {
        let read = manifest::read(&path, ReadOptions { skip_bad })?;
        let faults = read.skipped.iter().flat_map(|skipped| &skipped.faults);
        let warnings: Vec<String> = faults.map(|fault| format!("left out {fault}")).collect();
        warn(py, &warnings)?;
        Ok(Self {
            named: NamedSet {
                set: read.set,
                name: short_name(&path),
            },
        })
    }

    /// Writes the set to the folder `path`, which must not exist: a `manifest.json` and an image a tile.
    ///
    /// Raises `FileError`.
    fn save(&self, path: PathBuf) -> Result<()> {
        Ok(manifest::write(&self.named.set, &path)?)
    }

    /// Width and height of the frame, pixels.
    #[getter]
    fn frame_size(&self) -> (u32, u32) {
        let frame = self.named.set.frame;
        (frame.width_px(), frame.height_px())
    }

    /// Names of the channels.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.named.set.channels.clone()
    }

    /// Distinct object distances, metres: nearest first, `inf` for infinity, `None` for unknown.
    #[getter]
    fn distances(&self) -> Vec<Option<f64>> {
        let distances = self.named.set.distances().into_iter();
        let metres = distances.map(|distance| match distance {
            ObjectDistance::Unknown => None,
            ObjectDistance::Infinity => Some(f64::INFINITY),
            ObjectDistance::Metres(metres) => Some(metres),
        });
        metres.collect()
    }

    fn __len__(&self) -> usize {
        self.count()
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.frame_size();
        let (count, channels) = (self.count(), self.channels().join(", "));
        format!(
            "<seidel.ObservationSet of {count} PSFs: {width} x {height} px, channels {channels}>"
        )
    }
}

/// Reads a set: an `ObservationSet`, or the path of one.
///
/// # Errors
/// Something else, and a set that cannot be read.
pub(crate) fn read(set: &Bound<'_, PyAny>) -> Result<NamedSet> {
    if let Ok(set) = set.cast::<ObservationSet>() {
        return Ok(set.get().named.clone());
    }
    let path: PathBuf = set.extract()?;
    let read = manifest::read(&path, ReadOptions::default())?;
    Ok(NamedSet {
        set: read.set,
        name: short_name(&path),
    })
}

/// Reads a set, or every set of a sequence.
///
/// # Errors
/// Those of [`read`].
pub(crate) fn read_all(sets: &Bound<'_, PyAny>) -> Result<Vec<NamedSet>> {
    let is_single = sets.is_instance_of::<ObservationSet>() || sets.extract::<PathBuf>().is_ok();
    if is_single {
        return Ok(vec![read(sets)?]);
    }
    sets.try_iter()?.map(|set| read(&set?)).collect()
}

/// The last part of a path.
fn short_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

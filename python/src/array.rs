//! NumPy arrays as planes of samples, and planes as NumPy arrays.

use half::f16;
use numpy::ndarray::{ArrayView3, Axis, Ix3};
use numpy::{
    Element, PyArray1, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use seidel_core::Image;

use crate::error::{Failure, Result, warn};

/// Sample type of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SampleType {
    /// `float16`.
    Half,
    /// `float32`.
    Float,
    /// `uint16`, of photographs only.
    Count,
}

/// Size and sample type of an image array: that of the result is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ArrayLayout {
    pub(crate) height: usize,
    pub(crate) width: usize,
    /// Third dimension; `None` for an array of two dimensions.
    channels: Option<usize>,
    sample: SampleType,
}

impl ArrayLayout {
    /// The layout of `float32` tiles of `size` x `size` pixels.
    pub(crate) fn of_tile(size: usize, channels: usize) -> Self {
        Self {
            height: size,
            width: size,
            channels: Some(channels),
            sample: SampleType::Float,
        }
    }

    /// The layout of a `float32` map for each of `channels` of an image of this layout.
    pub(crate) fn of_maps(&self, channels: usize) -> Self {
        Self {
            channels: self.channels.map(|_| channels),
            sample: SampleType::Float,
            ..*self
        }
    }

    /// The layout of a `float32` map of one number a pixel of an image of this layout.
    pub(crate) fn of_plane(&self) -> Self {
        Self {
            channels: None,
            sample: SampleType::Float,
            ..*self
        }
    }

    /// Sample type of the array.
    pub(crate) fn sample(&self) -> SampleType {
        self.sample
    }

    /// Number of channels, 1 for an array of two dimensions.
    pub(crate) fn channel_count(&self) -> usize {
        self.channels.unwrap_or(1)
    }
}

/// The channels of an array, one plane each, row-major.
pub(crate) struct ArrayPlanes {
    pub(crate) layout: ArrayLayout,
    pub(crate) planes: Vec<Vec<f32>>,
}

impl ArrayPlanes {
    /// Reads `array`, the argument `name`: HxW or HxWxC, `float32` or `float16`, with any strides. Samples are copied once,
    /// straight from the array. Other real numbers are converted to `float32`, with a `UserWarning`.
    ///
    /// # Errors
    /// Something else than an array, or one of another shape or sample type.
    pub(crate) fn read(name: &str, array: &Bound<'_, PyAny>) -> Result<Self> {
        let array = of_numpy(name, array)?;
        let untyped = array.cast::<PyUntypedArray>().map_err(PyErr::from)?;
        check_aligned(name, untyped)?;
        if let Ok(samples) = array.cast::<PyArrayDyn<f32>>() {
            return read_typed(name, samples, SampleType::Float);
        }
        if let Ok(samples) = array.cast::<PyArrayDyn<f16>>() {
            return read_typed(name, samples, SampleType::Half);
        }
        let converted = converted(name, untyped)?;
        let samples = converted.cast::<PyArrayDyn<f32>>().map_err(PyErr::from)?;
        read_typed(name, samples, SampleType::Float)
    }

    /// As [`ArrayPlanes::read`], also of `uint16`, as sensors count.
    ///
    /// # Errors
    /// Those of [`ArrayPlanes::read`].
    pub(crate) fn read_counts(name: &str, array: &Bound<'_, PyAny>) -> Result<Self> {
        match array.cast::<PyArrayDyn<u16>>() {
            Ok(samples) => {
                check_aligned(name, samples.as_untyped())?;
                read_typed(name, samples, SampleType::Count)
            }
            Err(_) => Self::read(name, array),
        }
    }

    /// Returns the single plane of an array that must have `height` x `width` pixels.
    ///
    /// # Errors
    /// Several channels, and another size.
    pub(crate) fn into_plane(self, name: &str, of: &ArrayLayout) -> Result<Vec<f32>> {
        let (own, ArrayLayout { width, height, .. }) = (self.layout, *of);
        if own.channel_count() != 1 || (own.height, own.width) != (height, width) {
            let channels = own.channel_count();
            return Err(Failure::argument(
                name,
                format!(
                    "has {} x {} pixels (rows x columns) and {channels} channels",
                    own.height, own.width
                ),
                format!("give {height} x {width} pixels, as the image has, and one channel"),
            ));
        }
        let mut planes = self.planes;
        Ok(planes.swap_remove(0))
    }
}

/// Returns `array`, the argument `name`, as an array of NumPy: itself, or a view of an object with `__dlpack__`,
/// `__array_interface__` or `__array__`.
///
/// # Errors
/// Another object, and one that is not in the memory of the CPU.
fn of_numpy<'py>(name: &str, array: &Bound<'py, PyAny>) -> Result<Bound<'py, PyAny>> {
    if array.cast::<PyUntypedArray>().is_ok() {
        return Ok(array.clone());
    }
    let given = array.get_type().name()?.to_string();
    let reader = if array.hasattr("__dlpack__")? {
        "from_dlpack"
    } else if array.hasattr("__array_interface__")? || array.hasattr("__array__")? {
        "asarray"
    } else {
        let remedy = "give an array, for instance by numpy.asarray";
        return Err(Failure::argument(
            name,
            format!("is of type {given}"),
            remedy,
        ));
    };
    let read = array.py().import("numpy")?.call_method1(reader, (array,));
    read.map_err(|error| {
        Failure::argument(
            name,
            format!("is of type {given} and cannot be read ({error})"),
            "give an array in the memory of the CPU, such as tensor.detach().cpu()",
        )
    })
}

/// Returns an array of other real numbers as `float32`, with a warning.
///
/// # Errors
/// Samples that are no real numbers.
fn converted<'py>(name: &str, array: &Bound<'py, PyUntypedArray>) -> Result<Bound<'py, PyAny>> {
    let (py, dtype) = (array.py(), array.dtype());
    let words = match dtype.kind() {
        b'f' => "converted to float32",
        b'i' | b'u' | b'b' => {
            "taken as scene-linear values as they are: divide by the value of white, and decode codes such as sRGB, before"
        }
        _ => {
            let problem = format!("has samples of type {dtype}");
            let remedy = "give scene-linear samples, best of type float32 or float16";
            return Err(Failure::argument(name, problem, remedy));
        }
    };
    warn(
        py,
        &[format!("{name}: samples of type {dtype} are {words}")],
    )?;
    Ok(array.call_method1("astype", ("float32",))?)
}

/// Rejects an array whose views must not be read in place.
fn check_aligned(name: &str, array: &Bound<'_, PyUntypedArray>) -> Result<()> {
    if array.getattr("flags")?.getattr("aligned")?.extract()? {
        return Ok(());
    }
    Err(Failure::argument(
        name,
        "has samples that are not aligned in memory",
        "give a copy of the array",
    ))
}

fn read_typed<T: Element + Copy + Into<f32>>(
    name: &str,
    array: &Bound<'_, PyArrayDyn<T>>,
    sample: SampleType,
) -> Result<ArrayPlanes> {
    let array: PyReadonlyArrayDyn<'_, T> = array.try_readonly().map_err(|error| {
        Failure::argument(
            name,
            format!("cannot be read ({error})"),
            "give an array that nothing else writes to",
        )
    })?;
    let view = array.as_array();
    let dimensions = view.ndim();
    let view = if dimensions == 2 {
        view.insert_axis(Axis(2))
    } else {
        view
    };
    let shape = view.shape().to_vec();
    let Ok(view) = view.into_dimensionality::<Ix3>() else {
        return Err(Failure::argument(
            name,
            format!("has {dimensions} dimensions"),
            "give an array of rows x columns, or of rows x columns x channels",
        ));
    };
    if shape.contains(&0) {
        return Err(Failure::argument(
            name,
            format!("has the shape {shape:?}"),
            "give at least one pixel and one channel",
        ));
    }
    Ok(ArrayPlanes {
        layout: ArrayLayout {
            height: shape[0],
            width: shape[1],
            channels: (dimensions == 3).then_some(shape[2]),
            sample,
        },
        planes: planes(&view),
    })
}

/// Copies the channels of `view`, whatever its strides are.
fn planes<T: Copy + Into<f32>>(view: &ArrayView3<'_, T>) -> Vec<Vec<f32>> {
    let channels = view.axis_iter(Axis(2));
    channels
        .map(|channel| channel.iter().map(|sample| (*sample).into()).collect())
        .collect()
}

/// Interleaved samples of a result, in the sample type of its array.
pub(crate) enum ResultSamples {
    /// `float16`.
    Half(Vec<f16>),
    /// `float32`.
    Float(Vec<f32>),
}

impl ResultSamples {
    /// Returns the samples of `image` for an array of `layout`. Values above the range of half floats become its limit, as in
    /// files that the command writes.
    pub(crate) fn of_image(image: &Image, layout: &ArrayLayout) -> Self {
        let planes = (image.colours.iter())
            .chain(&image.alpha)
            .chain(&image.channel_alphas);
        let planes: Vec<&[f32]> = planes.map(Vec::as_slice).collect();
        Self::of_planes(&planes, layout.sample)
    }

    /// Returns the samples of `planes`, interleaved.
    pub(crate) fn of_planes(planes: &[&[f32]], sample: SampleType) -> Self {
        match sample {
            SampleType::Float | SampleType::Count => {
                Self::Float(interleaved(planes, |sample| sample))
            }
            SampleType::Half => Self::Half(interleaved(planes, to_half)),
        }
    }

    /// Moves the samples into a new array of `layout`, which is C-contiguous.
    pub(crate) fn into_array<'py>(
        self,
        py: Python<'py>,
        layout: &ArrayLayout,
    ) -> Result<Bound<'py, PyAny>> {
        Ok(match self {
            Self::Float(samples) => into_array(PyArray1::from_vec(py, samples), layout)?,
            Self::Half(samples) => into_array(PyArray1::from_vec(py, samples), layout)?,
        })
    }
}

/// Pixels that are interleaved at once, so that they stay in the cache of a core.
const BLOCK_PX: usize = 2048;

/// Returns the samples of `planes`, changed by `convert`, a pixel after the other.
fn interleaved<T: Copy + Default>(planes: &[&[f32]], convert: impl Fn(f32) -> T) -> Vec<T> {
    let (count, pixels) = (planes.len(), planes.first().map_or(0, |plane| plane.len()));
    let mut samples = vec![T::default(); count * pixels];
    for (block, into) in samples.chunks_mut(count * BLOCK_PX).enumerate() {
        for (k, plane) in planes.iter().enumerate() {
            let from = &plane[block * BLOCK_PX..][..into.len() / count];
            for (sample, from) in into[k..].iter_mut().step_by(count).zip(from) {
                *sample = convert(*from);
            }
        }
    }
    samples
}

fn to_half(sample: f32) -> f16 {
    f16::from_f32(sample).clamp(f16::MIN, f16::MAX)
}

fn into_array<'py, T: Element>(
    array: Bound<'py, PyArray1<T>>,
    layout: &ArrayLayout,
) -> PyResult<Bound<'py, PyAny>> {
    let (height, width) = (layout.height, layout.width);
    Ok(match layout.channels {
        Some(channels) => array.reshape([height, width, channels])?.into_any(),
        None => array.reshape([height, width])?.into_any(),
    })
}

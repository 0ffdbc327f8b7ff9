//! The argument `depth`: one distance, an array of metres, or a depth pass with its convention.

use pyo3::prelude::*;
use seidel_core::{Depth, DepthConvention, DepthMeaning, DepthPass, ObjectDistance};

use crate::array::{ArrayLayout, ArrayPlanes};
use crate::error::{Failure, Result};

/// The attributes of `seidel.DepthPass`.
#[derive(FromPyObject)]
struct PassArgs<'py> {
    samples: Bound<'py, PyAny>,
    kind: String,
    unit: f64,
    near: Option<f64>,
    far: Option<f64>,
    along_ray: Option<f64>,
    filter_px: f64,
}

impl PassArgs<'_> {
    fn meaning(&self, of: &str) -> Result<DepthMeaning> {
        let metres_per_unit = self.unit;
        let limit = |name: &str, value: Option<f64>| {
            value.ok_or_else(|| {
                Failure::argument(
                    &format!("{of}.{name}"),
                    format!("is None, but its kind is {}", self.kind),
                    "give the distance in metres",
                )
            })
        };
        let convention = match self.kind.as_str() {
            "distance" => DepthConvention::Distance { metres_per_unit },
            "inverse" => DepthConvention::Inverse { metres_per_unit },
            "far-one" => DepthConvention::FarOne {
                near_m: limit("near", self.near)?,
                far_m: limit("far", self.far)?,
            },
            "far-zero" => DepthConvention::FarZero {
                near_m: limit("near", self.near)?,
                far_m: limit("far", self.far)?,
            },
            other => {
                return Err(Failure::argument(
                    &format!("{of}.kind"),
                    format!("is {other:?}"),
                    "give \"distance\", \"inverse\", \"far-one\" or \"far-zero\"",
                ));
            }
        };
        Ok(DepthMeaning {
            convention,
            along_ray: self.along_ray,
            averaged_px: self.filter_px,
        })
    }
}

/// Returns the object distance of a number of metres; unknown if it is `None`.
pub(crate) fn object_distance(metres: Option<f64>) -> Result<ObjectDistance> {
    Ok(match metres {
        Some(metres) => ObjectDistance::metres(metres)?,
        None => ObjectDistance::Unknown,
    })
}

/// Reads the argument `name`, the depth of an image of `layout`.
///
/// # Errors
/// A distance that is not positive, an array of another size, and an unknown convention.
pub(crate) fn read(
    name: &str,
    depth: Option<&Bound<'_, PyAny>>,
    layout: &ArrayLayout,
) -> Result<Depth> {
    let Some(depth) = depth else {
        return Ok(Depth::Distance(ObjectDistance::Unknown));
    };
    if let Ok(metres) = depth.extract::<f64>() {
        return Ok(Depth::Distance(ObjectDistance::metres(metres)?));
    }
    let (pass, own) = read_pass(name, depth)?;
    let samples = own.into_plane(name, layout)?;
    Ok(Depth::Pass(DepthPass { samples, ..pass }))
}

/// Reads the argument `name`, a depth pass, without an image.
///
/// # Errors
/// An array of several channels, and an unknown convention.
pub(crate) fn read_alone(
    name: &str,
    depth: &Bound<'_, PyAny>,
) -> Result<(DepthPass, ArrayLayout)> {
    let (pass, own) = read_pass(name, depth)?;
    let layout = own.layout;
    let samples = own.into_plane(name, &layout)?;
    Ok((DepthPass { samples, ..pass }, layout))
}

/// Reads the array and the meaning of a depth pass, whose samples are still in the planes of the array.
fn read_pass(name: &str, depth: &Bound<'_, PyAny>) -> Result<(DepthPass, ArrayPlanes)> {
    let (samples, meaning) = if depth.hasattr("samples")? {
        let args: PassArgs<'_> = depth.extract()?;
        let meaning = args.meaning(name)?;
        (args.samples, meaning)
    } else {
        (depth.clone(), DepthMeaning::METRES)
    };
    let pass = DepthPass {
        samples: Vec::new(),
        meaning,
    };
    Ok((pass, ArrayPlanes::read(name, &samples)?))
}

//! The look of a lens: the attributes of `seidel.Look`, as those of the core.

use pyo3::prelude::*;
use seidel_core::{AperturePicture, Blades, Look};

use crate::array::ArrayPlanes;
use crate::error::{Failure, Result};

/// The attributes of `seidel.Look`, which documents them.
#[derive(FromPyObject)]
pub(crate) struct LookArgs<'py> {
    blades: Option<u32>,
    roundness: f64,
    rotation: f64,
    aperture_picture: Option<Bound<'py, PyAny>>,
    squeeze: f64,
    obstruction: f64,
    cats_eye: f64,
    spherical: f64,
    axial_colour: f64,
    lateral_colour: f64,
}

impl LookArgs<'_> {
    /// Returns the look; its ranges are checked by the core.
    ///
    /// # Errors
    /// A picture that is no image array, or black, and a shape of blades without blades.
    pub(crate) fn look(&self) -> Result<Look> {
        if self.blades.is_none() && (self.roundness != 0.0 || self.rotation != 0.0) {
            return Err(Failure::argument(
                "look.blades",
                "is None, but roundness or rotation is given",
                "give the number of blades",
            ));
        }
        Ok(Look {
            blades: self.blades.map(|count| Blades {
                count,
                roundness: self.roundness,
                rotation_deg: self.rotation,
            }),
            picture: self.aperture_picture.as_ref().map(picture).transpose()?,
            squeeze: self.squeeze,
            obstruction: self.obstruction,
            cats_eye: self.cats_eye,
            spherical: self.spherical,
            axial_colour: self.axial_colour,
            lateral_colour: self.lateral_colour,
        })
    }
}

/// Returns the picture in `array`: the mean of R, G and B or the only channel, times alpha.
fn picture(array: &Bound<'_, PyAny>) -> Result<AperturePicture> {
    let ArrayPlanes { layout, planes } = ArrayPlanes::read("look.aperture_picture", array)?;
    let (colours, alpha) = match planes.len() {
        1 | 3 => (&planes[..], None),
        2 | 4 => (&planes[..planes.len() - 1], planes.last()),
        count => {
            return Err(Failure::argument(
                "look.aperture_picture",
                format!("has {count} channels"),
                "give 1 or 3, and 1 more for alpha",
            ));
        }
    };
    let colours: Vec<&[f32]> = colours.iter().map(Vec::as_slice).collect();
    let pixels = layout.width * layout.height;
    let samples = AperturePicture::transmission(pixels, &colours, alpha.map(Vec::as_slice));
    Ok(AperturePicture::new(layout.width, &samples)?)
}

//! The look of a lens: the attributes of `seidel.Look`, as those of the core.

use pyo3::prelude::*;
use seidel_core::{AperturePicture, Blades, Knob, Settings};

use crate::array::ArrayPlanes;
use crate::error::{Failure, Result};
use crate::settings::put_knobs;

/// The attributes of `seidel.Look` that are no knobs of the core's table, and the shape of the blades.
#[derive(FromPyObject)]
struct LookArgs<'py> {
    blades: Option<u32>,
    roundness: f64,
    rotation: f64,
    aperture_picture: Option<Bound<'py, PyAny>>,
}

/// Writes a `seidel.Look` to `settings`.
///
/// # Errors
/// A picture that is no image array, or black, a shape of blades without blades, and values out of range.
pub(crate) fn put_look(look: &Bound<'_, PyAny>, settings: &mut Settings) -> Result<()> {
    let args: LookArgs = look.extract()?;
    if args.blades.is_none() && (args.roundness != 0.0 || args.rotation != 0.0) {
        return Err(Failure::argument(
            "look.blades",
            "is None, but roundness or rotation is given",
            "give the number of blades",
        ));
    }
    settings.look.blades = args.blades.map(Blades::straight);
    settings.look.picture = args.aperture_picture.as_ref().map(picture).transpose()?;
    put_knobs(look, "look", settings, Knob::is_of_look)
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

//! The input Aperture as a picture of the aperture.

use std::rc::Rc;

use seidel_core::AperturePicture;

use super::inputs::image_of_input;
use crate::clips::APERTURE;
use crate::depth::InputChannel;
use crate::geometry::PixelMap;
use crate::host::{Call, Failure, Result};
use crate::knobs::{Knobs, look};

/// Index of the alpha channel.
const ALPHA: i32 = 3;

/// Returns the picture of the input Aperture, if it is switched on: the mean of R, G and B or the only channel, times A.
///
/// # Errors
/// No image in the input, and a picture that is black.
pub(crate) fn aperture_picture(
    call: &Call,
    knobs: &Knobs,
    map: PixelMap,
) -> Result<Option<AperturePicture>> {
    if !knobs.is_on(&look::USE_APERTURE) {
        return Ok(None);
    }
    let image = image_of_input(call, knobs, APERTURE, &look::USE_APERTURE)?;
    let image = Rc::new(image.ok_or_else(|| {
        Failure::failed(
            "Aperture: the input has no image; connect a picture that is white where light passes, or switch Use Aperture off.",
        )
    })?);
    let area = map.rectangle(image.bounds);
    let read = |channel: i32| -> Result<Vec<f32>> {
        let channel = InputChannel::new(&image, map, channel, "Aperture", None)?;
        channel.map_or(Ok(Vec::new()), |channel| channel.samples(area))
    };
    let colours: &[i32] = if image.channels == 1 {
        &[0]
    } else {
        &[0, 1, 2]
    };
    let colours: Vec<_> = colours
        .iter()
        .map(|channel| read(*channel))
        .collect::<Result<_>>()?;
    let colours: Vec<&[f32]> = colours.iter().map(Vec::as_slice).collect();
    let alpha = (image.channels == 4).then(|| read(ALPHA)).transpose()?;
    let pixels = area.width * area.height;
    let samples = AperturePicture::transmission(pixels, &colours, alpha.as_deref());
    Ok(Some(AperturePicture::new(area.width, &samples)?))
}

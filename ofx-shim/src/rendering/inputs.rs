//! What goes in beside the source: depth and holdout.

use std::ffi::CStr;

use crate::actions::Call;
use crate::clips::{DEPTH, HOLDOUT};
use crate::depth::{Made, Reading, channel_of};
use crate::geometry::Plane;
use crate::host::{Clip, Failure, Image, Result};
use crate::knobs::{Knob, Knobs, depth, lens, render};
use crate::lens::Info;
use crate::setup::focus_vergence;
use crate::sys::clip::{PREMULTIPLICATION, UNPREMULTIPLIED};

/// Pictures beside the source, as the library takes them.
pub(crate) struct Inputs<'h> {
    pub(crate) depth: Option<Made>,
    pub(crate) matte: Option<Made>,
    pub(crate) matte_depth: Option<Made>,
    /// They are the host's until they are let go.
    _images: Vec<Image<'h>>,
}

/// The picture of an input that is switched on and connected; nothing also where it is connected and empty, as hosts say
/// of inputs that they do not know.
///
/// # Errors
/// A picture that is not as was agreed.
pub(crate) fn picture<'h>(
    call: &Call<'h>,
    knobs: &Knobs,
    (name, switch): (&CStr, &Knob),
    time: f64,
) -> Result<Option<Image<'h>>> {
    if !knobs.is_on(switch) {
        return Ok(None);
    }
    let clip = call.effect.clip(name).filter(Clip::is_connected);
    clip.map_or(Ok(None), |clip| clip.image(time))
}

impl<'h> Inputs<'h> {
    /// Those of a render with a lens.
    ///
    /// # Errors
    /// Pictures and knobs that do not go together.
    pub(crate) fn new(
        call: &Call<'h>,
        knobs: &Knobs,
        (info, plane): (&Info, &Plane),
        time: f64,
    ) -> Result<Self> {
        let mut inputs = Self {
            depth: None,
            matte: None,
            matte_depth: None,
            _images: Vec::new(),
        };
        let reading = Reading::new(knobs);
        let focus = match reading.needs_focus() {
            true => focus_vergence(knobs, info),
            false => Ok(0.0),
        };
        if let Some(image) = picture(call, knobs, (DEPTH, &depth::USE_DEPTH), time)? {
            let channel = knobs.choice(&depth::CHANNEL);
            let focus = focus.clone()?;
            inputs.depth = channel_of(
                (&image, plane),
                (channel, "Depth Channel"),
                Some((&reading, focus)),
            )?;
            inputs._images.push(image);
        }
        if knobs.choice(&lens::MODE) != lens::APPLY {
            return Ok(inputs);
        }
        if let Some(image) = picture(call, knobs, (HOLDOUT, &render::USE_HOLDOUT), time)? {
            if !knobs.is_on(&render::OCCLUSION) {
                return Err(Failure::failed(
                    "Holdout: needs Occlusion; switch that on, or Use Holdout off.",
                ));
            }
            let channel = knobs.choice(&render::HOLDOUT_CHANNEL);
            inputs.matte = channel_of((&image, plane), (channel, "Holdout Matte"), None)?;
            let channel = knobs.choice(&render::HOLDOUT_DEPTH) - 1;
            if channel >= 0 && inputs.matte.is_some() {
                let read = Some((&reading, focus?));
                inputs.matte_depth = channel_of((&image, plane), (channel, "Holdout Depth"), read)?;
            }
            inputs._images.push(image);
        }
        Ok(inputs)
    }
}

/// Whether colours of the source are not multiplied by alpha.
pub(crate) fn is_unpremultiplied(knobs: &Knobs, clip: &Clip, source: &Image) -> bool {
    match knobs.choice(&render::SOURCE_ALPHA) {
        1 => false,
        2 => true,
        _ => {
            source.channels == 4
                && (source.unpremultiplied
                    || clip.properties.equals(PREMULTIPLICATION, UNPREMULTIPLIED))
        }
    }
}

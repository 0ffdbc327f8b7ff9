//! The optional inputs of a render: depth and holdout.

use std::ffi::CStr;
use std::rc::Rc;

use seidel_core::{
    Depth, DepthMeaning, DepthPass, HoldoutMatte, Lens, ObjectDistance, PlateGeometry,
};

use crate::clips::{DEPTH, HOLDOUT};
use crate::depth::{DepthConversion, DepthEncoding, InputChannel};
use crate::geometry::{PixelMap, PlateScale};
use crate::host::{Call, Clip, Failure, Image, Result};
use crate::knobs::{Knob, Knobs, depth, lens, named, render};
use crate::settings::{depth_meaning, focus_vergence_per_m, plate_distance_m};

/// The optional inputs of a render.
pub(crate) struct Inputs<'h> {
    encoding: DepthEncoding,
    depth: Option<InputChannel<'h>>,
    matte: Option<InputChannel<'h>>,
    matte_depth: Option<InputChannel<'h>>,
}

/// Fetches the image of an input that the parameter `switch` enables. `None` if it is not connected, or connected without
/// an image, as some hosts report inputs of which they know nothing.
///
/// # Errors
/// An image of unexpected components or samples.
pub(crate) fn image_of_input<'h>(
    call: &Call<'h>,
    knobs: &Knobs,
    name: &CStr,
    switch: &Knob,
) -> Result<Option<Image<'h>>> {
    if !knobs.is_on(switch) {
        return Ok(None);
    }
    let clip = call.effect.clip(name).filter(Clip::is_connected);
    clip.map_or(Ok(None), |clip| clip.image(call.time()))
}

impl<'h> Inputs<'h> {
    /// Fetches the inputs of a render with the lens `profile`.
    ///
    /// # Errors
    /// Images that lack the chosen channel, and parameters that contradict each other.
    pub(crate) fn fetch(
        call: &Call<'h>,
        knobs: &Knobs,
        profile: &Lens,
        map: PixelMap,
    ) -> Result<Self> {
        let encoding = DepthEncoding::new(knobs);
        let mut inputs = Self {
            encoding,
            depth: None,
            matte: None,
            matte_depth: None,
        };
        let conversion = || -> Result<Option<DepthConversion>> {
            let focus_per_m = if encoding.is_relative_to_focus() {
                focus_vergence_per_m(knobs, profile)?
            } else {
                0.0
            };
            Ok(Some(DepthConversion {
                encoding,
                focus_per_m,
            }))
        };
        if let Some(image) = image_of_input(call, knobs, DEPTH, &depth::USE_DEPTH)? {
            let image = Rc::new(image);
            let channel = knobs.choice(&depth::CHANNEL);
            inputs.depth = InputChannel::new(&image, map, channel, "Depth Channel", conversion()?)?;
        }
        if knobs.choice(&lens::MODE) != lens::APPLY {
            return Ok(inputs);
        }
        if let Some(image) = image_of_input(call, knobs, HOLDOUT, &render::USE_HOLDOUT)? {
            if !knobs.is_on(named("occlusion")) {
                return Err(Failure::failed(
                    "Holdout: needs Occlusion; switch that on, or Use Holdout off.",
                ));
            }
            let image = Rc::new(image);
            let channel = knobs.choice(&render::HOLDOUT_CHANNEL);
            inputs.matte = InputChannel::new(&image, map, channel, "Holdout Matte", None)?;
            // The first option of the menu is "None", for a holdout in front of everything.
            let channel = knobs.choice(&render::HOLDOUT_DEPTH) - 1;
            if channel >= 0 {
                inputs.matte_depth =
                    InputChannel::new(&image, map, channel, "Holdout Depth", conversion()?)?;
            }
        }
        Ok(inputs)
    }

    /// Reads the depth of a plate of `geometry`: the depth pass, or else the one distance of the parameters.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn depth(
        &self,
        knobs: &Knobs,
        profile: &Lens,
        scale: PlateScale,
        geometry: &PlateGeometry,
    ) -> Result<Depth> {
        Ok(match &self.depth {
            Some(channel) => {
                let meaning = depth_meaning(knobs, &self.encoding, scale);
                Depth::Pass(depth_pass(channel, meaning, geometry)?)
            }
            None if profile.predictor().depends_on_depth() => {
                Depth::Distance(ObjectDistance::metres(plate_distance_m(knobs))?)
            }
            None => Depth::Distance(ObjectDistance::Unknown),
        })
    }

    /// Reads the holdout matte of a plate of `geometry`, where there is one.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn holdout(
        &self,
        knobs: &Knobs,
        scale: PlateScale,
        geometry: &PlateGeometry,
    ) -> Result<Option<HoldoutMatte>> {
        let Some(matte) = &self.matte else {
            return Ok(None);
        };
        let meaning = depth_meaning(knobs, &self.encoding, scale);
        let depth = self.matte_depth.as_ref();
        let depth = depth.map(|channel| depth_pass(channel, meaning, geometry));
        Ok(Some(HoldoutMatte {
            samples: matte.samples(geometry.data)?,
            depth: depth.transpose()?,
        }))
    }

    /// Returns a function that reads the vergences, 1/m, of a plate pixel and of those to its right.
    pub(crate) fn vergences_per_m(&self, knobs: &Knobs) -> impl FnMut((i32, i32), &mut [f64]) {
        let constant = 1.0 / knobs.number(&depth::DISTANCE);
        let mut reader = self.depth.as_ref().map(InputChannel::row_reader);
        let mut samples = Vec::new();
        move |pixel, row: &mut [f64]| match &mut reader {
            None => row.fill(constant),
            Some(read) => {
                samples.resize(row.len(), 0.0);
                read(pixel, &mut samples);
                for (vergence, sample) in row.iter_mut().zip(&samples) {
                    *vergence = self.encoding.vergence_per_m(*sample);
                }
            }
        }
    }

    /// Returns a function that returns the vergence of a plate pixel, 1/m.
    pub(crate) fn vergence_per_m(&self, knobs: &Knobs) -> impl Fn((i32, i32)) -> f64 {
        let constant = 1.0 / knobs.number(&depth::DISTANCE);
        let reader = self.depth.as_ref().map(InputChannel::reader);
        move |pixel| match &reader {
            None => constant,
            Some(sample) => self.encoding.vergence_per_m(sample(pixel)),
        }
    }
}

fn depth_pass(
    channel: &InputChannel,
    meaning: DepthMeaning,
    geometry: &PlateGeometry,
) -> Result<DepthPass> {
    Ok(DepthPass {
        samples: channel.samples(geometry.data)?,
        meaning,
    })
}

//! A plate in the caller's memory, and what is read of it: light, depth and matte, all owned.

use std::sync::Arc;

use seidel_core::{
    Depth, DepthPass, HoldoutMatte, Image, LensSession, ObjectDistance, PlateGeometry,
    PreparedDepth, PreparedHoldout, PreparedPlate, Rectangle,
};

use crate::image::{SeidelImage, SeidelRect, View};
use crate::pointers::{Sized64, sized};
use crate::settings::Settings;
use crate::status::{Failure, Result};

/// A plate. Pictures may hold a part of it, or more than it: what of the plate they lack counts as black, of depth and
/// mattes as the nearest pixel that there is.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelPlate {
    /// sizeof(SeidelPlate).
    pub size: u64,
    /// The picture proper: what the lens's frame is laid on, centre on centre.
    pub format: SeidelRect,
    /// All pixels that there are, with overscan: beyond them lies what `edges` says. No result for a part of it depends on
    /// how much of it is handed in, as long as that covers the region of interest.
    pub extent: SeidelRect,
    /// Its samples: linear light.
    pub source: *const SeidelImage,
    /// Depth: the first channel counts. NULL: all is at the settings' `distance`.
    pub depth: *const SeidelImage,
    /// Matte, 0 to 1, of something that will be in front: the first channel counts. May be NULL. (seidel_apply)
    pub matte: *const SeidelImage,
    /// Depth of the matte, read as `depth` is: only what is behind is kept back. May be NULL. (seidel_apply)
    pub matte_depth: *const SeidelImage,
    /// Alpha of each colour, where settings say `alpha_per_channel`: one channel a colour. NULL: they are as A.
    pub alphas: *const SeidelImage,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Sized64 for SeidelPlate {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            format: SeidelRect::EMPTY,
            extent: SeidelRect::EMPTY,
            source: std::ptr::null(),
            depth: std::ptr::null(),
            matte: std::ptr::null(),
            matte_depth: std::ptr::null(),
            alphas: std::ptr::null(),
        }
    }
}

/// A plate whose numbers were found to be sound.
pub(crate) struct Plate {
    pub(crate) format: SeidelRect,
    pub(crate) extent: SeidelRect,
    pub(crate) source: View,
    depth: Option<View>,
    matte: Option<View>,
    matte_depth: Option<View>,
    alphas: Option<View>,
}

/// Whether the matte of a plate takes part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HoldoutUse {
    Read,
    Ignore,
}

/// The place of a plate whose samples are not needed.
pub(crate) struct Ground {
    pub(crate) format: SeidelRect,
    pub(crate) extent: SeidelRect,
    /// Whether there are a depth and a matte.
    pub(crate) has_depth: bool,
    /// Channels of its source; nothing where that is not given.
    pub(crate) channels: Option<u32>,
}

const COLOURS: [&[&str]; 4] = [&["Y"], &["Y"], &["R", "G", "B"], &["R", "G", "B"]];

/// Names of the colours of a plate of so many channels.
fn colour_names(channels: usize) -> Vec<String> {
    let names = COLOURS[channels.clamp(1, 4) - 1];
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// Whether a plate of so many channels has an alpha.
fn has_alpha(channels: usize) -> bool {
    channels.is_multiple_of(2)
}

/// How many planes of light a plate has.
pub(crate) fn plane_count(channels: usize, settings: &Settings) -> usize {
    let own = has_alpha(channels) && settings.raw.alpha_per_channel == 1;
    channels + if own { COLOURS[channels - 1].len() } else { 0 }
}

impl Ground {
    /// That of the plate at `plate`.
    ///
    /// # Safety
    /// `plate` must be NULL or a plate.
    pub(crate) unsafe fn new(plate: *const SeidelPlate) -> Result<Self> {
        // SAFETY: as the caller vouches.
        let raw = unsafe { sized(plate, "plate")? };
        Self::check(&raw)?;
        // SAFETY: as the caller vouches.
        let source = unsafe { View::maybe(raw.source, "plate.source")? };
        Ok(Self {
            format: raw.format,
            extent: raw.extent,
            has_depth: !raw.depth.is_null(),
            channels: source.map(|view| view.channels as u32),
        })
    }

    fn check(raw: &SeidelPlate) -> Result<()> {
        raw.format.check("plate.format")?;
        raw.extent.check("plate.extent")
    }

    /// Its place in the frame of a lens.
    pub(crate) fn geometry(&self, settings: &Settings) -> PlateGeometry {
        geometry(self.format, self.extent, settings)
    }
}

/// The place of a plate of this format and extent in the frame of a lens.
fn geometry(format: SeidelRect, extent: SeidelRect, settings: &Settings) -> PlateGeometry {
    let rectangle = |rect: SeidelRect| Rectangle {
        x: rect.left,
        y: rect.top,
        width: rect.columns(),
        height: rect.height as usize,
    };
    PlateGeometry {
        display: rectangle(format),
        data: rectangle(extent),
        pixel_aspect: settings.raw.pixel_aspect,
        lens_scale: settings.lens_scale(),
    }
}

impl Plate {
    /// The plate at `plate`.
    ///
    /// # Safety
    /// `plate` must be NULL or a plate whose pictures can be read until the call ends.
    pub(crate) unsafe fn new(plate: *const SeidelPlate) -> Result<Self> {
        // SAFETY: as the caller vouches.
        let raw = unsafe { sized(plate, "plate")? };
        Ground::check(&raw)?;
        // SAFETY: as the caller vouches.
        unsafe {
            Ok(Self {
                format: raw.format,
                extent: raw.extent,
                source: View::new(raw.source, "plate.source")?,
                depth: View::maybe(raw.depth, "plate.depth")?,
                matte: View::maybe(raw.matte, "plate.matte")?,
                matte_depth: View::maybe(raw.matte_depth, "plate.matte_depth")?,
                alphas: View::maybe(raw.alphas, "plate.alphas")?,
            })
        }
    }

    /// Reads the plate and prepares it for the lens of `session`. `holdout` says whether its matte is read.
    pub(crate) fn prepare(
        &self,
        session: &Arc<LensSession>,
        settings: &Settings,
        holdout: HoldoutUse,
    ) -> Result<PreparedPlate> {
        let geometry = geometry(self.format, self.extent, settings);
        let depth = self.depth(session, &geometry, settings)?;
        let holdout = match holdout {
            HoldoutUse::Read => self.holdout(session, &geometry, settings)?,
            HoldoutUse::Ignore => None,
        };
        let image = self.image(settings)?;
        Ok(session.prepare_parts(image, geometry, depth, holdout)?)
    }

    /// How many colours it has.
    pub(crate) fn colour_count(&self) -> usize {
        COLOURS[self.source.channels - 1].len()
    }

    /// Its image; samples that are not finite are refused, or replaced where the settings say `scrub`.
    pub(crate) fn image(&self, settings: &Settings) -> Result<Image> {
        let channels = self.source.channels;
        let names = colour_names(channels);
        let own = settings.raw.alpha_per_channel == 1;
        if own && !has_alpha(channels) {
            return Err(Failure::argument(
                "settings.alpha_per_channel",
                "is 1, but the source has no alpha",
                "give a source of 2 or 4 channels",
            ));
        }
        let count = names.len();
        let plane = |view: &View, channel: usize, name: &str| {
            let plane = view.read(channel, self.extent)?;
            if settings.raw.scrub == 0 {
                self.check_finite(&plane, name)?;
            }
            Ok(plane)
        };
        let colours = (0..count).map(|k| plane(&self.source, k, &names[k]));
        let colours = colours.collect::<Result<_>>()?;
        let alpha = has_alpha(channels).then(|| plane(&self.source, count, "A"));
        let alpha = alpha.transpose()?;
        let own_alphas = match (own, &self.alphas) {
            (false, _) => Vec::new(),
            (true, None) => alpha.iter().cycle().take(count).cloned().collect(),
            (true, Some(view)) if view.channels == count => {
                let own = (0..count).map(|k| plane(view, k, &format!("alpha.{}", names[k])));
                own.collect::<Result<_>>()?
            }
            (true, Some(view)) => {
                return Err(Failure::argument(
                    "plate.alphas",
                    format!("has {} channels", view.channels),
                    "give one for each colour of the source",
                ));
            }
        };
        let (width, height) = (self.extent.columns(), self.extent.height as usize);
        let image = Image::new(width, height, names, colours)?;
        let mut image = image.with_alpha(alpha, own_alphas, settings.alpha_kind());
        if settings.raw.scrub == 1 {
            image.replace_non_finite();
        }
        Ok(image)
    }

    fn check_finite(&self, plane: &[f32], name: &str) -> Result<()> {
        match plane.iter().position(|sample| !sample.is_finite()) {
            None => Ok(()),
            Some(at) => Err(self.at_pixel(name, at, plane[at], "mend the plate, or set scrub")),
        }
    }

    fn at_pixel(&self, name: &str, at: usize, value: f32, remedy: &str) -> Failure {
        let columns = self.extent.columns();
        let (x, y) = ((at % columns) as i32, (at / columns) as i32);
        let place = (self.extent.left + x, self.extent.top + y);
        Failure::argument(
            &format!("channel {name}, pixel ({}, {})", place.0, place.1),
            format!("is {value}"),
            remedy,
        )
    }

    /// Its depth, or the distance of the settings.
    fn depth(
        &self,
        session: &LensSession,
        geometry: &PlateGeometry,
        settings: &Settings,
    ) -> Result<PreparedDepth> {
        let depth = match &self.depth {
            Some(view) => Depth::Pass(self.depth_pass(view, settings)?),
            None if session.lens().predictor().depends_on_depth() => {
                Depth::Distance(settings.distance()?)
            }
            None => {
                settings.distance()?;
                Depth::Distance(ObjectDistance::Unknown)
            }
        };
        let named = |e: seidel_core::Error| match &self.depth {
            Some(_) => e.within("plate.depth"),
            None => e,
        };
        Ok(PreparedDepth::new(session, geometry, depth).map_err(named)?)
    }

    fn depth_pass(&self, view: &View, settings: &Settings) -> Result<DepthPass> {
        Ok(DepthPass {
            samples: view.read_held(0, self.extent)?,
            meaning: settings.depth_meaning(),
        })
    }

    /// The matte of something in front, where there is one.
    fn holdout(
        &self,
        session: &LensSession,
        geometry: &PlateGeometry,
        settings: &Settings,
    ) -> Result<Option<PreparedHoldout>> {
        let Some(matte) = &self.matte else {
            return match self.matte_depth {
                None => Ok(None),
                Some(_) => Err(Failure::argument(
                    "plate.matte_depth",
                    "is given without a matte",
                    "give plate.matte as well",
                )),
            };
        };
        if settings.raw.occlusion == 0 {
            return Err(Failure::argument(
                "plate.matte",
                "needs occlusion",
                "set occlusion to 1, or give no matte",
            ));
        }
        let samples = matte.read_held(0, self.extent)?;
        if let Some(at) = samples.iter().position(|v| !(0.0..=1.0).contains(v)) {
            let remedy = "give a matte of values from 0 to 1";
            return Err(self.at_pixel("plate.matte", at, samples[at], remedy));
        }
        let depth = self.matte_depth.as_ref();
        let depth = depth.map(|view| self.depth_pass(view, settings));
        let matte = HoldoutMatte {
            samples,
            depth: depth.transpose()?,
        };
        let holdout = PreparedHoldout::new(session, geometry, matte);
        Ok(Some(holdout.map_err(|e| e.within("plate.matte_depth"))?))
    }

    /// Refuses pictures of other channels to put results in.
    pub(crate) fn check_outputs(
        &self,
        settings: &Settings,
        output: &View,
        alphas: Option<&View>,
    ) -> Result<()> {
        if output.channels != self.source.channels {
            return Err(Failure::argument(
                "output.channels",
                format!(
                    "is {}, that of the source {}",
                    output.channels, self.source.channels
                ),
                "give as many",
            ));
        }
        match (settings.raw.alpha_per_channel == 1, alphas) {
            (true, Some(view)) if view.channels == self.colour_count() => Ok(()),
            (false, None) => Ok(()),
            (true, _) => Err(Failure::argument(
                "alphas",
                "is NULL, or has not one channel a colour",
                "give a picture for the alpha of each colour, or set alpha_per_channel to 0",
            )),
            (false, Some(_)) => Err(Failure::argument(
                "alphas",
                "is given without alpha_per_channel",
                "set it to 1, or give NULL",
            )),
        }
    }
}

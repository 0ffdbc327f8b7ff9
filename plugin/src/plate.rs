//! A plate in the caller's memory, and owned copies of its samples, depth and matte.

use std::sync::Arc;

use seidel_core::{
    Depth, DepthPass, HoldoutMatte, Image, LensSession, ObjectDistance, PlateGeometry,
    PreparedDepth, PreparedHoldout, PreparedPlate, Rectangle,
};

use crate::image::{ImageView, SeidelImage, SeidelRect};
use crate::pointers::{Versioned, read_versioned};
use crate::settings::Settings;
use crate::status::{Failure, Result};

/// A plate. Its images may hold more or less than the extent. Pixels of the extent that `source` or `alphas` lacks
/// are black and transparent; where a depth image or matte has no pixel, its nearest one counts.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelPlate {
    /// sizeof(SeidelPlate).
    pub size: u64,
    /// Display window: the picture without overscan. It lies centre on centre with the frame of the lens.
    pub format: SeidelRect,
    /// Data window: all pixels that exist, overscan or crop included. Beyond it lies what `edges` of the settings
    /// states.
    pub extent: SeidelRect,
    /// Scene-linear samples.
    pub source: *const SeidelImage,
    /// Depth image, of which the first channel is read. NULL: everything is at `distance` of the settings.
    pub depth: *const SeidelImage,
    /// Holdout matte, 0 to 1, of something that will be composited in front; its first channel is read. NULL: none.
    /// Only seidel_apply reads it.
    pub matte: *const SeidelImage,
    /// Depth of the matte, with the conventions of `depth`: only light from behind it is held out. NULL: all light
    /// is.
    pub matte_depth: *const SeidelImage,
    /// Alpha of each colour, one channel a colour, if `alpha_per_channel` is set. NULL: each is the alpha of
    /// `source`.
    pub alphas: *const SeidelImage,
    /// Mask of seidel_apply, 0 to 1; its first channel is read. By `mask_scales` of the settings it is the weight of the blurred plate
    /// against its own pixels, times `mix`, or a factor of the blur. NULL: 1 everywhere.
    pub mask: *const SeidelImage,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and raw pointers.
unsafe impl Versioned for SeidelPlate {
    const MIN_SIZE: usize = std::mem::offset_of!(Self, mask);

    fn defaults() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            format: SeidelRect::EMPTY,
            extent: SeidelRect::EMPTY,
            source: std::ptr::null(),
            depth: std::ptr::null(),
            matte: std::ptr::null(),
            matte_depth: std::ptr::null(),
            alphas: std::ptr::null(),
            mask: std::ptr::null(),
        }
    }
}

/// Names of the colours of a plate, by its number of channels less one.
const COLOURS: [&[&str]; 4] = [&["Y"], &["Y"], &["R", "G", "B"], &["R", "G", "B"]];

/// Returns whether a plate of `channels` channels, 1 to 4, has an alpha.
fn has_alpha(channels: usize) -> bool {
    channels.is_multiple_of(2)
}

/// Number of planes that are rendered of a plate of `channels` channels.
pub(crate) fn plane_count(channels: usize, settings: &Settings) -> usize {
    let channel_alphas = if has_alpha(channels) && settings.raw.alpha_per_channel == 1 {
        COLOURS[channels - 1].len()
    } else {
        0
    };
    channels + channel_alphas
}

/// The windows and channels of a plate, without samples.
pub(crate) struct PlateLayout {
    format: SeidelRect,
    pub(crate) extent: SeidelRect,
    /// Whether there is a depth image.
    pub(crate) has_depth: bool,
    /// Channels of the source; `None` if there is no source.
    pub(crate) channels: Option<usize>,
}

impl PlateLayout {
    /// Checks the windows and the source of the plate at `plate`.
    ///
    /// # Safety
    /// `plate` must be NULL or a plate.
    pub(crate) unsafe fn new(plate: *const SeidelPlate) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let raw = unsafe { read_versioned(plate, "plate")? };
        Self::check_windows(&raw)?;
        // SAFETY: as the caller guarantees.
        let source = unsafe { ImageView::optional(raw.source, "plate.source")? };
        Ok(Self::of(&raw, source.as_ref()))
    }

    fn check_windows(raw: &SeidelPlate) -> Result<()> {
        raw.format.check("plate.format")?;
        raw.extent.check("plate.extent")
    }

    fn of(raw: &SeidelPlate, source: Option<&ImageView>) -> Self {
        Self {
            format: raw.format,
            extent: raw.extent,
            has_depth: !raw.depth.is_null(),
            channels: source.map(|view| view.channels),
        }
    }

    /// The place of the plate in the frame of a lens.
    pub(crate) fn geometry(&self, settings: &Settings) -> PlateGeometry {
        let rectangle = |rect: SeidelRect| Rectangle {
            x: rect.left,
            y: rect.top,
            width: rect.columns(),
            height: rect.height as usize,
        };
        PlateGeometry {
            display: rectangle(self.format),
            data: rectangle(self.extent),
            pixel_aspect: settings.raw.pixel_aspect,
            lens_scale: settings.lens_scale(),
        }
    }
}

/// The use of a plate's holdout matte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HoldoutUse {
    Read,
    Ignore,
}

/// A plate of the caller whose windows and images were checked.
pub(crate) struct Plate {
    layout: PlateLayout,
    pub(crate) source: ImageView,
    depth: Option<ImageView>,
    matte: Option<ImageView>,
    matte_depth: Option<ImageView>,
    alphas: Option<ImageView>,
    mask: Option<ImageView>,
}

impl Plate {
    /// Checks the plate at `plate`.
    ///
    /// # Safety
    /// `plate` must be NULL or a plate whose images can be read until the call ends.
    pub(crate) unsafe fn new(plate: *const SeidelPlate) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let raw = unsafe { read_versioned(plate, "plate")? };
        PlateLayout::check_windows(&raw)?;
        // SAFETY: as the caller guarantees.
        unsafe {
            let source = ImageView::new(raw.source, "plate.source")?;
            Ok(Self {
                layout: PlateLayout::of(&raw, Some(&source)),
                source,
                depth: ImageView::optional(raw.depth, "plate.depth")?,
                matte: ImageView::optional(raw.matte, "plate.matte")?,
                matte_depth: ImageView::optional(raw.matte_depth, "plate.matte_depth")?,
                alphas: ImageView::optional(raw.alphas, "plate.alphas")?,
                mask: ImageView::optional(raw.mask, "plate.mask")?,
            })
        }
    }

    /// Windows and channels.
    pub(crate) fn layout(&self) -> &PlateLayout {
        &self.layout
    }

    /// The data window.
    pub(crate) fn extent(&self) -> SeidelRect {
        self.layout.extent
    }

    /// Copies the plate and prepares it for the lens of `session`.
    pub(crate) fn prepare(
        &self,
        session: &Arc<LensSession>,
        settings: &Settings,
        holdout: HoldoutUse,
    ) -> Result<PreparedPlate> {
        let geometry = self.layout.geometry(settings);
        let depth = self.depth(session, &geometry, settings)?;
        let holdout = match holdout {
            HoldoutUse::Read => self.holdout(session, &geometry, settings)?,
            HoldoutUse::Ignore => None,
        };
        let image = self.image(settings)?;
        let mut prepared = session.prepare_parts(image, geometry, depth, holdout)?;
        if let Some(view) = &self.mask {
            let mask = view.read_clamped(0, self.extent())?;
            (prepared.set_mask(mask)).map_err(|error| error.within("plate.mask"))?;
        }
        Ok(prepared)
    }

    /// Number of its colours.
    pub(crate) fn colour_count(&self) -> usize {
        COLOURS[self.source.channels - 1].len()
    }

    /// Copies the image over the extent.
    ///
    /// # Errors
    /// A sample that is not finite, unless the settings replace it by zero, and alphas that do not fit the source.
    pub(crate) fn image(&self, settings: &Settings) -> Result<Image> {
        let channels = self.source.channels;
        let names = COLOURS[channels - 1];
        let alpha_per_channel = settings.raw.alpha_per_channel == 1;
        if alpha_per_channel && !has_alpha(channels) {
            return Err(Failure::argument(
                "settings.alpha_per_channel",
                "is 1, but the source has no alpha",
                "give a source of 2 or 4 channels",
            ));
        }
        let count = names.len();
        let plane = |view: &ImageView, channel: usize, name: &str| {
            let plane = view.read(channel, self.extent())?;
            if settings.raw.scrub == 0 {
                self.check_finite(&plane, name)?;
            }
            Ok(plane)
        };
        let colours = (0..count).map(|k| plane(&self.source, k, names[k]));
        let colours = colours.collect::<Result<_>>()?;
        let alpha = has_alpha(channels).then(|| plane(&self.source, count, "A"));
        let alpha = alpha.transpose()?;
        let channel_alphas = match &self.alphas {
            _ if !alpha_per_channel => Vec::new(),
            None => alpha.iter().cycle().take(count).cloned().collect(),
            Some(view) if view.channels == count => {
                let planes = (0..count).map(|k| plane(view, k, &format!("alpha.{}", names[k])));
                planes.collect::<Result<_>>()?
            }
            Some(view) => {
                return Err(Failure::argument(
                    "plate.alphas",
                    format!("has {} channels", view.channels),
                    &format!("give one for each colour of the source, {count}"),
                ));
            }
        };
        let (width, height) = (self.extent().columns(), self.extent().height as usize);
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let image = Image::new(width, height, names, colours)?;
        let mut image = image.with_alpha(alpha, channel_alphas, settings.alpha_kind());
        if settings.raw.scrub == 1 {
            image.replace_non_finite();
        }
        Ok(image)
    }

    fn check_finite(&self, plane: &[f32], channel: &str) -> Result<()> {
        let bad = plane.iter().position(|sample| !sample.is_finite());
        bad.map_or(Ok(()), |at| {
            let remedy = "correct the plate, or set scrub to 1 to replace such samples by zero";
            Err(self.sample_error(channel, at, plane[at], remedy))
        })
    }

    /// The error of the sample `value` at index `at` of a plane over the extent.
    fn sample_error(&self, channel: &str, at: usize, value: f32, remedy: &str) -> Failure {
        let extent = self.extent();
        let x = extent.left + (at % extent.columns()) as i32;
        let y = extent.top + (at / extent.columns()) as i32;
        Failure::argument(
            &format!("channel {channel}, pixel ({x}, {y})"),
            format!("is {value}"),
            remedy,
        )
    }

    /// Prepares the depth image, or without one the distance of the settings.
    ///
    /// # Errors
    /// A depth image that is not valid, and a distance that the lens cannot follow.
    pub(crate) fn depth(
        &self,
        session: &LensSession,
        geometry: &PlateGeometry,
        settings: &Settings,
    ) -> Result<PreparedDepth> {
        if let Some(view) = &self.depth {
            let depth = Depth::Pass(self.depth_pass(view, settings)?);
            let prepared = PreparedDepth::new(session, geometry, depth);
            return Ok(prepared.map_err(|error| error.within("plate.depth"))?);
        }
        // An invalid distance is refused even if the lens does not need one.
        let distance = settings.distance()?;
        let distance = if session.lens().predictor().depends_on_depth() {
            distance
        } else {
            ObjectDistance::Unknown
        };
        Ok(PreparedDepth::new(
            session,
            geometry,
            Depth::Distance(distance),
        )?)
    }

    fn depth_pass(&self, view: &ImageView, settings: &Settings) -> Result<DepthPass> {
        Ok(DepthPass {
            samples: view.read_clamped(0, self.extent())?,
            meaning: settings.depth_meaning(),
        })
    }

    /// Prepares the holdout matte, if there is one.
    fn holdout(
        &self,
        session: &LensSession,
        geometry: &PlateGeometry,
        settings: &Settings,
    ) -> Result<Option<PreparedHoldout>> {
        let Some(matte) = &self.matte else {
            if self.matte_depth.is_some() {
                return Err(Failure::argument(
                    "plate.matte_depth",
                    "has no matte",
                    "give plate.matte as well",
                ));
            }
            return Ok(None);
        };
        if settings.raw.occlusion == 0 {
            return Err(Failure::argument(
                "plate.matte",
                "needs occlusion",
                "set occlusion to 1, or give no matte",
            ));
        }
        let samples = matte.read_clamped(0, self.extent())?;
        if let Some(at) = samples.iter().position(|v| !(0.0..=1.0).contains(v)) {
            let remedy = "give a matte of values from 0 to 1";
            return Err(self.sample_error("plate.matte", at, samples[at], remedy));
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

    /// Checks that `output` has the channels of the plate, and that `alphas` fits the settings.
    pub(crate) fn check_outputs(
        &self,
        settings: &Settings,
        output: &ImageView,
        alphas: Option<&ImageView>,
    ) -> Result<()> {
        if output.channels != self.source.channels {
            return Err(Failure::argument(
                "output.channels",
                format!(
                    "is {}, but the source has {}",
                    output.channels, self.source.channels
                ),
                "give the same number",
            ));
        }
        let is_wanted = settings.raw.alpha_per_channel == 1;
        match alphas {
            Some(_) if !is_wanted => Err(Failure::argument(
                "alphas",
                "is given, but alpha_per_channel is 0",
                "set it to 1, or give NULL",
            )),
            Some(view) if view.channels == self.colour_count() => Ok(()),
            None if !is_wanted => Ok(()),
            _ => Err(Failure::argument(
                "alphas",
                "is NULL, or does not have one channel for each colour",
                "give an image for the alpha of each colour, or set alpha_per_channel to 0",
            )),
        }
    }

    /// Checks that `output` lies in the data window.
    pub(crate) fn check_inside(&self, output: &ImageView) -> Result<()> {
        if self.extent().contains(output.rect) {
            return Ok(());
        }
        Err(Failure::argument(
            "output.rect",
            "does not lie in plate.extent",
            "give a rectangle of pixels of the plate",
        ))
    }
}

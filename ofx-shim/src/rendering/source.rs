//! The source of a render.

use std::ffi::CStr;

use seidel_core::{AlphaKind, Image as CoreImage, Rectangle};

use crate::colour::{AlphaHandling, Encoding};
use crate::geometry::PixelMap;
use crate::host::{Call, Clip, Failure, Image, Result};
use crate::interleaved::Interleaved;
use crate::knobs::{Knobs, render};
use crate::plate_image::{PlateImage, collect_rows};
use crate::sys::clip::{PREMULTIPLICATION, UNPREMULTIPLIED};
use crate::sys::effect::CLIP_SOURCE;

/// The source clip and its image.
pub(crate) struct Source<'h> {
    pub(crate) clip: Clip<'h>,
    pub(crate) image: Image<'h>,
}

impl<'h> Source<'h> {
    /// Fetches the source, or `None` if nothing is connected.
    ///
    /// # Errors
    /// An image of unexpected components or samples.
    pub(crate) fn fetch(call: &Call<'h>) -> Result<Option<Self>> {
        // Hosts that show a source do not all report it as connected.
        Self::of_clip(call, call.effect.clip(CLIP_SOURCE))
    }

    /// Fetches an optional input, of colours like the source, or `None` if nothing is connected.
    ///
    /// # Errors
    /// An image of unexpected components or samples.
    pub(crate) fn fetch_optional(call: &Call<'h>, name: &CStr) -> Result<Option<Self>> {
        Self::of_clip(call, call.effect.clip(name).filter(Clip::is_connected))
    }

    fn of_clip(call: &Call<'h>, clip: Option<Clip<'h>>) -> Result<Option<Self>> {
        let Some(clip) = clip else {
            return Ok(None);
        };
        let image = clip.image(call.time())?;
        Ok(image.map(|image| Self { clip, image }))
    }

    /// Returns the pixels that the image has, or `None` if it has none.
    pub(crate) fn rectangle(&self, map: PixelMap) -> Option<Rectangle> {
        PlateImage::new(&self.image, map).map(|view| view.rectangle())
    }

    /// Width of a pixel over its height.
    pub(crate) fn pixel_aspect(&self) -> f64 {
        let aspect = self.image.pixel_aspect.or(self.clip.pixel_aspect());
        aspect.unwrap_or(1.0)
    }

    /// Returns whether colours are multiplied by alpha: what the user says, or else the host.
    pub(crate) fn alpha_kind(&self, knobs: &Knobs) -> AlphaKind {
        let is_straight = || {
            self.image.channels == 4
                && (self.image.unpremultiplied
                    || self
                        .clip
                        .properties
                        .equals(PREMULTIPLICATION, UNPREMULTIPLIED))
        };
        match knobs.choice(&render::SOURCE_ALPHA) {
            1 => AlphaKind::Premultiplied,
            2 => AlphaKind::Unpremultiplied,
            _ if is_straight() => AlphaKind::Unpremultiplied,
            _ => AlphaKind::Premultiplied,
        }
    }

    /// Returns the encoding of the source, or `None` if it is scene-linear.
    ///
    /// # Errors
    /// Those of [`Encoding::chosen`].
    pub(crate) fn encoding(&self, call: &Call, knobs: &Knobs) -> Result<Option<Encoding>> {
        let alpha = match self.alpha_kind(knobs) {
            AlphaKind::Premultiplied => AlphaHandling::Premultiplied,
            AlphaKind::Unpremultiplied => AlphaHandling::Straight,
        };
        Encoding::chosen(knobs, alpha, call.host.threads())
    }

    /// Reads the pixels of `extent`, black where the image has none, as scene-linear planes.
    ///
    /// # Errors
    /// Samples that are not finite, or cannot be decoded, unless they are scrubbed; not enough memory.
    pub(crate) fn read(
        &self,
        knobs: &Knobs,
        map: PixelMap,
        extent: Rectangle,
        encoding: Option<&Encoding>,
    ) -> Result<CoreImage> {
        let kind = self.alpha_kind(knobs);
        let Some(view) = PlateImage::new(&self.image, map) else {
            let channels = self.image.channels as usize;
            return read_planes(extent, channels, kind, knobs, |_, _, _| {});
        };
        let channels = view.channels();
        let Some(encoding) = encoding else {
            return read_planes(extent, channels, kind, knobs, |pixel, channel, row| {
                view.read_channel(pixel, channel, row);
            });
        };
        let mut light = Interleaved::copy_of(&view)?;
        encoding.decode(&mut light)?;
        read_planes(extent, channels, kind, knobs, |pixel, channel, row| {
            light.read_channel(pixel, channel, row);
        })
    }
}

/// Returns an image of Y, RGB or RGBA, by the number of `channels`, over `extent`. The function `read` fills a row of a channel, from a
/// pixel on.
fn read_planes(
    extent: Rectangle,
    channels: usize,
    kind: AlphaKind,
    knobs: &Knobs,
    read: impl Fn((i32, i32), usize, &mut [f32]),
) -> Result<CoreImage> {
    let names: &[&str] = if channels == 1 {
        &["Y"]
    } else {
        &["R", "G", "B"]
    };
    let plane = |channel| collect_rows(extent, 1, |pixel, row| read(pixel, channel, row));
    let colours = (0..names.len()).map(plane).collect::<Result<Vec<_>>>()?;
    let alpha = (channels > names.len()).then(|| plane(names.len()));
    let names = names.iter().map(|name| (*name).to_owned()).collect();
    let image = CoreImage::new(extent.width, extent.height, names, colours)?;
    let mut image = image.with_alpha(alpha.transpose()?, Vec::new(), kind);
    if knobs.is_on(&render::SCRUB) {
        image.replace_non_finite();
    }
    image.check_finite().map_err(|error| {
        Failure::failed(format!(
            "Source: {} {}; repair the source, or switch Scrub on.",
            error.place, error.problem
        ))
    })?;
    Ok(image)
}

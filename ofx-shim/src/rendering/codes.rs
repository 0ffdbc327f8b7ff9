//! Sources whose numbers are codes of a camera or a display: turned to light before the library has them, and back after.
//! Gamuts stay as they are: blur is the same in any.

use seidel_c::{SEIDEL_FLOAT, SeidelImage, SeidelRect};
use seidel_colour::curves::{Form, own};

use crate::host::{Failure, Result};
use crate::knobs::{Knobs, render};
use crate::pixels::Pixels;

/// A picture of the plugin's own.
pub(crate) struct Copied {
    samples: Vec<f32>,
    rect: SeidelRect,
    channels: usize,
}

impl Copied {
    /// Of zeros.
    ///
    /// # Errors
    /// No memory for it.
    pub(crate) fn new(rect: SeidelRect, channels: u32) -> Result<Self> {
        let channels = channels as usize;
        let count = rect.width as usize * rect.height as usize * channels;
        let mut samples = Vec::new();
        samples.try_reserve_exact(count).map_err(|_| {
            Failure::memory(format!("Source Codes: no memory for {count} samples."))
        })?;
        samples.resize(count, 0.0);
        Ok(Self {
            samples,
            rect,
            channels,
        })
    }

    /// As the library takes it. It must be held for as long as that is used.
    pub(crate) fn image(&mut self) -> SeidelImage {
        SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: self.samples.as_mut_ptr().cast(),
            row_bytes: (4 * self.channels) as i64 * i64::from(self.rect.width),
            pixel_bytes: 0,
            channels: self.channels as u32,
            sample: SEIDEL_FLOAT,
            reserved: 0,
            rect: self.rect,
        }
    }

    /// Puts it into a picture of as many channels.
    pub(crate) fn put_into(&self, result: &Pixels) {
        let mut samples = self.samples.iter();
        result.each(self.rect, |result, place| {
            for (channel, sample) in (0..self.channels as u32).zip(samples.by_ref()) {
                result.put(place, channel, *sample);
            }
        });
    }

    fn changed(&mut self, premultiplied: bool, threads: u32, change: impl Fn(f64) -> f64 + Sync) {
        let channels = self.channels;
        let colours = channels.min(3);
        let pixel = |pixel: &mut [f32]| {
            let alpha = pixel.get(3).copied().unwrap_or(1.0);
            let divided = premultiplied && alpha != 0.0 && alpha.is_finite();
            let alpha = if divided { f64::from(alpha) } else { 1.0 };
            for sample in &mut pixel[..colours] {
                *sample = (alpha * change(f64::from(*sample) / alpha)) as f32;
            }
        };
        let threads = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads as usize,
        };
        let pixels = self.samples.len() / channels.max(1);
        let each = pixels.div_ceil(threads).max(1) * channels.max(1);
        std::thread::scope(|scope| {
            for part in self.samples.chunks_mut(each) {
                scope.spawn(|| part.chunks_exact_mut(channels).for_each(pixel));
            }
        });
    }
}

/// What the source's codes are.
#[derive(Clone, Copy)]
pub(crate) struct Codes {
    form: &'static Form,
    premultiplied: bool,
    threads: u32,
}

impl Codes {
    /// Those that are set; nothing where the source is light. Colour is premultiplied by alpha or not.
    ///
    /// # Errors
    /// None but of a build from a table that is not in order.
    pub(crate) fn of(knobs: &Knobs, premultiplied: bool, threads: u32) -> Result<Option<Self>> {
        let chosen = usize::try_from(knobs.choice(&render::SOURCE_CODES)).unwrap_or(0);
        let Some(name) = render::CURVES.get(chosen).filter(|name| !name.is_empty()) else {
            return Ok(None);
        };
        let table = own().map_err(|why| Failure::failed(why.to_string()))?;
        let curve = table.curves.get(*name);
        let curve = curve
            .ok_or_else(|| Failure::failed(format!("Source Codes: there is no curve {name}.")))?;
        Ok(Some(Self {
            form: &curve.form,
            premultiplied,
            threads,
        }))
    }

    /// The light of a source; a picture of alpha alone is none.
    ///
    /// # Errors
    /// No memory for it.
    pub(crate) fn light(&self, source: &Pixels, rect: SeidelRect) -> Result<Copied> {
        let mut light = Copied::new(rect, source.channels())?;
        let channels = light.channels;
        let mut samples = light.samples.iter_mut();
        source.each(rect, |source, place| {
            for (channel, sample) in (0..channels as u32).zip(samples.by_ref()) {
                *sample = source.get(place, channel).unwrap_or(0.0);
            }
        });
        if channels > 1 {
            light.changed(self.premultiplied, self.threads, |code| {
                self.form.linear(code)
            });
        }
        Ok(light)
    }

    /// Turns light back to codes.
    pub(crate) fn coded(&self, light: &mut Copied) {
        if light.channels > 1 {
            light.changed(self.premultiplied, self.threads, |light| {
                self.form.code(light)
            });
        }
    }
}

//! Pictures of the plugin's own, for what the library is to have or gives.

use std::panic::resume_unwind;
use std::thread;

use seidel_c::{SEIDEL_FLOAT, SeidelImage, SeidelRect};

use crate::host::{Failure, Result};
use crate::pixels::Pixels;

/// A picture.
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
            Failure::memory(format!(
                "No memory for {count} samples more; render less at a time."
            ))
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

    /// A copy of a source.
    ///
    /// # Errors
    /// No memory for it.
    pub(crate) fn of(source: &Pixels, rect: SeidelRect) -> Result<Self> {
        let mut copy = Self::new(rect, source.channels())?;
        let channels = copy.channels as u32;
        let mut samples = copy.samples.iter_mut();
        source.each(rect, |source, place| {
            for (channel, sample) in (0..channels).zip(samples.by_ref()) {
                *sample = source.get(place, channel).unwrap_or(0.0);
            }
        });
        Ok(copy)
    }

    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// Changes it part by part, each of whole pixels and on a thread of its own, and gives what was said of the parts. The
    /// threads, 0 for as many as there are, end with it: none may be left in a library that hosts unload.
    pub(crate) fn parts<R: Send>(
        &mut self,
        threads: u32,
        change: impl Fn(&mut [f32]) -> R + Sync,
    ) -> Vec<R> {
        let threads = match threads {
            0 => thread::available_parallelism().map_or(1, usize::from),
            threads => threads as usize,
        };
        let channels = self.channels.max(1);
        let pixels = self.samples.len() / channels;
        let each = pixels.div_ceil(threads).max(1) * channels;
        thread::scope(|scope| {
            let parts = self.samples.chunks_mut(each);
            let change = &change;
            let under_way: Vec<_> = parts
                .map(|part| scope.spawn(move || change(part)))
                .collect();
            let done = under_way.into_iter().map(|part| part.join());
            done.map(|said| said.unwrap_or_else(|panic| resume_unwind(panic)))
                .collect()
        })
    }
}

//! Conversion of images from one colour space to another.

use std::ops::Add;

use rayon::prelude::*;

use crate::batch::PixelBatch;
use crate::conversion_report::ConversionReport;
use crate::engine::EngineProcessor;
use crate::{ColourError, Result};

/// Pixels per call of an engine. Small enough for the cache; fixed, so that results do not depend on the number of
/// threads.
const CHUNK: usize = 4096;

/// The alpha by which the planes of an image are premultiplied.
#[derive(Debug, Clone, Copy)]
pub enum Alphas<'a> {
    /// None: colour is straight (unpremultiplied), or there is no alpha.
    Straight,
    /// One alpha for all planes.
    Shared(&'a [f32]),
    /// One alpha per plane, in the same order.
    PerPlane(&'a [Vec<f32>]),
}

impl Alphas<'_> {
    /// Returns the alphas of the three channels at index `i`.
    fn at(&self, i: usize) -> [f32; 3] {
        match self {
            Self::Straight => [1.0; 3],
            Self::Shared(alpha) => [alpha[i]; 3],
            Self::PerPlane([grey]) => [grey[i]; 3],
            Self::PerPlane(planes) => {
                std::array::from_fn(|k| planes.get(k).map_or(1.0, |plane| plane[i]))
            }
        }
    }
}

/// The layout of interleaved pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelLayout {
    /// R, G, B.
    Rgb,
    /// R, G, B and alpha, not premultiplied.
    RgbaStraight,
    /// R, G, B premultiplied by alpha, and alpha.
    RgbaPremultiplied,
}

impl PixelLayout {
    fn channels(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::RgbaStraight | Self::RgbaPremultiplied => 4,
        }
    }
}

/// A transform of images from one colour space to another.
pub struct Processor {
    engine: Box<dyn EngineProcessor>,
    config: String,
    from: String,
    to: String,
}

impl Processor {
    pub(crate) fn new(
        engine: Box<dyn EngineProcessor>,
        config: &str,
        from: &str,
        to: &str,
    ) -> Self {
        Self {
            engine,
            config: config.to_owned(),
            from: from.to_owned(),
            to: to.to_owned(),
        }
    }

    /// Returns the name of the source space.
    pub fn from(&self) -> &str {
        &self.from
    }

    /// Returns the name of the target space, or `DISPLAY/VIEW`.
    pub fn to(&self) -> &str {
        &self.to
    }

    /// Returns whether it leaves every sample unchanged, including those that are not finite.
    pub fn is_no_op(&self) -> bool {
        self.engine.is_no_op()
    }

    /// Converts an image in place: three planes R, G, B, or one plane of grey.
    ///
    /// Grey is converted as three equal channels, of which the result is the second. `alphas` are not converted.
    /// Pixels with neither colour nor alpha stay zero. Samples that are not finite become zero before the conversion.
    ///
    /// # Errors
    /// If there are not one or three planes, or sizes differ between planes and `alphas`.
    pub fn convert_planes(
        &self,
        planes: &mut [Vec<f32>],
        alphas: Alphas,
    ) -> Result<ConversionReport> {
        self.check_planes(planes, alphas)?;
        if self.is_no_op() {
            return Ok(ConversionReport::default());
        }
        let report = match planes {
            [grey] => {
                let chunks = grey.par_chunks_mut(CHUNK).enumerate();
                let reports = chunks.map(|(index, grey)| {
                    let first = index * CHUNK;
                    let pixels = (0..grey.len()).map(|i| ([grey[i]; 3], alphas.at(first + i)));
                    let (colours, report) = self.convert_chunk(pixels);
                    for (sample, colour) in grey.iter_mut().zip(colours) {
                        *sample = colour[1];
                    }
                    // Each sample was counted in up to three channels.
                    ConversionReport {
                        non_finite: report.non_finite / 3,
                        unrepresentable: report.unrepresentable.div_ceil(3),
                        ..report
                    }
                    .starting_at(first)
                });
                reports.reduce(ConversionReport::default, Add::add)
            }
            [red, green, blue] => {
                let (red, green) = (red.par_chunks_mut(CHUNK), green.par_chunks_mut(CHUNK));
                let chunks = red.zip(green).zip(blue.par_chunks_mut(CHUNK)).enumerate();
                let reports = chunks.map(|(index, ((red, green), blue))| {
                    let first = index * CHUNK;
                    let pixels =
                        (0..red.len()).map(|i| ([red[i], green[i], blue[i]], alphas.at(first + i)));
                    let (colours, report) = self.convert_chunk(pixels);
                    for (i, colour) in colours.into_iter().enumerate() {
                        [red[i], green[i], blue[i]] = colour;
                    }
                    report.starting_at(first)
                });
                reports.reduce(ConversionReport::default, Add::add)
            }
            _ => ConversionReport::default(),
        };
        Ok(report)
    }

    /// Converts interleaved pixels in place, except their alpha.
    ///
    /// # Errors
    /// If the length is not a multiple of the channels of `layout`.
    pub fn convert_pixels(
        &self,
        samples: &mut [f32],
        layout: PixelLayout,
    ) -> Result<ConversionReport> {
        self.check_pixels(samples, layout)?;
        let chunks = samples
            .par_chunks_mut(CHUNK * layout.channels())
            .enumerate();
        let reports = chunks.map(|(index, chunk)| {
            let report = self.convert_pixel_chunk(chunk, layout);
            report.starting_at(index * CHUNK)
        });
        Ok(reports.reduce(ConversionReport::default, Add::add))
    }

    /// Converts interleaved pixels in place on the calling thread only, for callers that manage threads themselves.
    ///
    /// # Errors
    /// If the length is not a multiple of the channels of `layout`.
    pub fn convert_pixels_serial(
        &self,
        samples: &mut [f32],
        layout: PixelLayout,
    ) -> Result<ConversionReport> {
        self.check_pixels(samples, layout)?;
        let chunks = samples.chunks_mut(CHUNK * layout.channels()).enumerate();
        let reports = chunks.map(|(index, chunk)| {
            let report = self.convert_pixel_chunk(chunk, layout);
            report.starting_at(index * CHUNK)
        });
        Ok(reports.fold(ConversionReport::default(), Add::add))
    }

    fn convert_pixel_chunk(&self, chunk: &mut [f32], layout: PixelLayout) -> ConversionReport {
        if self.is_no_op() {
            return ConversionReport::default();
        }
        let pixels = chunk.chunks_exact(layout.channels()).map(|pixel| {
            let alpha = if layout == PixelLayout::RgbaPremultiplied {
                pixel[3]
            } else {
                1.0
            };
            ([pixel[0], pixel[1], pixel[2]], [alpha; 3])
        });
        let (colours, report) = self.convert_chunk(pixels);
        for (pixel, colour) in chunk.chunks_exact_mut(layout.channels()).zip(colours) {
            pixel[..3].copy_from_slice(&colour);
        }
        report
    }

    /// Converts pixels, each given as colour and alpha of its channels.
    fn convert_chunk(
        &self,
        pixels: impl ExactSizeIterator<Item = ([f32; 3], [f32; 3])>,
    ) -> (Vec<[f32; 3]>, ConversionReport) {
        let mut batch = PixelBatch::new(pixels.len());
        for (colour, alpha) in pixels {
            batch.push(colour, alpha);
        }
        batch.convert(&*self.engine)
    }

    fn check_planes(&self, planes: &[Vec<f32>], alphas: Alphas) -> Result<()> {
        let size = planes.first().map_or(0, Vec::len);
        let has_size = |plane: &Vec<f32>| plane.len() == size;
        let alphas_fit = match alphas {
            Alphas::Straight => true,
            Alphas::Shared(alpha) => alpha.len() == size,
            Alphas::PerPlane(all) => all.len() == planes.len() && all.iter().all(has_size),
        };
        if matches!(planes.len(), 1 | 3) && planes.iter().all(has_size) && alphas_fit {
            return Ok(());
        }
        Err(self.error(
            format!(
                "the {} colour planes and their alphas differ in size, or are not 1 or 3",
                planes.len()
            ),
            "give R, G and B, or Y alone, and alphas of their size",
        ))
    }

    fn check_pixels(&self, samples: &[f32], layout: PixelLayout) -> Result<()> {
        let channels = layout.channels();
        if samples.len().is_multiple_of(channels) {
            return Ok(());
        }
        Err(self.error(
            format!("{} samples are no multiple of {channels}", samples.len()),
            "give whole pixels",
        ))
    }

    fn error(&self, problem: String, remedy: &str) -> ColourError {
        let field = format!("{} to {}", self.from, self.to);
        ColourError::new(&self.config, field, problem, remedy)
    }
}

//! What turns pictures in one colour space into pictures in another.

use std::ops::Add;

use rayon::prelude::*;

use crate::engine::EngineProcessor;
use crate::pixels::Pixels;
use crate::{ColourError, Result};

/// Pixels that go through an engine at a time: few enough for the cache, and as many with any number of threads.
const CHUNK: usize = 4096;

/// What colours are multiplied by.
#[derive(Debug, Clone, Copy)]
pub enum Alphas<'a> {
    /// Nothing: colours are as they are, or alpha goes with them without having been multiplied in.
    Straight,
    /// One alpha for all colours.
    Shared(&'a [f32]),
    /// An alpha for each colour, in the order of the planes.
    Each(&'a [Vec<f32>]),
}

/// How many samples could not go through a transform.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[must_use]
pub struct Report {
    /// Those that were NaN or infinite before; zero was put in their place.
    pub scrubbed: usize,
    /// Those that the other space has no finite number for; they are zero.
    pub unheld: usize,
}

impl Add for Report {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            scrubbed: self.scrubbed + other.scrubbed,
            unheld: self.unheld + other.unheld,
        }
    }
}

/// Turns colours of one space into those of another, on as many threads as there are; the same on each.
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
        (from, to): (&str, &str),
    ) -> Self {
        Self {
            engine,
            config: config.to_owned(),
            from: from.to_owned(),
            to: to.to_owned(),
        }
    }

    /// The space that colours are in before.
    pub fn from(&self) -> &str {
        &self.from
    }

    /// The space that they are in afterwards.
    pub fn to(&self) -> &str {
        &self.to
    }

    /// Whether it leaves all colours as they are, also those that are not finite.
    pub fn is_no_op(&self) -> bool {
        self.engine.is_no_op()
    }

    /// Turns three planes, or one of grey, in place. `alphas` stay as they are, and so does what they cover of nothing.
    /// What was not finite was zero for the other channels.
    ///
    /// Of grey, what the second of three equal channels becomes.
    ///
    /// # Errors
    /// Planes that are neither one nor three, or differ in size from each other or from `alphas`.
    pub fn planes(&self, planes: &mut [Vec<f32>], alphas: Alphas) -> Result<Report> {
        self.check(planes, alphas)?;
        if self.is_no_op() {
            return Ok(Report::default());
        }
        let alpha = |k: usize, i: usize| match alphas {
            Alphas::Straight => 1.0,
            Alphas::Shared(alpha) => alpha[i],
            Alphas::Each(all) => all.get(k).or(all.first()).map_or(1.0, |alpha| alpha[i]),
        };
        let alphas_at = |i: usize| [alpha(0, i), alpha(1, i), alpha(2, i)];
        let report = match planes {
            [grey] => {
                let chunks = grey.par_chunks_mut(CHUNK).enumerate();
                let reports = chunks.map(|(index, grey)| {
                    let first = index * CHUNK;
                    let pixel = |i: usize| ([grey[i]; 3], alphas_at(first + i));
                    let (colours, report) = self.chunk(grey.len(), pixel);
                    for (sample, colour) in grey.iter_mut().zip(colours) {
                        *sample = colour[1];
                    }
                    // Each sample stood for three.
                    Report {
                        scrubbed: report.scrubbed / 3,
                        unheld: report.unheld / 3,
                    }
                });
                reports.reduce(Report::default, Report::add)
            }
            [red, green, blue] => {
                let (red, green) = (red.par_chunks_mut(CHUNK), green.par_chunks_mut(CHUNK));
                let chunks = red.zip(green).zip(blue.par_chunks_mut(CHUNK)).enumerate();
                let reports = chunks.map(|(index, ((red, green), blue))| {
                    let first = index * CHUNK;
                    let pixel = |i: usize| ([red[i], green[i], blue[i]], alphas_at(first + i));
                    let (colours, report) = self.chunk(red.len(), pixel);
                    for (i, colour) in colours.into_iter().enumerate() {
                        (red[i], green[i], blue[i]) = (colour[0], colour[1], colour[2]);
                    }
                    report
                });
                reports.reduce(Report::default, Report::add)
            }
            _ => Report::default(),
        };
        Ok(report)
    }

    /// Turns rows of pixels of three or four floats, in place; the fourth is alpha, which stays. `premultiplied` says
    /// whether colours are multiplied by it.
    ///
    /// # Errors
    /// Pixels of another size, and a length that is no multiple of it.
    pub fn rows(&self, rows: &mut [f32], channels: usize, premultiplied: bool) -> Result<Report> {
        self.check_rows(rows, channels)?;
        if self.is_no_op() {
            return Ok(Report::default());
        }
        let chunks = rows.par_chunks_mut(CHUNK * channels);
        let reports = chunks.map(|chunk| self.row_chunk(chunk, channels, premultiplied));
        Ok(reports.reduce(Report::default, Report::add))
    }

    /// As [`Processor::rows`], on the thread that calls alone: for callers whose threads are their own affair.
    ///
    /// # Errors
    /// Those of [`Processor::rows`].
    pub fn rows_here(
        &self,
        rows: &mut [f32],
        channels: usize,
        premultiplied: bool,
    ) -> Result<Report> {
        self.check_rows(rows, channels)?;
        if self.is_no_op() {
            return Ok(Report::default());
        }
        let chunks = rows.chunks_mut(CHUNK * channels);
        let reports = chunks.map(|chunk| self.row_chunk(chunk, channels, premultiplied));
        Ok(reports.fold(Report::default(), Report::add))
    }

    fn check_rows(&self, rows: &[f32], channels: usize) -> Result<()> {
        if matches!(channels, 3 | 4) && rows.len().is_multiple_of(channels) {
            return Ok(());
        }
        Err(self.refused(
            format!("{} floats in pixels of {channels}", rows.len()),
            "give whole pixels of 3 or 4 floats",
        ))
    }

    fn row_chunk(&self, chunk: &mut [f32], channels: usize, premultiplied: bool) -> Report {
        let pixel = |i: usize| {
            let at = &chunk[i * channels..];
            let alpha = match premultiplied && channels == 4 {
                true => at[3],
                false => 1.0,
            };
            ([at[0], at[1], at[2]], [alpha; 3])
        };
        let (colours, report) = self.chunk(chunk.len() / channels, pixel);
        for (pixel, colour) in chunk.chunks_exact_mut(channels).zip(colours) {
            pixel[..3].copy_from_slice(&colour);
        }
        report
    }

    /// What becomes of `count` pixels, each with its alphas.
    fn chunk(
        &self,
        count: usize,
        pixel: impl Fn(usize) -> ([f32; 3], [f32; 3]),
    ) -> (Vec<[f32; 3]>, Report) {
        let (mut before, mut after) = (Report::default(), Report::default());
        let mut pixels = Pixels::new(count);
        for i in 0..count {
            let (colour, alpha) = pixel(i);
            pixels.push(colour, alpha, &mut before);
        }
        let colours = pixels.drain(&*self.engine, &mut after).collect();
        (colours, before + after)
    }

    fn refused(&self, problem: String, remedy: &str) -> ColourError {
        let field = format!("{} to {}", self.from, self.to);
        ColourError::new(&self.config, field, problem, remedy)
    }

    fn check(&self, planes: &[Vec<f32>], alphas: Alphas) -> Result<()> {
        let size = planes.first().map_or(0, Vec::len);
        let fits = |plane: &Vec<f32>| plane.len() == size;
        let alphas_fit = match alphas {
            Alphas::Straight => true,
            Alphas::Shared(alpha) => alpha.len() == size,
            Alphas::Each(all) => all.len() == planes.len() && all.iter().all(fits),
        };
        if matches!(planes.len(), 1 | 3) && planes.iter().all(fits) && alphas_fit {
            return Ok(());
        }
        Err(self.refused(
            format!("{} planes of colour, or their sizes", planes.len()),
            "give R, G and B, or Y alone, and alphas of their size",
        ))
    }
}

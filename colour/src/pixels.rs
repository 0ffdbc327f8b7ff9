//! What surrounds an engine's transform of a few pixels: samples that are not finite, and alpha.

use crate::engine::{EngineProcessor, Pixel};
use crate::processor::Report;

/// Pixels on their way through a transform, at most as many as it was made for.
pub(crate) struct Pixels {
    pixels: Vec<Pixel>,
    /// What each colour of each pixel was divided by.
    alphas: Vec<[f32; 3]>,
}

impl Pixels {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            pixels: Vec::with_capacity(most),
            alphas: Vec::with_capacity(most),
        }
    }

    /// Takes in a pixel whose colours are multiplied by `alpha` each.
    ///
    /// A transform that is no straight line through zero wants the colour itself, so it is divided by its alpha. Where
    /// nothing covers the pixel, its colour is light alone and goes as it is.
    pub(crate) fn push(&mut self, colour: [f32; 3], alpha: [f32; 3], report: &mut Report) {
        let mut pixel = [0.0, 0.0, 0.0, 1.0];
        let mut divided = [1.0; 3];
        let is_bare = |k: usize| alpha[k] == 0.0 && colour[k] == 0.0;
        if (0..3).all(is_bare) {
            // No light and nothing there: so it stays, though a log curve has a number for black.
            divided = [0.0; 3];
        }
        for k in 0..3 {
            if !colour[k].is_finite() {
                report.scrubbed += 1;
                continue;
            }
            let straight = colour[k] / alpha[k];
            if alpha[k] > 0.0 && alpha[k] != 1.0 && straight.is_finite() {
                pixel[k] = straight;
                divided[k] = alpha[k];
            } else {
                pixel[k] = colour[k];
            }
        }
        self.pixels.push(pixel);
        self.alphas.push(divided);
    }

    /// What becomes of the pixels, in their order; there are none afterwards. Numbers that are none or infinite are
    /// zero.
    pub(crate) fn drain<'a>(
        &'a mut self,
        processor: &dyn EngineProcessor,
        report: &'a mut Report,
    ) -> impl Iterator<Item = [f32; 3]> + 'a {
        processor.apply(&mut self.pixels);
        let done = self.pixels.drain(..).zip(self.alphas.drain(..));
        done.map(move |(pixel, divided)| {
            let mut colour = [0.0; 3];
            for k in 0..3 {
                match pixel[k].is_finite() {
                    // Not 0 times a colour, which may be minus zero.
                    true if divided[k] == 0.0 => {}
                    true => colour[k] = pixel[k] * divided[k],
                    false => report.unheld += 1,
                }
            }
            colour
        })
    }
}

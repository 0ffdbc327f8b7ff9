//! A batch of pixels for an engine, with alpha and non-finite samples handled around its transform.

use crate::conversion_report::{ConversionReport, SamplePlace};
use crate::engine::{EngineProcessor, Pixel};

/// Pixels on their way through a transform.
pub(crate) struct PixelBatch {
    pixels: Vec<Pixel>,
    /// Factor of each converted channel: the alpha it was divided by, or zero for an empty pixel.
    factors: Vec<[f32; 3]>,
    report: ConversionReport,
}

impl PixelBatch {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            pixels: Vec::with_capacity(capacity),
            factors: Vec::with_capacity(capacity),
            report: ConversionReport::default(),
        }
    }

    /// Adds a pixel whose channels are premultiplied by `alpha`.
    ///
    /// A non-linear transform needs straight colour, so channels are divided by alpha. Where alpha is zero, colour is
    /// pure emission and is not divided.
    pub(crate) fn push(&mut self, colour: [f32; 3], alpha: [f32; 3]) {
        let mut pixel = [0.0, 0.0, 0.0, 1.0];
        let mut factors = [1.0; 3];
        let is_empty = (0..3).all(|k| alpha[k] == 0.0 && colour[k] == 0.0);
        if is_empty {
            // An empty pixel stays zero, although a log curve has another code for black.
            factors = [0.0; 3];
        }
        for k in 0..3 {
            if !colour[k].is_finite() {
                self.report.non_finite += 1;
                continue;
            }
            let straight = colour[k] / alpha[k];
            if alpha[k] > 0.0 && alpha[k] != 1.0 && straight.is_finite() {
                pixel[k] = straight;
                factors[k] = alpha[k];
            } else {
                pixel[k] = colour[k];
            }
        }
        self.pixels.push(pixel);
        self.factors.push(factors);
    }

    /// Converts the pixels and returns their premultiplied colours, in order. Results that are not finite become zero.
    pub(crate) fn convert(
        mut self,
        processor: &dyn EngineProcessor,
    ) -> (Vec<[f32; 3]>, ConversionReport) {
        processor.apply(&mut self.pixels);
        let mut report = self.report;
        let converted = self.pixels.iter().zip(&self.factors);
        let colours = converted.enumerate().map(|(index, (pixel, factors))| {
            let mut colour = [0.0; 3];
            for k in 0..3 {
                // An empty pixel stays zero: 0 times a negative value would give -0.0.
                let value = if factors[k] == 0.0 && pixel[k].is_finite() {
                    0.0
                } else {
                    pixel[k] * factors[k]
                };
                if value.is_finite() {
                    colour[k] = value;
                    continue;
                }
                report.unrepresentable += 1;
                report.first_unrepresentable.get_or_insert(SamplePlace {
                    pixel: index,
                    channel: k,
                });
            }
            colour
        });
        (colours.collect(), report)
    }
}

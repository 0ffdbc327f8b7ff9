//! Sources in an encoding other than scene-linear: decoded before the core gets them, and encoded again afterwards.

mod curve;
mod spaces;

use seidel_colour::curves::TransferFunction;

use crate::host::Result;
use crate::interleaved::Interleaved;
use crate::knobs::{Knobs, colour, render};
use spaces::Spaces;

pub(crate) use spaces::clear;

/// The encoding of a source's samples.
pub(crate) struct Encoding {
    conversion: Conversion,
    alpha: AlphaHandling,
    non_finite: NonFinite,
    threads: u32,
}

/// Conversion between encoded and scene-linear samples.
enum Conversion {
    /// A transfer function on each channel. The gamut stays, since blur is the same in any.
    Curve(&'static TransferFunction),
    /// Two colour spaces of an OpenColorIO config.
    Spaces(Spaces),
}

/// Relation of encoded colours and alpha.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AlphaHandling {
    /// Colours are multiplied by alpha. They are divided by it before they are decoded.
    Premultiplied,
    /// Colours are not multiplied by alpha.
    Straight,
}

/// Treatment of samples that are not finite, or have no finite scene-linear value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NonFinite {
    Reject,
    BecomeZero,
}

impl Encoding {
    /// Returns the encoding that the parameters choose, or `None` for scene-linear sources. Colours are converted on
    /// `threads` threads, on all that the machine has if that is 0.
    ///
    /// # Errors
    /// A config that cannot be read, and colour spaces that it lacks.
    pub(crate) fn chosen(
        knobs: &Knobs,
        alpha: AlphaHandling,
        threads: u32,
    ) -> Result<Option<Self>> {
        let conversion = match knobs.choice(&colour::SOURCE_ENCODING) {
            colour::LINEAR => return Ok(None),
            colour::BY_OCIO => Conversion::Spaces(Spaces::chosen(knobs)?),
            curve => Conversion::Curve(curve::transfer_function(curve)?),
        };
        Ok(Some(Self {
            conversion,
            alpha,
            non_finite: if knobs.is_on(&render::SCRUB) {
                NonFinite::BecomeZero
            } else {
                NonFinite::Reject
            },
            threads,
        }))
    }

    /// Decodes `source` to scene-linear values. An image of alpha alone stays as it is.
    ///
    /// # Errors
    /// Samples without a scene-linear value, unless they are scrubbed.
    pub(crate) fn decode(&self, source: &mut Interleaved) -> Result<()> {
        if source.channels() == 1 {
            return Ok(());
        }
        match &self.conversion {
            Conversion::Curve(curve) => {
                curve::convert(source, self.alpha, self.threads, |code| curve.decode(code));
                Ok(())
            }
            Conversion::Spaces(spaces) => {
                spaces.decode(source, self.alpha, self.threads, self.non_finite)
            }
        }
    }

    /// Encodes scene-linear values as the source is encoded.
    ///
    /// # Errors
    /// Values that the encoding cannot represent.
    pub(crate) fn encode(&self, light: &mut Interleaved) -> Result<()> {
        if light.channels() == 1 {
            return Ok(());
        }
        match &self.conversion {
            Conversion::Curve(curve) => {
                curve::convert(light, self.alpha, self.threads, |value| curve.encode(value));
                Ok(())
            }
            Conversion::Spaces(spaces) => spaces.encode(light, self.alpha, self.threads),
        }
    }
}

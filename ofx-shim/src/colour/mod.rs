//! Sources whose numbers are no light: turned to light before the library has them, and back after.

mod curve;
mod spaces;

use seidel_c::SeidelRect;
use seidel_colour::curves::TransferFunction;

use crate::host::Result;
use crate::knobs::{Knobs, colour, render};
use crate::pixels::Pixels;
use crate::rendering::Copied;
use spaces::Spaces;

pub(crate) use spaces::forget;

/// What the source's numbers are.
pub(crate) struct Codes {
    way: Way,
    premultiplied: bool,
    scrub: bool,
    threads: u32,
}

/// How they become light.
enum Way {
    /// Channel by channel: gamuts stay as they are, blur is the same in any.
    Curve(&'static TransferFunction),
    /// As OpenColorIO has it.
    Spaces(Spaces),
}

impl Codes {
    /// Those that are set; nothing where the source is light. Colour is premultiplied by alpha or not.
    ///
    /// # Errors
    /// A config that cannot be read, and spaces that it does not have.
    pub(crate) fn of(knobs: &Knobs, premultiplied: bool, threads: u32) -> Result<Option<Self>> {
        let way = match knobs.choice(&colour::SOURCE_ENCODING) {
            colour::LINEAR => return Ok(None),
            colour::BY_OCIO => Way::Spaces(Spaces::of(knobs)?),
            curve => Way::Curve(curve::of(curve)?),
        };
        Ok(Some(Self {
            way,
            premultiplied,
            scrub: knobs.is_on(&render::SCRUB),
            threads,
        }))
    }

    /// The light of a source; a picture of alpha alone is none.
    ///
    /// # Errors
    /// No memory for it, and samples that have no light unless they are scrubbed.
    pub(crate) fn light(&self, source: &Pixels, rect: SeidelRect) -> Result<Copied> {
        let mut light = Copied::of(source, rect)?;
        if light.channels() == 1 {
            return Ok(light);
        }
        match &self.way {
            Way::Curve(form) => {
                let change = |code: f64| form.decode(code);
                curve::change(&mut light, self.premultiplied, self.threads, change);
            }
            Way::Spaces(spaces) => {
                spaces.light(&mut light, self.premultiplied, self.threads, self.scrub)?;
            }
        }
        Ok(light)
    }

    /// Turns light back to codes.
    ///
    /// # Errors
    /// Light that there is no code for.
    pub(crate) fn coded(&self, light: &mut Copied) -> Result<()> {
        if light.channels() == 1 {
            return Ok(());
        }
        match &self.way {
            Way::Curve(form) => {
                let change = |light: f64| form.encode(light);
                curve::change(light, self.premultiplied, self.threads, change);
                Ok(())
            }
            Way::Spaces(spaces) => spaces.coded(light, self.premultiplied, self.threads),
        }
    }
}

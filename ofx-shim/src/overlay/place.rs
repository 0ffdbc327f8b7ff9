//! Where the lens's frame lies in the viewer: canonical coordinates.

use std::sync::Arc;

use seidel_c::SeidelRect;

use crate::actions::{Call, chosen_lens};
use crate::geometry::{Field, Plane, Scale};
use crate::host::Result;
use crate::knobs::{Knobs, lens as knob};
use crate::lens::Lens;
use crate::rendering::project_of;
use crate::setup::{Circumstances, Setup};
use crate::sys::effect::CLIP_SOURCE;
use crate::sys::{OfxPointD, OfxRectI};

/// A lens over the frame of an instance, at full resolution.
pub(super) struct Place {
    pub(super) lens: Arc<Lens>,
    pub(super) setup: Setup,
    /// Of the plate, as the library has it.
    pub(super) format: SeidelRect,
    scale: Scale,
    pixels: OfxRectI,
}

impl Place {
    /// That at a time; nothing where it is not known how large the frame is.
    ///
    /// # Errors
    /// A lens that cannot be read, and knobs that cannot be so.
    pub(super) fn new(call: &Call, knobs: &Knobs, time: f64) -> Result<Option<Self>> {
        let clip = call.effect.clip(CLIP_SOURCE);
        let aspect = clip.and_then(|clip| clip.pixel_aspect()).unwrap_or(1.0);
        let scale = Scale::new([1.0; 2], aspect);
        let source = clip.and_then(|clip| clip.region_of_definition(time));
        let by_project = knobs.choice(&knob::FRAME) == knob::FRAME_PROJECT;
        let rect = match project_of(call).filter(|_| by_project) {
            Some(project) => Some(project),
            None => source,
        };
        let pixels = rect.map(|rect| scale.pixels_of(rect));
        let Some(pixels) = pixels.filter(|pixels| !crate::geometry::is_empty(*pixels)) else {
            return Ok(None);
        };
        let lens = chosen_lens(knobs, (&knob::LENS, &knob::PROFILE))?;
        let about = Circumstances {
            scale,
            field: Field::Whole,
            unpremultiplied: false,
            draft: false,
            threads: 0,
        };
        Ok(Some(Self {
            setup: Setup::new(knobs, &lens.info, &about)?,
            lens,
            format: Plane::new(pixels, Field::Whole).rect(pixels),
            scale,
            pixels,
        }))
    }

    /// Canonical coordinates of a place of the plate.
    pub(super) fn canonical(&self, (x, y): (f64, f64)) -> OfxPointD {
        OfxPointD {
            x: (f64::from(self.pixels.x1) + x) / self.scale.x,
            y: (f64::from(self.pixels.y2) - y) / self.scale.y,
        }
    }
}

//! The lens placed over the frame of an instance, and canonical coordinates of points of the plate.

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
pub(super) struct LensPlacement {
    pub(super) lens: Arc<Lens>,
    pub(super) setup: Setup,
    /// The plate's format, in plate pixels.
    pub(super) format: SeidelRect,
    scale: Scale,
    /// The format in the host's pixels, y up.
    pixels: OfxRectI,
}

impl LensPlacement {
    /// Places the lens at a time; `None` if the size of the frame is unknown.
    ///
    /// # Errors
    /// A lens that cannot be read; settings that contradict each other.
    pub(super) fn new(call: &Call, knobs: &Knobs, time: f64) -> Result<Option<Self>> {
        let clip = call.effect.clip(CLIP_SOURCE);
        let aspect = clip.and_then(|clip| clip.pixel_aspect()).unwrap_or(1.0);
        let scale = Scale::new([1.0; 2], aspect);
        let source = clip.and_then(|clip| clip.region_of_definition(time));
        let by_project = knobs.choice(&knob::FRAME) == knob::FRAME_PROJECT;
        let project = project_of(call).filter(|_| by_project);
        let pixels = project.or(source).map(|rect| scale.pixels_of(rect));
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

    /// Returns where the optical axis meets the plate, in plate pixels. The lens's frame is centred on the format.
    pub(super) fn optical_axis(&self) -> (f64, f64) {
        let (info, settings) = (&self.lens.info, self.setup.settings());
        let aspect = settings.pixel_aspect;
        let (width, height) = (f64::from(self.format.width), f64::from(self.format.height));
        let scale = if settings.lens_scale.is_nan() {
            width * aspect / info.frame.0
        } else {
            settings.lens_scale
        };
        let (x, y) = (
            (info.axis.0 - info.frame.0 / 2.0) * scale / aspect,
            (info.axis.1 - info.frame.1 / 2.0) * scale,
        );
        (
            width / 2.0 + x + settings.axis_offset_x,
            height / 2.0 + y + settings.axis_offset_y,
        )
    }

    /// Converts plate pixels to canonical coordinates.
    pub(super) fn canonical(&self, point: (f64, f64)) -> OfxPointD {
        OfxPointD {
            x: (f64::from(self.pixels.x1) + point.0) / self.scale.x,
            y: (f64::from(self.pixels.y2) - point.1) / self.scale.y,
        }
    }
}

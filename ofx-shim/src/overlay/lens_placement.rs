//! The lens placed over the frame of an instance, and canonical coordinates of points of the plate.

use std::sync::Arc;

use seidel_core::{Lens, PlateGeometry, PlatePlacement, RelensSide, Settings};

use crate::geometry::{Field, PixelMap, PlateScale, Scale, is_empty};
use crate::host::{Call, Result};
use crate::knobs::{Knobs, lens as knob};
use crate::rendering::project_region;
use crate::settings::{HostQuality, chosen_lens, plate_distance_m, plate_geometry, settings};
use crate::sys::effect::CLIP_SOURCE;
use crate::sys::{OfxPointD, OfxRectI};

/// A lens over the frame of an instance, at full resolution.
#[derive(Clone)]
pub(super) struct LensPlacement {
    pub(super) lens: Arc<Lens>,
    pub(super) settings: Settings,
    pub(super) geometry: PlateGeometry,
    /// Distance of the points whose PSFs are drawn, metres.
    pub(super) distance_m: f64,
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
        let project = project_region(call).filter(|_| by_project);
        let pixels = project.or(source).map(|rect| scale.pixels_of(rect));
        let Some(pixels) = pixels.filter(|pixels| !is_empty(*pixels)) else {
            return Ok(None);
        };
        let lens = chosen_lens(knobs, &knob::LENS, &knob::PROFILE)?;
        let plate_scale = PlateScale::new(scale, Field::Whole);
        let format = PixelMap::new(pixels, Field::Whole).rectangle(pixels);
        let settings = settings(
            knobs,
            &lens,
            plate_scale,
            HostQuality::Full,
            RelensSide::From,
        )?;
        Ok(Some(Self {
            geometry: plate_geometry(&settings, plate_scale, format, format),
            settings,
            distance_m: plate_distance_m(knobs),
            lens,
            scale,
            pixels,
        }))
    }

    /// Returns whether the lens draws the same PSFs as that of `other`.
    pub(super) fn has_same_lens(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.lens, &other.lens)
            && self.settings == other.settings
            && self.geometry == other.geometry
            && self.distance_m == other.distance_m
    }

    /// Returns where the optical axis meets the plate, in plate pixels.
    ///
    /// # Errors
    /// A film back for a lens of unknown pixel pitch.
    pub(super) fn optical_axis(&self) -> Result<(f64, f64)> {
        let placement = PlatePlacement::new(self.lens.frame(), &self.geometry)?;
        let axis = placement.axis(self.lens.profile().frame, self.settings.axis_offset_px);
        Ok((axis.x_px, axis.y_px))
    }

    /// Converts plate pixels to canonical coordinates.
    pub(super) fn canonical(&self, point: (f64, f64)) -> OfxPointD {
        OfxPointD {
            x: (f64::from(self.pixels.x1) + point.0) / self.scale.x,
            y: (f64::from(self.pixels.y2) - point.1) / self.scale.y,
        }
    }
}

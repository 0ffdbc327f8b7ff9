//! A look at the first depth pass of a run: what a wrong convention would do is seen by nobody.

use seidel_core::Result;
use seidel_core::field::{FieldPoint, ImagePoint};
use seidel_core::profile::{LensDescription, LensProfile};
use seidel_core::render::{DepthCheck, DepthConvention, LensReach, PlateMap, Severity, View};

use crate::files::plate::Plate;

/// How a plate is seen through a lens.
pub(crate) struct PlateView<'a> {
    lens: &'a LensProfile,
    /// Where the optical axis meets the plate, plate pixels from its outer corner.
    pub(crate) axis: ImagePoint,
    /// Plate pixels per pixel of the lens's frame, along y.
    scale: f64,
    /// Width of a pixel over its height.
    pub(crate) pixel_aspect: f64,
}

impl<'a> PlateView<'a> {
    /// A plate that lies in the frame of `lens` as `map` says, in pixels of this aspect, its axis moved by
    /// `offset` plate pixels.
    pub(crate) fn new(
        lens: &'a LensProfile,
        (map, pixel_aspect): (PlateMap, f64),
        offset: (f64, f64),
    ) -> Self {
        let axis = lens.frame.image_point(FieldPoint::new(0.0, 0.0));
        let on_plate = |axis: f64, origin: f64, offset: f64| (axis - origin) * map.scale + offset;
        Self {
            lens,
            axis: ImagePoint::new(
                on_plate(axis.x_px / pixel_aspect, map.origin.x_px, offset.0),
                on_plate(axis.y_px, map.origin.y_px, offset.1),
            ),
            scale: map.scale,
            pixel_aspect,
        }
    }

    /// What speaks against `samples`, the depth of `plate`, being what `convention` says; `vergence` is
    /// what came of it.
    ///
    /// # Errors
    /// Those of [`DepthCheck::findings`].
    pub(crate) fn doubts(
        &self,
        plate: &Plate,
        samples: &[f32],
        vergence: &[f32],
        convention: DepthConvention,
    ) -> Result<Vec<String>> {
        let alpha = plate.alpha();
        let check = DepthCheck {
            samples,
            vergence,
            width: plate.width(),
            height: plate.height(),
            convention,
            alpha: alpha.as_deref(),
            view: View {
                axis: self.axis,
                focal_px: self.focal_px(),
                pixel_aspect: self.pixel_aspect,
            },
            lens: LensReach {
                measured_m: self.measured_m(),
                focal_length_m: self.lens.camera.focal_length_mm.map(|f| 1e-3 * f),
            },
        };
        let findings = check.findings()?;
        let told = findings.iter().map(|finding| match finding.severity {
            Severity::Warning => {
                format!("is doubtful: {finding} (--no-depth-check: do not look)")
            }
            Severity::Note => format!("may be meant so: {finding}"),
        });
        Ok(told.collect())
    }

    /// Focal length in widths of plate pixels, where the lens knows its camera.
    fn focal_px(&self) -> Option<f64> {
        let focal_mm = self.lens.camera.focal_length_mm?;
        let pitch_um = self.lens.pixel_pitch_um?;
        Some(focal_mm * 1000.0 / pitch_um * self.scale / self.pixel_aspect)
    }

    /// Nearest and farthest distance at which the lens was measured.
    fn measured_m(&self) -> Option<(f64, f64)> {
        let vergences: Vec<f64> = match &self.lens.description {
            LensDescription::Moments(channels) => (channels.iter())
                .flat_map(|channel| &channel.planes)
                .filter_map(|plane| plane.distance.vergence_per_m())
                .collect(),
            LensDescription::Pupil(channels) => (channels.iter())
                .flat_map(|channel| [channel.measured_vergence.0, channel.measured_vergence.1])
                .collect(),
        };
        let near = vergences.iter().copied().fold(0.0, f64::max);
        let far = vergences.iter().copied().fold(f64::INFINITY, f64::min);
        (near > 0.0).then(|| (1.0 / near, 1.0 / far.max(0.0)))
    }
}

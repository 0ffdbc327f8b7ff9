//! A look at the first depth pass of a run: what a wrong convention would do is seen by nobody.

use seidel_core::Result;
use seidel_core::field::ImagePoint;
use seidel_core::plate::Placed;
use seidel_core::profile::LensProfile;
use seidel_core::render::{
    CameraPerspective, DepthCheck, DepthConvention, LensDistances, Severity,
};

use seidel_image_io::plate::Plate;

/// How a plate is seen through a lens.
pub(crate) struct PlateView<'a> {
    lens: &'a LensProfile,
    /// Where the optical axis meets the plate, plate pixels from its outer corner.
    axis: ImagePoint,
    /// Plate pixels per pixel of the lens's frame, along y.
    scale: f64,
    /// Width of a pixel over its height.
    pixel_aspect: f64,
}

impl<'a> PlateView<'a> {
    /// A plate that lies in the frame of `lens` as `placed` says, its axis moved by `offset` plate pixels.
    pub(crate) fn new(lens: &'a LensProfile, placed: &Placed, offset: (f64, f64)) -> Self {
        Self {
            lens,
            axis: placed.axis(lens.frame, offset),
            scale: placed.map.scale,
            pixel_aspect: placed.pixel_aspect,
        }
    }

    /// Where the axis meets the plate, and the width of a pixel over its height.
    pub(crate) fn axis_and_aspect(&self) -> (ImagePoint, f64) {
        (self.axis, self.pixel_aspect)
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
            view: CameraPerspective {
                axis: self.axis,
                focal_px: self.focal_px(),
                pixel_aspect: self.pixel_aspect,
            },
            lens: LensDistances {
                measured_m: self.lens.measured_range_m(),
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
}

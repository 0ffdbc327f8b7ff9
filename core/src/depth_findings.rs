//! The check of a prepared depth pass, for its plate and lens.

use seidel_optics::error::Result;
use seidel_optics::profile::LensProfile;
use seidel_render::{CameraPerspective, DepthCheck, DepthFinding, DepthProblem, LensDistances};

use crate::placement::PlatePlacement;
use crate::plate::PlateGeometry;
use crate::prepared::PreparedPlate;
use crate::prepared_depth::PreparedDepth;
use crate::session::LensSession;

impl LensSession {
    /// Returns signs that the depth pass of a plate of `geometry`, with `alpha` where it has one, does not follow its
    /// convention, and where its `colours` are known, that it is not of this plate; none if the plate is at one distance.
    ///
    /// # Errors
    /// Those of [`LensSession::place`] and [`DepthCheck::findings`].
    pub fn depth_findings(
        &self,
        depth: &PreparedDepth,
        geometry: &PlateGeometry,
        colours: &[Vec<f32>],
        alpha: Option<&[f32]>,
    ) -> Result<Vec<DepthFinding>> {
        let (Some(reading), Some(pass)) = (depth.reading(), depth.pass()) else {
            return Ok(Vec::new());
        };
        let placement = self.place(geometry)?;
        let lens = self.lens().profile();
        let check = DepthCheck {
            samples: &pass.samples,
            vergence: &reading.vergence,
            width: placement.width,
            height: placement.height,
            convention: pass.meaning.convention,
            colours,
            alpha,
            view: CameraPerspective {
                axis: self.axis(&placement),
                focal_px: focal_px(lens, &placement),
                pixel_aspect: placement.pixel_aspect,
            },
            lens: LensDistances {
                measured_m: lens.measured_range_m(),
                focal_length_m: lens.camera.focal_length_mm.map(|f| 1e-3 * f),
            },
        };
        let mut findings = check.findings()?;
        if pass.meaning.averaged_px > 0.0 {
            findings.retain(|found| !matches!(found.problem, DepthProblem::Averaged { .. }));
        }
        Ok(findings)
    }
}

impl PreparedPlate {
    /// Returns signs that the plate's depth pass does not follow its convention, or is of another picture.
    ///
    /// # Errors
    /// Those of [`LensSession::depth_findings`].
    pub fn depth_findings(&self) -> Result<Vec<DepthFinding>> {
        let colours = &self.planes()[..self.colour_count()];
        (self.session()).depth_findings(self.depth(), self.geometry(), colours, self.alpha())
    }
}

/// Returns the focal length in widths of plate pixels, if the profile states its camera.
fn focal_px(lens: &LensProfile, placement: &PlatePlacement) -> Option<f64> {
    let focal_mm = lens.camera.focal_length_mm?;
    let pitch_um = lens.pixel_pitch_um?;
    Some(focal_mm * 1000.0 / pitch_um * placement.map.scale / placement.pixel_aspect)
}

//! A check of the first depth pass of a run: signs that its samples have another meaning than the options state.

use seidel_core::Result;
use seidel_core::render::{CameraPerspective, DepthCheck, LensDistances, Severity};
use seidel_core::{LensProfile, LensSession, PlateGeometry, PlatePlacement, PreparedDepth};

use seidel_image_io::plate::Plate;

/// Returns signs that the depth pass of `plate` does not follow its convention; none if `depth` is constant.
///
/// # Errors
/// Those of [`LensSession::place`] and [`DepthCheck::findings`].
pub(super) fn check_depth(
    depth: &PreparedDepth,
    plate: &Plate,
    geometry: &PlateGeometry,
    session: &LensSession,
) -> Result<Vec<String>> {
    let (Some(reading), Some(pass)) = (depth.reading(), depth.pass()) else {
        return Ok(Vec::new());
    };
    let placement = session.place(geometry)?;
    let alpha = plate.alpha();
    let lens = session.lens().profile();
    let check = DepthCheck {
        samples: &pass.samples,
        vergence: &reading.vergence,
        width: plate.width(),
        height: plate.height(),
        convention: pass.meaning.convention,
        alpha: alpha.as_deref(),
        view: CameraPerspective {
            axis: session.axis(&placement),
            focal_px: focal_px(lens, &placement),
            pixel_aspect: placement.pixel_aspect,
        },
        lens: LensDistances {
            measured_m: lens.measured_range_m(),
            focal_length_m: lens.camera.focal_length_mm.map(|f| 1e-3 * f),
        },
    };
    let findings = check.findings()?;
    let messages = findings.iter().map(|finding| match finding.severity {
        Severity::Warning => {
            format!("is doubtful: {finding} (--no-depth-check skips this check)")
        }
        Severity::Note => format!("may be intended: {finding}"),
    });
    Ok(messages.collect())
}

/// Returns the focal length in widths of plate pixels, if the profile states its camera.
fn focal_px(lens: &LensProfile, placement: &PlatePlacement) -> Option<f64> {
    let focal_mm = lens.camera.focal_length_mm?;
    let pitch_um = lens.pixel_pitch_um?;
    Some(focal_mm * 1000.0 / pitch_um * placement.map.scale / placement.pixel_aspect)
}

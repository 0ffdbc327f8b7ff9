//! A check of the first depth pass of a run: signs that its samples mean something else than the options say.

use seidel_core::Result;
use seidel_core::render::{
    CameraPerspective, DepthCheck, DepthConvention, LensDistances, Severity,
};
use seidel_core::{LensProfile, LensSession, PlatePlacement};

use seidel_image_io::plate::Plate;

/// Returns what speaks against `samples`, the depth pass of `plate`, meaning what `convention` says; `vergence` was read
/// from them.
///
/// # Errors
/// Those of [`DepthCheck::findings`].
pub(super) fn depth_doubts(
    session: &LensSession,
    placement: &PlatePlacement,
    plate: &Plate,
    samples: &[f32],
    vergence: &[f32],
    convention: DepthConvention,
) -> Result<Vec<String>> {
    let alpha = plate.alpha();
    let lens = session.lens().profile();
    let check = DepthCheck {
        samples,
        vergence,
        width: plate.width(),
        height: plate.height(),
        convention,
        alpha: alpha.as_deref(),
        view: CameraPerspective {
            axis: session.axis(placement),
            focal_px: focal_px(lens, placement),
            pixel_aspect: placement.pixel_aspect,
        },
        lens: LensDistances {
            measured_m: lens.measured_range_m(),
            focal_length_m: lens.camera.focal_length_mm.map(|f| 1e-3 * f),
        },
    };
    let findings = check.findings()?;
    let doubts = findings.iter().map(|finding| match finding.severity {
        Severity::Warning => {
            format!("is doubtful: {finding} (--no-depth-check: do not look)")
        }
        Severity::Note => format!("may be meant so: {finding}"),
    });
    Ok(doubts.collect())
}

/// Focal length in widths of plate pixels, where the profile knows its camera.
fn focal_px(lens: &LensProfile, placement: &PlatePlacement) -> Option<f64> {
    let focal_mm = lens.camera.focal_length_mm?;
    let pitch_um = lens.pixel_pitch_um?;
    Some(focal_mm * 1000.0 / pitch_um * placement.map.scale / placement.pixel_aspect)
}

//! A check of the first depth pass of a run: signs that its samples have another meaning than the options state.

use seidel_core::{LensSession, PlateGeometry, PreparedDepth, Result, Severity};

use seidel_image_io::plate::PlateFile;

/// Returns signs that the depth pass of `plate` does not follow its convention; none if `depth` is constant.
///
/// # Errors
/// Those of [`LensSession::depth_findings`].
pub(super) fn check_depth(
    depth: &PreparedDepth,
    plate: &PlateFile,
    geometry: &PlateGeometry,
    session: &LensSession,
) -> Result<Vec<String>> {
    let alpha = plate.alpha();
    let findings = session.depth_findings(depth, geometry, alpha.as_deref())?;
    let messages = findings.iter().map(|finding| match finding.severity {
        Severity::Warning => {
            format!("is doubtful: {finding} (--no-depth-check skips this check)")
        }
        Severity::Note => format!("may be intended: {finding}"),
    });
    Ok(messages.collect())
}

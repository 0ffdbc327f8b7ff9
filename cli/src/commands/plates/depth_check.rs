//! A check of the first depth pass of a run: signs that its samples have another meaning than the options state.

use seidel_core::{PreparedPlate, Result, Severity};

/// Returns signs that the depth pass of `plate` does not follow its convention, or is of another picture; none if depth is constant.
///
/// # Errors
/// Those of [`PreparedPlate::depth_findings`].
pub(super) fn check_depth(plate: &PreparedPlate) -> Result<Vec<String>> {
    let findings = plate.depth_findings()?;
    let messages = findings.iter().map(|finding| {
        let skip = match finding.severity {
            Severity::Warning => " (--no-depth-check skips this check)",
            Severity::Note => "",
        };
        format!("{}: {finding}{skip}", finding.severity)
    });
    Ok(messages.collect())
}

//! A guess of Depth Math from a depth input that was just connected.

use seidel_core::{DepthProblem, LensSession, PreparedDepth, Severity};

use crate::depth_warning;
use crate::host::{Call, ParameterValue, Result, show_information};
use crate::knobs::{Knobs, depth, lens};
use crate::rendering::{Frame, Inputs, Source};
use crate::settings::{HostQuality, chosen_lens, plate_geometry, settings};

/// Sets Depth Math to `far=0` if it is at its default, `depth`, and the pass holds 1 / distance; tells the user this and other
/// doubts about the pass. Called on the main thread only, since it changes parameters.
pub(super) fn guess(call: &Call) {
    // What is wrong with source, lens or pass is the message of the next render.
    if let Ok(Some(text)) = result(call) {
        show_information(call.host, call.effect.handle, &text);
    }
}

/// Returns the message for the user, if there is one.
fn result(call: &Call) -> Result<Option<String>> {
    let knobs = Knobs::at(&call.effect, call.time());
    if knobs.choice(&depth::MATH) != depth::MATH_DEPTH {
        return Ok(None);
    }
    let Some(source) = Source::fetch(call)? else {
        return Ok(None);
    };
    let profile = chosen_lens(&knobs, &lens::LENS, &lens::PROFILE)?;
    let bounds = source.image.bounds;
    let frame = Frame::new(call, &knobs, &source, bounds, bounds);
    let inputs = Inputs::fetch(call, &knobs, &profile, frame.map)?;
    let settings = settings(&knobs, &profile, frame.scale, HostQuality::Full)?;
    let session = LensSession::new(&profile, &settings)?;
    let geometry = plate_geometry(&settings, frame.scale, frame.format, frame.extent);
    let pass = inputs.depth(&knobs, &profile, frame.scale, &geometry)?;
    let prepared = PreparedDepth::new(&session, &geometry, pass)?;
    let Some(pass) = prepared.pass() else {
        return Ok(None);
    };
    let findings = session.depth_findings(&prepared, &geometry, &[], None)?;
    let inverted = findings.iter().find(|finding| {
        finding.severity == Severity::Warning
            && matches!(finding.problem, DepthProblem::Inverted { .. })
    });
    if let Some(finding) = inverted {
        let change = (depth::MATH.name, ParameterValue::Int(depth::MATH_FAR_ZERO));
        call.effect.parameters().set(c"Guess Depth Math", &[change]);
        return Ok(Some(format!(
            "Depth: {}; Depth Math is far=0 now. Undo this if it holds distances.",
            finding.problem
        )));
    }
    let convention = pass.meaning.convention;
    let doubts = depth_warning::warnings(&findings, convention, geometry.data.width);
    Ok((!doubts.is_empty()).then(|| doubts.join(" ")))
}

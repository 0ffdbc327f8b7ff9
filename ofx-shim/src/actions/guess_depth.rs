//! A guess of Depth Math from a depth input that was just connected.

use seidel_core::{DepthProblem, LensSession, PreparedDepth, RelensSide, Severity};

use super::instance_set::InstanceSet;
use crate::clips::DEPTH;
use crate::host::{Call, Clip, ParameterValue, Result, show_information};
use crate::knobs::{Knobs, depth, lens};
use crate::remarks::{Remark, remarks};
use crate::rendering::{Frame, Inputs, Source};
use crate::settings::{HostQuality, chosen_lens, plate_geometry, settings};
use crate::sys::Handle;
use crate::sys::property::NAME;

/// Instances whose depth input was connected, but whose images could not be read yet.
static DUE: InstanceSet = InstanceSet::new();

/// The outcome of a look at the depth input.
enum Guess {
    /// The images of the inputs are not there yet.
    NotYet,
    /// The pass was read; the message for the user, if there is one.
    Made(Option<String>),
}

/// Sets Depth Math to `far=0` if it is at its default, `depth`, and the pass holds 1 / distance; tells the user this and other
/// doubts about the pass. Called on the main thread only, since it changes parameters.
pub(super) fn guess(call: &Call) {
    let instance = call.effect.handle;
    match result(call) {
        Ok(Guess::Made(text)) => {
            DUE.remove(instance);
            if let Some(text) = text {
                show_information(call.host, instance, &text);
            }
        }
        // In Natron a clip has no components while it is being connected. What is wrong with source, lens or pass is the message
        // of the next render.
        Ok(Guess::NotYet) | Err(_) => DUE.insert(instance),
    }
}

/// Guesses as [`guess`] if that was not possible when the depth input was connected. A choice of Depth Math ends that.
pub(super) fn guess_if_due(call: &Call) {
    let instance = call.effect.handle;
    if DUE.remove(instance) && !call.arguments.equals(NAME, depth::MATH.name) {
        guess(call);
    }
}

/// Forgets an instance that is destroyed.
pub(super) fn forget(instance: Handle) {
    DUE.remove(instance);
}

fn result(call: &Call) -> Result<Guess> {
    let knobs = Knobs::at(&call.effect, call.time());
    if knobs.choice(&depth::MATH) != depth::MATH_DEPTH || !knobs.is_on(&depth::USE_DEPTH) {
        return Ok(Guess::Made(None));
    }
    let connected = call.effect.clip(DEPTH).filter(Clip::is_connected);
    if connected.is_none() {
        return Ok(Guess::Made(None));
    }
    let Some(source) = Source::fetch(call)? else {
        return Ok(Guess::NotYet);
    };
    let profile = chosen_lens(&knobs, &lens::LENS, &lens::PROFILE)?;
    let bounds = source.image.bounds;
    let frame = Frame::new(call, &knobs, &source, bounds, bounds);
    let inputs = Inputs::fetch(call, &knobs, &profile, frame.map)?;
    let settings = settings(
        &knobs,
        &profile,
        frame.scale,
        HostQuality::Full,
        RelensSide::From,
    )?;
    let session = LensSession::new(&profile, &settings)?;
    let geometry = plate_geometry(&settings, frame.scale, frame.format, frame.extent);
    let pass = inputs.depth(&knobs, &profile, frame.scale, &geometry)?;
    let prepared = PreparedDepth::new(&session, &geometry, pass)?;
    let Some(pass) = prepared.pass() else {
        return Ok(Guess::NotYet);
    };
    let findings = session.depth_findings(&prepared, &geometry, &[], None)?;
    let inverted = findings.iter().find(|finding| {
        finding.severity == Severity::Warning
            && matches!(finding.problem, DepthProblem::Inverted { .. })
    });
    if let Some(finding) = inverted {
        let change = (depth::MATH.name, ParameterValue::Int(depth::MATH_FAR_ZERO));
        call.effect.parameters().set(c"Guess Depth Math", &[change]);
        return Ok(Guess::Made(Some(format!(
            "Depth: {}; Depth Math is far=0 now. Undo this if it holds distances.",
            finding.problem
        ))));
    }
    let convention = pass.meaning.convention;
    let remarks = remarks(&findings, convention, geometry.data.width);
    let text = (!remarks.is_empty()).then(|| Remark::join(&remarks));
    Ok(Guess::Made(text))
}

//! Suite functions that are NULL.

use openfx::sys::generic::core::kOfxChangeUserEdited;
use openfx::sys::image_effect_v1::param::kOfxTypeParameter;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::host::suites::all_functions;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "null_functions",
    about: "no NULL suite function crashes the plugin, and without an optional one it renders the same picture",
    run,
};

/// Suites whose functions are required, except those in [`OPTIONAL`].
const REQUIRED_SUITES: [&str; 3] = ["property.", "image_effect.", "parameter."];

/// Functions of required suites that plugins can do without.
const OPTIONAL: [&str; 19] = [
    "property.propReset",
    "image_effect.abort",
    "image_effect.imageMemoryAlloc",
    "image_effect.imageMemoryFree",
    "image_effect.imageMemoryLock",
    "image_effect.imageMemoryUnlock",
    "parameter.paramGetDerivative",
    "parameter.paramGetIntegral",
    "parameter.paramGetValue",
    "parameter.paramSetValue",
    "parameter.paramSetValueAtTime",
    "parameter.paramGetNumKeys",
    "parameter.paramGetKeyTime",
    "parameter.paramGetKeyIndex",
    "parameter.paramDeleteKey",
    "parameter.paramDeleteAllKeys",
    "parameter.paramCopy",
    "parameter.paramEditBegin",
    "parameter.paramEditEnd",
];

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    for function in all_functions() {
        let is_required = REQUIRED_SUITES
            .iter()
            .any(|suite| function.starts_with(suite))
            && !OPTIONAL.contains(&function.as_str());
        let profile = Profile {
            null_functions: vec![function.clone()],
            ..Profile::complete()
        };
        let mut found = Report::default();
        let result = fixture::with_plugin(subject, &mut found, profile, |loaded, report| {
            let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
            for parameter in instance.effect.parameters.all() {
                instance.notify_changed(
                    kOfxTypeParameter,
                    &parameter.name,
                    kOfxChangeUserEdited,
                )?;
            }
            let frame = instance.render_checked(&RenderRequest::default())?;
            instance.destroy()?;
            report.expect_same(&expected, &frame, "the picture");
            Ok(())
        });
        // Without a required function the plugin may do anything but crash.
        if !is_required {
            for fault in found.faults.into_iter().chain(result.err()) {
                report.fault(format!("{function} is NULL: {fault}"));
            }
        }
    }
    Ok(())
}

//! Members of suites that are NULL.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::host::suites::all_members;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "members",
    about: "no NULL member of any suite crashes the plugin, and without those it can do without the picture is the same",
    run,
};

/// Members of the suites needed that a plugin can do without.
const SPARE: [&str; 19] = [
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
    let expected = stage::usual(subject, report)?;
    for member in all_members() {
        let needed = ["property.", "image_effect.", "parameter."];
        let spare = !needed.iter().any(|suite| member.starts_with(suite))
            || SPARE.contains(&member.as_str());
        let profile = Profile {
            null_members: vec![member.clone()],
            ..Profile::complete()
        };
        // What is noticed where something needed is missing is noted apart, and left.
        let mut apart = Report::default();
        let mut noted = Report::default();
        let into = if spare { &mut noted } else { &mut apart };
        let done = stage::on(subject, into, profile, |loaded, report| {
            let instance = stage::blurring(loaded, subject, &stage::scene())?;
            for parameter in instance.effect.parameters.all() {
                instance.changed(
                    openfx::sys::image_effect_v1::param::kOfxTypeParameter,
                    &parameter.name,
                    openfx::sys::generic::core::kOfxChangeUserEdited,
                )?;
            }
            let frame = instance.render(&Request::default())?.good()?;
            instance.destroy()?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                "picture",
            );
            Ok(())
        });
        if spare {
            for fault in noted.faults.into_iter().chain(done.err()) {
                report.fault(format!("{member} is NULL: {fault}"));
            }
        }
    }
    Ok(())
}

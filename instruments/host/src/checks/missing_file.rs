//! A parameter that names a missing file.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::message::*;

use super::{Check, Report, fixture};
use crate::drive::{RenderRequest, status_name};
use crate::host::effect::ParameterValue;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "missing_file",
    about: "with a missing file the render fails with a message that names it; without it the next render succeeds",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let Some(file) = &subject.kind.file else {
        report.skip("the plugin reads no file");
        return Ok(());
    };
    let expected = fixture::reference(subject, report)?;
    let complete = Profile::complete;
    let hosts = [
        complete(),
        Profile {
            missing_suites: vec![(kOfxMessageSuite, 2)],
            ..complete()
        },
        Profile {
            null_functions: vec!["message2.setPersistentMessage".to_owned()],
            ..complete()
        },
    ];
    for profile in hosts {
        let has_persistent_messages =
            profile.missing_suites.is_empty() && profile.null_functions.is_empty();
        fixture::with_plugin(subject, report, profile, |loaded, report| {
            let host = loaded.host;
            let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
            fixture::apply(&instance, file.in_use)?;
            let name = "/nowhere/not there.lens";
            instance.edit(file.name, &ParameterValue::Text(name.to_owned()))?;
            host.take_messages();
            let frame = instance.render(&RenderRequest::default())?;
            report.expect(frame.status == kOfxStatFailed, || {
                format!(
                    "with a missing file, Render returned {}",
                    status_name(frame.status)
                )
            });
            let messages = host.take_messages();
            let is_named = messages.iter().any(|m| {
                m.text.contains("not there.lens")
                    && m.kind.as_bytes() == kOfxMessageError.to_bytes()
            });
            report.expect(is_named, || {
                format!("no error message names the missing file; the messages are {messages:?}")
            });
            if has_persistent_messages {
                report.expect(host.persistent_message().is_some(), || {
                    "the message about the missing file is not persistent".to_owned()
                });
            }
            for (name, value) in file.not_in_use {
                instance.edit(name, &value.value())?;
            }
            let frame = instance.render_checked(&RenderRequest::default())?;
            report.expect_same(&expected, &frame, "once the file is not needed");
            report.expect(host.persistent_message().is_none(), || {
                "the persistent message is not cleared by a successful render".to_owned()
            });
            instance.destroy()
        })?;
    }
    Ok(())
}

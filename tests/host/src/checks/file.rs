//! A file that is not there.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::message::*;

use super::{Check, Report, stage};
use crate::drive::{Request, status_name};
use crate::host::effect::Setting;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "file",
    about: "a missing file fails the render with a message that names it, and the next render without it is right",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let Some(file) = &subject.kind.file else {
        report.skip("the plugin reads no file");
        return Ok(());
    };
    let expected = stage::usual(subject, report)?;
    let complete = Profile::complete;
    let hosts = [
        complete(),
        Profile {
            absent: vec![(kOfxMessageSuite, 2)],
            ..complete()
        },
        Profile {
            null_members: vec!["message2.setPersistentMessage".to_owned()],
            ..complete()
        },
    ];
    for profile in hosts {
        let persistent = profile.absent.is_empty() && profile.null_members.is_empty();
        stage::on(subject, report, profile, |loaded, report| {
            let instance = stage::blurring(loaded, subject, &stage::scene())?;
            stage::set(&instance, file.in_use)?;
            let name = "/nowhere/not there.lens";
            instance.change(file.name, &Setting::Text(name.to_owned()))?;
            loaded.host.take_messages();
            let frame = instance.render(&Request::default())?;
            report.expect(frame.status == kOfxStatFailed, || {
                format!(
                    "with a file that is not there Render gave {}",
                    status_name(frame.status)
                )
            });
            let messages = loaded.host.take_messages();
            let named = messages.iter().any(|m| {
                m.text.contains("not there.lens")
                    && m.kind.as_bytes() == kOfxMessageError.to_bytes()
            });
            report.expect(named, || {
                format!("no message of an error names the file; there are {messages:?}")
            });
            if persistent {
                report.expect(loaded.host.persistent_message().is_some(), || {
                    "the message does not stay".to_owned()
                });
            }
            for (name, knob) in file.without {
                instance.change(name, &knob.setting())?;
            }
            let frame = instance.render(&Request::default())?.good()?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                "once the file is not needed",
            );
            report.expect(loaded.host.persistent_message().is_none(), || {
                "the message stays when all is well again".to_owned()
            });
            instance.destroy()
        })?;
    }
    Ok(())
}

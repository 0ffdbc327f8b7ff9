//! Messages with unusual file names.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::effect::ParameterValue;
use crate::host::profile::Profile;
use crate::host::profiles;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "messages",
    about: "messages keep long file names and names with %, also in hosts that print no arguments of formats",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let Some(file) = &subject.kind.file else {
        report.skip("the plugin reads no file");
        return Ok(());
    };
    let names = [
        "/nowhere/100%/%s%n%d%p.lens".to_owned(),
        format!("/nowhere/{}.lens", "long-".repeat(900)),
        "/nowhere/\u{e9}\u{4e00}\u{1f4f7} two words.lens".to_owned(),
        "\n\t%%%s".to_owned(),
    ];
    for (name, profile) in (names.iter()).flat_map(|name| {
        let hosts = [Profile::complete(), profiles::natron()];
        hosts.map(|profile| (name.clone(), profile))
    }) {
        let short: String = name.chars().take(30).collect();
        let in_host = format!("{short:?} in {}", profile.name);
        fixture::with_plugin(subject, report, profile, |loaded, report| {
            let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
            fixture::apply(&instance, file.in_use)?;
            instance.set(file.name, &ParameterValue::Text(name))?;
            let frame = instance.render(&RenderRequest::default())?;
            report.expect(frame.status != 0, || {
                format!("the render succeeds with the missing file {in_host}")
            });
            let messages = loaded.host.take_messages();
            report.expect(messages.iter().any(|m| m.text.len() > 8), || {
                format!("no message for the missing file {in_host}")
            });
            let has_conversions = short.contains("%s%n");
            let is_whole = (messages.iter()).any(|m| m.text.contains("100%/%s%n%d%p.lens"));
            report.expect(is_whole || !has_conversions, || {
                format!("no message has the name of the missing file {in_host}")
            });
            for message in messages {
                report.expect(!message.text.contains('\u{fffd}'), || {
                    format!("a message about the file {in_host} is not valid UTF-8")
                });
            }
            instance.destroy()
        })?;
    }
    Ok(())
}

//! Messages, with names in them that are not to be taken for formats.

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::effect::Setting;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "messages",
    about: "names with % and very long ones go through messages whole, by the format %s",
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
    for name in names {
        stage::on(subject, report, Profile::complete(), |loaded, report| {
            let instance = stage::blurring(loaded, subject, &stage::scene())?;
            stage::set(&instance, file.in_use)?;
            instance.set(file.name, &Setting::Text(name.clone()))?;
            let frame = instance.render(&Request::default())?;
            let short: String = name.chars().take(30).collect();
            report.expect(frame.status != 0, || {
                format!("renders with the file {short:?}, which is not there")
            });
            let messages = loaded.host.take_messages();
            report.expect(messages.iter().any(|m| m.text.len() > 8), || {
                format!("says nothing of the file {short:?}")
            });
            for message in messages {
                report.expect(message.format == "%s", || {
                    format!("gives the format {:?} with a message", message.format)
                });
                report.expect(!message.text.contains('\u{fffd}'), || {
                    format!("says what is no text of the file {short:?}")
                });
            }
            instance.destroy()
        })?;
    }
    Ok(())
}

//! Every kind of host.

use super::{Check, Report, stage};
use crate::drive::{Loaded, Request};
use crate::host::profiles;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "kinds",
    about: "hosts of every kind get the same picture",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = stage::usual(subject, report)?;
    for profile in profiles::all() {
        let name = profile.name;
        let mut noted = Report::default();
        let done = stage::within(subject, &mut noted, profile, |host, library, report| {
            let plugin = library.find(subject.id.as_deref())?;
            let mut loaded = Loaded::new(host, &plugin)?;
            if host.profile.reloads {
                for context in &host.profile.contexts {
                    loaded.describe_in(context)?.end(host);
                }
                loaded.unload()?;
                loaded = Loaded::again(host, &plugin)?;
            }
            for general in [false, true] {
                let scene = stage::scene();
                let context = loaded.context(general)?;
                let instance = crate::drive::Instance::new(&loaded, &context, &scene)?;
                stage::set(&instance, subject.kind.blur)?;
                // Without the actions that ask for it, Output is as large as Source.
                let frame = instance.render(&Request::default())?.good()?;
                instance.destroy()?;
                report.none(
                    expected.picture.difference(&frame.picture, frame.window),
                    &context.to_string_lossy(),
                );
            }
            loaded.unload()
        });
        for fault in noted.faults.into_iter().chain(done.err()) {
            report.fault(format!("{name}: {fault}"));
        }
    }
    Ok(())
}

//! All kinds of hosts.

use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::{Instance, LoadedPlugin, Plugin, RenderRequest};
use crate::host::{ActiveHost, profiles};
use crate::picture::Picture;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "host_kinds",
    about: "hosts of every kind get the same picture",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    for profile in profiles::all() {
        let name = profile.name;
        let mut found = Report::default();
        let result = fixture::with_host(subject, &mut found, profile, |host, plugin, report| {
            check_host(subject, host, plugin, &expected, report)
        });
        for fault in found.faults.into_iter().chain(result.err()) {
            report.fault(format!("{name}: {fault}"));
        }
    }
    Ok(())
}

fn check_host(
    subject: &Subject,
    host: &ActiveHost,
    plugin: &Plugin,
    expected: &Picture,
    report: &mut Report,
) -> Result<(), String> {
    let mut loaded = LoadedPlugin::load(host, plugin)?;
    if host.profile.reloads {
        for context in &host.profile.contexts {
            loaded.describe_in(context)?.invalidate(host);
        }
        loaded.unload()?;
        loaded = LoadedPlugin::load_again(host, plugin)?;
    }
    for preferred in [kOfxImageEffectContextFilter, kOfxImageEffectContextGeneral] {
        let context = loaded.context_like(preferred)?;
        let instance = Instance::new(&loaded, &context, &fixture::scene())?;
        for clip in instance.effect.clips() {
            instance.notify_connected(&clip.name)?;
        }
        fixture::apply(&instance, subject.kind.blur)?;
        let frame = instance.render_checked(&RenderRequest::default())?;
        instance.destroy()?;
        report.expect_same(expected, &frame, &context.to_string_lossy());
    }
    loaded.unload()
}

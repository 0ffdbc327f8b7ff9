//! Parameter changes, with and without notification.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, fixture};
use crate::drive::{Instance, RenderRequest};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "parameter_changes",
    about: "a render uses the current parameters, whether or not the plugin was notified of changes",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::scene();
        let context = loaded.context(&scene)?;
        let instance = Instance::new(loaded, &context, &scene)?;
        let request = RenderRequest::default();
        // Renders with other parameters first, which the plugin might cache.
        for settings in subject.kind.identities {
            for (name, value) in *settings {
                let before = instance.effect.parameters.get(name).map(|p| p.value());
                instance.edit(name, &value.value())?;
                instance.render_checked(&request)?;
                if let Some(before) = before {
                    instance.set(name, &before)?;
                }
            }
        }
        fixture::apply(&instance, subject.kind.blur)?;
        let frame = instance.render_checked(&request)?;
        report.expect_same(&expected, &frame, "set without notification");
        for (name, value) in subject.kind.blur {
            instance.edit(name, &value.value())?;
        }
        let frame = instance.render_checked(&request)?;
        report.expect_same(&expected, &frame, "set with notification");
        for parameter in instance.effect.parameters.all() {
            let name = &parameter.name;
            for reason in [kOfxChangePluginEdited, kOfxChangeTime] {
                report.expect_ok(
                    instance.notify_changed(kOfxTypeParameter, name, reason),
                    name,
                );
            }
        }
        for clip in instance.effect.clips() {
            let result = instance.notify_changed(kOfxTypeClip, &clip.name, kOfxChangeUserEdited);
            report.expect_ok(result, &clip.name);
        }
        let unknown =
            instance.notify_changed(kOfxTypeParameter, "noSuchParameter", kOfxChangeUserEdited);
        report.expect_ok(unknown, "a change of an unknown parameter");
        let frame = instance.render_checked(&request)?;
        report.expect_same(&expected, &frame, "after notifications of all changes");
        instance.destroy()
    })
}

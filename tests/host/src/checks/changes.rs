//! Parameters changed, with the plugin told and without.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, stage};
use crate::drive::{Instance, Request};
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "changes",
    about: "the picture is that of the parameters, whether the plugin was told of their change or not",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = stage::usual(subject, report)?;
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::scene();
        let context = loaded.context(false)?;
        let instance = Instance::new(loaded, &context, &scene)?;
        // Something else first, so that it may keep it.
        for knobs in subject.kind.identities {
            for (name, knob) in *knobs {
                let before = instance.effect.parameters.get(name).map(|p| p.value());
                instance.change(name, &knob.setting())?;
                instance.render(&Request::default())?.good()?;
                if let Some(before) = before {
                    instance.set(name, &before)?;
                }
            }
        }
        stage::set(&instance, subject.kind.blur)?;
        let silent = instance.render(&Request::default())?.good()?;
        report.none(
            expected.picture.difference(&silent.picture, silent.window),
            "set without a word",
        );
        for (name, knob) in subject.kind.blur {
            instance.change(name, &knob.setting())?;
        }
        let told = instance.render(&Request::default())?.good()?;
        report.none(
            expected.picture.difference(&told.picture, told.window),
            "set and told",
        );
        for parameter in instance.effect.parameters.all() {
            for reason in [kOfxChangePluginEdited, kOfxChangeTime] {
                let done = instance.changed(kOfxTypeParameter, &parameter.name, reason);
                report.none(done.err(), &parameter.name);
            }
        }
        for clip in instance.effect.clips() {
            let done = instance.changed(kOfxTypeClip, &clip.name, kOfxChangeUserEdited);
            report.none(done.err(), &clip.name);
        }
        let unknown = instance.changed(kOfxTypeParameter, "noSuchParameter", kOfxChangeUserEdited);
        report.none(unknown.err(), "a parameter that is not there");
        let after = instance.render(&Request::default())?.good()?;
        report.none(
            expected.picture.difference(&after.picture, after.window),
            "after everything was said to have changed",
        );
        instance.destroy()
    })
}

//! Actions out of order and twice: nothing may crash, and all is well afterwards.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, stage};
use crate::drive::{Instance, Loaded, Request, act, new_descriptor};
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "order",
    about: "actions out of order or twice crash nothing, and what follows is right",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = stage::usual(subject, report)?;
    stage::within(
        subject,
        report,
        Profile::complete(),
        |host, library, report| {
            let plugin = library.find(subject.id.as_deref())?;
            let descriptor = new_descriptor(host);
            plugin.set_host(host);
            for action in [
                kOfxActionUnload,
                kOfxActionDescribe,
                kOfxActionDestroyInstance,
                kOfxActionPurgeCaches,
            ] {
                act(&plugin, action, descriptor.handle(), None, None, None);
            }
            // What it made of that is its own affair, as long as it lives.
            host.take_misuse();
            let loaded = Loaded::new(host, &plugin)?;
            let context = loaded.context(false)?;
            let described = loaded.describe_in(&context)?;
            let scene = stage::scene();
            let early = Instance::uncreated(&loaded, &described, &context, &scene);
            let window = Rect::new(0, 0, 8, 8);
            let request = Request {
                window: Some(window),
                ..Request::default()
            };
            let _ = early.preferences();
            let _ = early.identity(0.0, (1.0, 1.0), window);
            let _ = early.render(&request);
            let _ = early.changed(kOfxTypeClip, "Source", kOfxChangeUserEdited);
            for action in [
                kOfxActionDestroyInstance,
                kOfxActionSyncPrivateData,
                kOfxActionEndInstanceEdit,
                kOfxActionEndInstanceChanged,
                kOfxActionPurgeCaches,
            ] {
                early.act(action);
            }
            host.take_misuse();
            drop(early);

            let instance = stage::blurring(&loaded, subject, &scene)?;
            for action in [
                kOfxActionCreateInstance,
                kOfxActionEndInstanceChanged,
                kOfxActionEndInstanceEdit,
                kOfxActionBeginInstanceEdit,
                kOfxActionBeginInstanceEdit,
                kOfxImageEffectActionEndSequenceRender,
                kOfxActionSyncPrivateData,
                kOfxActionPurgeCaches,
            ] {
                instance.act(action);
            }
            host.take_misuse();
            let frame = instance.render(&Request::default())?.good()?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                "after actions out of order",
            );
            instance.act(kOfxActionDestroyInstance);
            instance.act(kOfxActionDestroyInstance);
            host.take_misuse();
            drop(instance);
            let frame = stage::rendered(&loaded, subject, &scene, &Request::default())?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                "after an instance was destroyed twice",
            );
            loaded.unload()
        },
    )
}

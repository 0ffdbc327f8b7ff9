//! Actions in wrong order, or repeated.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::{Check, Report, fixture};
use crate::drive::{Instance, LoadedPlugin, RenderRequest, act, new_descriptor};
use crate::host::profile::Profile;
use crate::picture::Rect;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "action_order",
    about: "actions in wrong order or repeated do not crash, and later renders are correct",
    run,
};

// Misuse during wrong sequences is ignored, because the host misbehaves first.
fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    let complete = Profile::complete();
    fixture::with_host(subject, report, complete, |host, plugin, report| {
        let descriptor = new_descriptor(host);
        plugin.set_host(host);
        for action in [
            kOfxActionUnload,
            kOfxActionDescribe,
            kOfxActionDestroyInstance,
            kOfxActionPurgeCaches,
        ] {
            act(plugin, action, descriptor.handle());
        }
        host.take_misuse();
        let loaded = LoadedPlugin::load(host, plugin)?;
        let scene = fixture::scene();
        use_without_create(&loaded)?;
        host.take_misuse();

        let instance = fixture::blurring_instance(&loaded, subject, &scene)?;
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
        let frame = instance.render_checked(&RenderRequest::default())?;
        report.expect_same(&expected, &frame, "after actions in wrong order");
        instance.act(kOfxActionDestroyInstance);
        instance.act(kOfxActionDestroyInstance);
        host.take_misuse();
        drop(instance);
        let frame = fixture::render(&loaded, subject, &scene, &RenderRequest::default())?;
        report.expect_same(&expected, &frame, "after an instance was destroyed twice");
        loaded.unload()
    })
}

/// Uses an instance for which CreateInstance was not called.
fn use_without_create(loaded: &LoadedPlugin<'_>) -> Result<(), String> {
    let scene = fixture::scene();
    let context = loaded.context(&scene)?;
    let descriptor = loaded.describe_in(&context)?;
    let instance = Instance::without_create(loaded, &descriptor, &context, &scene);
    let window = Rect::new(0, 0, 8, 8);
    let _ = instance.update_clip_preferences();
    let _ = instance.identity(0.0, (1.0, 1.0), window);
    let _ = instance.render(&RenderRequest::of_window(window));
    let _ = instance.notify_changed(kOfxTypeClip, "Source", kOfxChangeUserEdited);
    for action in [
        kOfxActionDestroyInstance,
        kOfxActionSyncPrivateData,
        kOfxActionEndInstanceEdit,
        kOfxActionEndInstanceChanged,
        kOfxActionPurgeCaches,
    ] {
        instance.act(action);
    }
    loaded.host.take_misuse();
    Ok(())
}

//! The fixture of all checks: a plugin loaded in a host, scenes, instances that blur.

use std::ffi::CString;

use openfx::sys::image_effect_v1::image_effect::kOfxImageEffectContextGeneral;

use super::Report;
use crate::drive::{Frame, Instance, Library, LoadedPlugin, Plugin, RenderRequest};
use crate::host::profile::Profile;
use crate::host::{ActiveHost, Host};
use crate::picture::{Picture, Rect, plate};
use crate::scene::{Input, Scene};
use crate::subject::{Settings, Subject};

/// The bounds of most pictures: odd, and wider than high.
pub(super) const BOUNDS: Rect = Rect::new(0, 0, 45, 37);

/// Runs `work` on the plugin, loaded in a host of that kind, and unloads it. Misuse of the host becomes faults.
pub(super) fn with_plugin<T>(
    subject: &Subject,
    report: &mut Report,
    profile: Profile,
    work: impl FnOnce(&LoadedPlugin<'_>, &mut Report) -> Result<T, String>,
) -> Result<T, String> {
    with_host(subject, report, profile, |host, plugin, report| {
        let loaded = LoadedPlugin::load(host, plugin)?;
        let result = work(&loaded, report);
        let unloaded = loaded.unload();
        let result = result?;
        unloaded?;
        Ok(result)
    })
}

/// Runs `work` in a host of that kind, with the plugin not yet loaded. Misuse of the host becomes faults.
pub(super) fn with_host<T>(
    subject: &Subject,
    report: &mut Report,
    profile: Profile,
    work: impl FnOnce(&ActiveHost, &Plugin, &mut Report) -> Result<T, String>,
) -> Result<T, String> {
    let library = Library::open(&subject.file)?;
    let host = Host::activate(profile);
    let bundle = subject.file.to_string_lossy().into_owned();
    host.set_path(&CString::new(bundle).unwrap_or_default());
    let result =
        (library.find(subject.id.as_deref())).and_then(|plugin| work(&host, &plugin, report));
    for text in host.take_misuse().into_iter().chain(host.held_resources()) {
        report.fault(text);
    }
    drop(host);
    library.close()?;
    result
}

/// The scene of most checks.
pub(super) fn scene() -> Scene {
    Scene::new(plate(BOUNDS, 4, 1))
}

/// Depth that rises from 1 at the left to 5 at the right. The fourth channel, if any, is 1.
pub(super) fn depth(bounds: Rect, channels: usize) -> Picture {
    Picture::from_fn(bounds, channels, |x, _, c| {
        let depth = 1.0 + 4.0 * (x - bounds.x1) as f32 / bounds.width().max(1) as f32;
        if channels == 4 && c == 3 { 1.0 } else { depth }
    })
}

/// A mask that rises from 0 at the bottom to 1 at the top.
pub(super) fn mask(bounds: Rect) -> Picture {
    Picture::from_fn(bounds, 1, |_, y, _| {
        (y - bounds.y1) as f32 / bounds.height().max(1) as f32
    })
}

/// Creates an instance with the settings that blur.
pub(super) fn blurring_instance<'l>(
    loaded: &'l LoadedPlugin<'l>,
    subject: &Subject,
    scene: &Scene,
) -> Result<Instance<'l>, String> {
    let context = loaded.context(scene)?;
    let instance = Instance::new(loaded, &context, scene)?;
    apply(&instance, subject.kind.blur)?;
    Ok(instance)
}

/// Sets parameters without notifying the plugin.
pub(super) fn apply(instance: &Instance<'_>, settings: Settings) -> Result<(), String> {
    for (name, value) in settings {
        instance.set(name, &value.value())?;
    }
    Ok(())
}

/// Renders a frame on a new instance. It must have no faults.
pub(super) fn render(
    loaded: &LoadedPlugin<'_>,
    subject: &Subject,
    scene: &Scene,
    request: &RenderRequest,
) -> Result<Frame, String> {
    let instance = blurring_instance(loaded, subject, scene)?;
    let frame = instance.render_checked(request)?;
    instance.destroy()?;
    Ok(frame)
}

/// Renders the default scene in the complete host.
pub(super) fn reference(subject: &Subject, report: &mut Report) -> Result<Picture, String> {
    with_plugin(subject, report, Profile::complete(), |loaded, _| {
        let frame = render(loaded, subject, &scene(), &RenderRequest::default())?;
        Ok(frame.picture)
    })
}

/// Connects all clips of the plugin that `scene` does not connect.
pub(super) fn connect_all(loaded: &LoadedPlugin<'_>, mut scene: Scene) -> Result<Scene, String> {
    let bounds = scene.bounds("Source", 0.0).unwrap_or(BOUNDS);
    let context = loaded.context_like(kOfxImageEffectContextGeneral)?;
    let descriptor = loaded.describe_in(&context)?;
    for clip in descriptor.clips() {
        let picture = match clip.name.as_str() {
            "Source" | "Output" => continue,
            "Depth" => depth(bounds, 4),
            "Mask" => mask(bounds),
            _ => plate(bounds, 4, 9),
        };
        scene = scene.connect(&clip.name, Input::still(picture));
    }
    descriptor.invalidate(loaded.host);
    Ok(scene)
}

/// Applies the settings that use Depth and Mask, if they are known.
pub(super) fn use_depth_and_mask(instance: &Instance<'_>, subject: &Subject) -> Result<(), String> {
    for settings in [subject.kind.depth, subject.kind.mask]
        .into_iter()
        .flatten()
    {
        apply(instance, settings)?;
    }
    Ok(())
}

//! What checks have in common: the plugin loaded in a host, a scene, an instance that blurs.

use std::ffi::CString;

use super::Report;
use crate::drive::{Frame, Instance, Library, Loaded, Request};
use crate::host::profile::Profile;
use crate::host::{Entered, Host};
use crate::picture::{Picture, Rect, plate};
use crate::scene::{Input, Scene};
use crate::subject::{Knobs, Subject};

/// The size of most scenes: odd, and wider than high.
pub(super) const SIZE: Rect = Rect::new(0, 0, 45, 37);

/// Does `work` in a host of that kind on the plugin loaded, and unloads it; what the host noticed becomes faults.
pub(super) fn on<T>(
    subject: &Subject,
    report: &mut Report,
    profile: Profile,
    work: impl FnOnce(&Loaded<'_>, &mut Report) -> Result<T, String>,
) -> Result<T, String> {
    within(subject, report, profile, |host, library, report| {
        let plugin = library.find(subject.id.as_deref())?;
        let loaded = Loaded::new(host, &plugin)?;
        let done = work(&loaded, report);
        let unloaded = loaded.unload();
        let done = done?;
        unloaded?;
        Ok(done)
    })
}

/// Does `work` in a host of that kind with the binary open; what the host noticed becomes faults.
pub(super) fn within<T>(
    subject: &Subject,
    report: &mut Report,
    profile: Profile,
    work: impl FnOnce(&Entered, &Library, &mut Report) -> Result<T, String>,
) -> Result<T, String> {
    let library = Library::open(&subject.file)?;
    let host = Host::enter(profile);
    let bundle = subject.file.to_string_lossy().into_owned();
    host.set_path(&CString::new(bundle).unwrap_or_default());
    let done = work(&host, &library, report);
    for text in host.take_misuse().into_iter().chain(host.outstanding()) {
        report.fault(text);
    }
    drop(host);
    library.close()?;
    done
}

/// The usual scene.
pub(super) fn scene() -> Scene {
    Scene::of(plate(SIZE, 4, 1))
}

/// Depth that rises from the left to the right, nearest 1.
pub(super) fn depth(bounds: Rect, channels: usize) -> Picture {
    Picture::made(bounds, channels, |x, _, c| {
        let depth = 1.0 + 4.0 * (x - bounds.x1) as f32 / bounds.width().max(1) as f32;
        if channels == 4 && c == 3 { 1.0 } else { depth }
    })
}

/// A mask that is 0 at the bottom and 1 at the top.
pub(super) fn mask(bounds: Rect) -> Picture {
    Picture::made(bounds, 1, |_, y, _| {
        (y - bounds.y1) as f32 / bounds.height().max(1) as f32
    })
}

/// An instance that blurs.
pub(super) fn blurring<'l>(
    loaded: &'l Loaded<'l>,
    subject: &Subject,
    scene: &Scene,
) -> Result<Instance<'l>, String> {
    let context = loaded.context(scene.inputs.len() > 1)?;
    let instance = Instance::new(loaded, &context, scene)?;
    set(&instance, subject.kind.blur)?;
    Ok(instance)
}

/// Sets parameters as a loaded project has them.
pub(super) fn set(instance: &Instance<'_>, knobs: Knobs) -> Result<(), String> {
    for (name, knob) in knobs {
        instance.set(name, &knob.setting())?;
    }
    Ok(())
}

/// One frame of an instance of its own, without a fault.
pub(super) fn rendered(
    loaded: &Loaded<'_>,
    subject: &Subject,
    scene: &Scene,
    request: &Request,
) -> Result<Frame, String> {
    let instance = blurring(loaded, subject, scene)?;
    let frame = instance.render(request)?.good()?;
    instance.destroy()?;
    Ok(frame)
}

/// The usual frame in the complete host.
pub(super) fn usual(subject: &Subject, report: &mut Report) -> Result<Frame, String> {
    on(subject, report, Profile::complete(), |loaded, _| {
        rendered(loaded, subject, &scene(), &Request::default())
    })
}

/// The scene with every optional clip of the plugin connected.
pub(super) fn with_all(loaded: &Loaded<'_>, scene: Scene) -> Result<Scene, String> {
    let source = scene
        .inputs
        .get("Source")
        .and_then(|input| input.picture(0.0));
    let bounds = source.map_or(SIZE, |picture| picture.bounds);
    let context = loaded.context(true)?;
    let descriptor = loaded.describe_in(&context)?;
    let mut scene = scene;
    for clip in descriptor.clips() {
        let picture = match clip.name.as_str() {
            "Source" | "Output" => continue,
            "Depth" => depth(bounds, 4),
            "Mask" => mask(bounds),
            _ => plate(bounds, 4, 9),
        };
        scene = scene.and(&clip.name, Input::still(picture));
    }
    descriptor.end(loaded.host);
    Ok(scene)
}

/// Has Depth and Mask looked at, where it is known how.
pub(super) fn use_all(instance: &Instance<'_>, subject: &Subject) -> Result<(), String> {
    for knobs in [subject.kind.depth, subject.kind.mask]
        .into_iter()
        .flatten()
    {
        set(instance, knobs)?;
    }
    Ok(())
}

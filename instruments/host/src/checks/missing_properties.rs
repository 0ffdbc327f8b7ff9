//! Hosts that lack a property.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, fixture};
use crate::drive::{LoadedPlugin, RenderRequest};
use crate::host::AccessMode;
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "missing_properties",
    about: "no missing property crashes the plugin, and without any but the essential ones it still renders",
    run,
};

/// Properties without which a plugin may fail.
const ESSENTIAL: [&CStr; 15] = [
    kOfxImagePropData,
    kOfxImagePropBounds,
    kOfxImagePropRowBytes,
    kOfxImageEffectPropComponents,
    kOfxImageEffectPropPixelDepth,
    kOfxImageEffectPropRenderWindow,
    kOfxImageEffectPropContext,
    kOfxImageEffectPropRegionOfInterest,
    kOfxImageEffectPropRegionOfDefinition,
    kOfxImageEffectPropSupportedContexts,
    kOfxImageEffectPropSupportedPixelDepths,
    kOfxImageEffectPropSupportedComponents,
    kOfxPropTime,
    kOfxPropName,
    kOfxPropInstanceData,
];

/// Uses an instance for everything that plugins read or set properties in.
fn use_instance(loaded: &LoadedPlugin<'_>, subject: &Subject) -> Result<(), String> {
    let scene = Scene::new(plate(Rect::new(0, 0, 9, 7), 4, 1));
    let scene = fixture::connect_all(loaded, scene)?;
    let instance = fixture::blurring_instance(loaded, subject, &scene)?;
    for parameter in instance.effect.parameters.all() {
        instance.notify_changed(kOfxTypeParameter, &parameter.name, kOfxChangeUserEdited)?;
    }
    instance.notify_changed(kOfxTypeClip, "Source", kOfxChangeUserEdited)?;
    // One render that uses every input, since this runs once for each property.
    for settings in [subject.kind.depth, subject.kind.mask]
        .into_iter()
        .flatten()
    {
        fixture::apply(&instance, settings)?;
    }
    instance.render_checked(&RenderRequest::default())?;
    instance.destroy()
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let complete = Profile::complete;
    let accesses = fixture::with_plugin(subject, report, complete(), |loaded, _| {
        use_instance(loaded, subject)?;
        Ok(loaded.host.take_accesses())
    })?;
    let is_read = accesses.iter().any(|a| a.mode == AccessMode::Read);
    report.expect(is_read, || "the plugin reads no property".to_owned());
    fixture::with_host(subject, report, complete(), |host, plugin, report| {
        for access in accesses {
            let case = format!(
                "{} cannot be {} on {}",
                access.property, access.mode, access.kind
            );
            let is_essential =
                (ESSENTIAL.iter()).any(|e| e.to_bytes() == access.property.as_bytes());
            host.hide(Some(access));
            let result = LoadedPlugin::load(host, plugin).and_then(|loaded| {
                let used = use_instance(&loaded, subject);
                loaded.unload()?;
                used
            });
            host.hide(None);
            let misuse = host.take_misuse();
            if !is_essential {
                for fault in result.err().into_iter().chain(misuse) {
                    report.fault(format!("{case}: {fault}"));
                }
            }
        }
        Ok(())
    })
}

//! Properties that the host does not have, each in turn.

use std::ffi::CStr;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, stage};
use crate::drive::{Loaded, Request};
use crate::host::profile::Profile;
use crate::picture::{Rect, plate};
use crate::scene::Scene;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "properties",
    about: "any property that is missing crashes nothing, and but for those without which nothing is known the frame is rendered",
    run,
};

/// Without these a plugin may refuse.
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

/// Everything that is called in the life of an instance.
fn life(loaded: &Loaded<'_>, subject: &Subject) -> Result<(), String> {
    let scene = Scene::of(plate(Rect::new(0, 0, 9, 7), 4, 1));
    let scene = stage::with_all(loaded, scene)?;
    let instance = stage::blurring(loaded, subject, &scene)?;
    for parameter in instance.effect.parameters.all() {
        instance.changed(kOfxTypeParameter, &parameter.name, kOfxChangeUserEdited)?;
    }
    instance.changed(kOfxTypeClip, "Source", kOfxChangeUserEdited)?;
    instance.render(&Request::default())?.good()?;
    for knobs in [subject.kind.depth, subject.kind.mask]
        .into_iter()
        .flatten()
    {
        stage::set(&instance, knobs)?;
        instance.render(&Request::default())?.good()?;
    }
    instance.destroy()
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let log = stage::within(subject, report, Profile::complete(), |host, library, _| {
        let plugin = library.find(subject.id.as_deref())?;
        let loaded = Loaded::new(host, &plugin)?;
        life(&loaded, subject)?;
        loaded.unload()?;
        Ok(host.take_log())
    })?;
    report.expect(log.iter().any(|access| !access.set), || {
        "no property is read at all".to_owned()
    });
    stage::within(
        subject,
        report,
        Profile::complete(),
        |host, library, report| {
            let plugin = library.find(subject.id.as_deref())?;
            for access in log {
                let way = if access.set { "set" } else { "read" };
                let title = format!("{} cannot be {way} on {}", access.property, access.kind);
                let essential =
                    (ESSENTIAL.iter()).any(|e| e.to_bytes() == access.property.as_bytes());
                host.hide(Some(access));
                let done = Loaded::new(host, &plugin).and_then(|loaded| {
                    let lived = life(&loaded, subject);
                    loaded.unload()?;
                    lived
                });
                host.hide(None);
                if let (Err(why), false) = (done, essential) {
                    report.fault(format!("{title}: {why}"));
                }
                let misuse = host.take_misuse();
                if !essential {
                    for text in misuse {
                        report.fault(format!("{title}: {text}"));
                    }
                }
            }
            Ok(())
        },
    )
}

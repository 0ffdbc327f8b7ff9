//! Renders that the plugin declares to be the identity.

use openfx::sys::image_effect_v1::image_effect::kOfxImageEffectContextGeneral;

use super::{Check, Report, fixture};
use crate::drive::{Instance, RenderRequest};
use crate::host::locked;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "identity",
    about: "an effect that IsIdentity declares to be the identity copies the clip",
    run,
};

/// Returns whether IsIdentity declares the instance to be the identity. If so, the render must copy the clip.
fn check_identity(
    instance: &Instance<'_>,
    what: &str,
    report: &mut Report,
) -> Result<bool, String> {
    let Some((clip, time)) = instance.identity(0.0, (1.0, 1.0), fixture::BOUNDS)? else {
        return Ok(false);
    };
    let case = format!("{what} is declared to be identical to {clip}");
    let frame = instance.render_checked(&RenderRequest::of_window(fixture::BOUNDS))?;
    let source = locked(&instance.effect.scene).input(&clip).picture(time);
    match source {
        Some(source) => report.expect_same(&source, &frame, &case),
        None => report.fault(format!("{case}, which is not connected")),
    }
    Ok(true)
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let context = loaded.context_like(kOfxImageEffectContextGeneral)?;
        let instance = Instance::new(loaded, &context, &scene)?;
        check_identity(&instance, "a new instance", report)?;
        instance.destroy()?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        check_identity(&instance, "an instance that blurs", report)?;
        instance.destroy()?;
        for settings in subject.kind.identities {
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            fixture::apply(&instance, settings)?;
            let is_identity = check_identity(&instance, &format!("{settings:?}"), report)?;
            report.expect(is_identity, || {
                format!("{settings:?} is not declared to be the identity")
            });
            instance.destroy()?;
        }
        Ok(())
    })
}

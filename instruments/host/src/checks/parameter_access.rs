//! Reads and writes of parameters.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "parameter_access",
    about: "renders read parameters at the time of the frame and set none; other actions set them where allowed",
    run,
};

// The host records wrong accesses as misuse.
fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, _| {
        for scene in [
            fixture::scene(),
            fixture::connect_all(loaded, fixture::scene())?,
        ] {
            let instance = fixture::blurring_instance(loaded, subject, &scene)?;
            instance.act(kOfxActionBeginInstanceEdit);
            instance.render_checked(&RenderRequest::default())?;
            for parameter in instance.effect.parameters.all() {
                for reason in [kOfxChangeUserEdited, kOfxChangePluginEdited, kOfxChangeTime] {
                    instance.notify_changed(kOfxTypeParameter, &parameter.name, reason)?;
                }
            }
            instance.act(kOfxActionEndInstanceEdit);
            instance.act(kOfxActionSyncPrivateData);
            instance.render(&RenderRequest {
                time: 3.0,
                ..RenderRequest::default()
            })?;
            instance.destroy()?;
        }
        Ok(())
    })
}

//! How parameters are read and set.

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::param::*;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "values",
    about: "renders read parameters at their time and set none; other actions do what they may",
    run,
};

// What is done wrongly the host itself notes.
fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, _| {
        for scene in [stage::scene(), stage::with_all(loaded, stage::scene())?] {
            let instance = stage::blurring(loaded, subject, &scene)?;
            instance.act(kOfxActionBeginInstanceEdit);
            instance.render(&Request::default())?.good()?;
            for parameter in instance.effect.parameters.all() {
                for reason in [kOfxChangeUserEdited, kOfxChangePluginEdited, kOfxChangeTime] {
                    instance.changed(kOfxTypeParameter, &parameter.name, reason)?;
                }
            }
            instance.act(kOfxActionEndInstanceEdit);
            instance.act(kOfxActionSyncPrivateData);
            instance.render(&Request {
                time: 3.0,
                ..Request::default()
            })?;
            instance.destroy()?;
        }
        Ok(())
    })
}

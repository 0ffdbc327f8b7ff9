//! Frames that the plugin says it would only copy.

use super::{Check, Report, stage};
use crate::drive::{Instance, Request};
use crate::host::locked;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "identity",
    about: "what is said to change nothing renders the clip as it is",
    run,
};

/// Whether the plugin claims to change nothing; that a claim is wrong is a fault.
fn claim(instance: &Instance<'_>, what: &str, report: &mut Report) -> Result<bool, String> {
    let Some((clip, time)) = instance.identity(0.0, (1.0, 1.0), stage::SIZE)? else {
        return Ok(false);
    };
    let frame = instance
        .render(&Request {
            window: Some(stage::SIZE),
            ..Request::default()
        })?
        .good()?;
    let source = locked(&instance.effect.scene).input(&clip).picture(time);
    match source {
        Some(source) => report.none(
            source.difference(&frame.picture, stage::SIZE),
            &format!("{what} is said to be {clip}"),
        ),
        None => report.fault(format!(
            "{what} is said to be {clip}, which is not connected"
        )),
    }
    Ok(true)
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::with_all(loaded, stage::scene())?;
        let context = loaded.context(true)?;
        let plain = Instance::new(loaded, &context, &scene)?;
        claim(&plain, "an instance as it is made", report)?;
        plain.destroy()?;
        let instance = stage::blurring(loaded, subject, &scene)?;
        claim(&instance, "what blurs", report)?;
        instance.destroy()?;
        for knobs in subject.kind.identities {
            let instance = stage::blurring(loaded, subject, &scene)?;
            stage::set(&instance, knobs)?;
            let claimed = claim(&instance, &format!("{knobs:?}"), report)?;
            report.expect(claimed, || {
                format!("{knobs:?} is not said to change nothing")
            });
            instance.destroy()?;
        }
        Ok(())
    })
}

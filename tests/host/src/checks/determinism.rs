//! The same frame again.

use openfx::sys::generic::core::kOfxActionPurgeCaches;

use super::{Check, Report, stage};
use crate::drive::Request;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "determinism",
    about: "a frame rendered again is the same, bit for bit, whatever was rendered in between",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    stage::on(subject, report, Profile::complete(), |loaded, report| {
        let scene = stage::with_all(loaded, stage::scene())?;
        let instance = stage::blurring(loaded, subject, &scene)?;
        let request = Request::default();
        let first = instance.render(&request)?.good()?;
        let mut again = |what: &str, frame: crate::drive::Frame| {
            report.none(first.picture.difference(&frame.picture, first.window), what);
        };
        again("rendered twice", instance.render(&request)?.good()?);
        let elsewhere = Request {
            time: 7.0,
            ..Request::default()
        };
        instance.render(&elsewhere)?.good()?;
        again("after another time", instance.render(&request)?.good()?);
        instance.act(kOfxActionPurgeCaches);
        again(
            "after caches were purged",
            instance.render(&request)?.good()?,
        );
        again(
            "of another instance",
            stage::rendered(loaded, subject, &scene, &request)?,
        );
        instance.destroy()
    })
}

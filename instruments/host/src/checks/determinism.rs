//! Repeated renders of the same frame.

use openfx::sys::generic::core::kOfxActionPurgeCaches;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "determinism",
    about: "rendering a frame again gives the same bits, whatever was rendered in between",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    fixture::with_plugin(subject, report, Profile::complete(), |loaded, report| {
        let scene = fixture::connect_all(loaded, fixture::scene())?;
        let instance = fixture::blurring_instance(loaded, subject, &scene)?;
        let request = RenderRequest::default();
        let first = instance.render_checked(&request)?.picture;
        let frame = instance.render_checked(&request)?;
        report.expect_same(&first, &frame, "rendered twice");
        instance.render_checked(&RenderRequest {
            time: 7.0,
            ..RenderRequest::default()
        })?;
        let frame = instance.render_checked(&request)?;
        report.expect_same(&first, &frame, "after another time");
        instance.act(kOfxActionPurgeCaches);
        let frame = instance.render_checked(&request)?;
        report.expect_same(&first, &frame, "after caches were purged");
        let frame = fixture::render(loaded, subject, &scene, &request)?;
        report.expect_same(&first, &frame, "on another instance");
        instance.destroy()
    })
}

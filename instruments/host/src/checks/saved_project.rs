//! A project that was saved and opened.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profiles;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "saved_project",
    about: "names in parameters of files that are no files survive a host that makes all paths absolute",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    if subject.kind.references.is_empty() {
        report.skip("no parameters are known that name something else than files");
        return Ok(());
    }
    fixture::with_plugin(subject, report, profiles::natron(), |loaded, report| {
        for settings in subject.kind.references {
            let instance = fixture::blurring_instance(loaded, subject, &fixture::scene())?;
            fixture::apply(&instance, settings)?;
            let request = RenderRequest::default();
            let expected = instance.render_checked(&request)?.picture;
            instance.save_and_open();
            let frame = instance.render_checked(&request);
            instance.destroy()?;
            report.expect_renders_same(&expected, frame, &format!("{settings:?}, saved"));
        }
        Ok(())
    })
}

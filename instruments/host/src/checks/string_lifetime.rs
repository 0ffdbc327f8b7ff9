//! The lifetime of strings that the host lends.

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::StringLifetime;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "string_lifetime",
    about: "strings from the host are not read after the next suite call",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let mut render = |lifetime| {
        fixture::with_plugin(subject, report, Profile::complete(), |loaded, _| {
            loaded.host.set_string_lifetime(lifetime);
            let scene = fixture::connect_all(loaded, fixture::scene())?;
            fixture::render(loaded, subject, &scene, &RenderRequest::default())
        })
    };
    let expected = render(StringLifetime::Object)?;
    let frame = render(StringLifetime::NextCall);
    report.expect_renders_same(
        &expected.picture,
        frame,
        "with strings overwritten at the next call",
    );
    Ok(())
}

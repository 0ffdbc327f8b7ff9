//! Hosts that lack a suite.

use super::{Check, Report, fixture};
use crate::drive::{LoadedPlugin, RenderRequest};
use crate::host::profile::Profile;
use crate::host::suites::{OPTIONAL, REQUIRED};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "missing_suites",
    about: "the picture is the same without optional suites; loading fails without a required one",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    let mut cases: Vec<Vec<_>> = OPTIONAL.iter().map(|suite| vec![*suite]).collect();
    cases.push(OPTIONAL.to_vec());
    for missing_suites in cases {
        let case = format!("without {missing_suites:?}");
        let profile = Profile {
            missing_suites,
            ..Profile::complete()
        };
        let frame = fixture::with_plugin(subject, report, profile, |loaded, _| {
            fixture::render(
                loaded,
                subject,
                &fixture::scene(),
                &RenderRequest::default(),
            )
        });
        report.expect_renders_same(&expected, frame, &case);
    }
    for suite in REQUIRED {
        let profile = Profile {
            missing_suites: vec![(suite, 1)],
            ..Profile::complete()
        };
        fixture::with_host(subject, report, profile, |host, plugin, report| {
            let fails = LoadedPlugin::load(host, plugin).is_err();
            report.expect(fails, || {
                format!("Load and Describe succeed without {suite:?}")
            });
            // Only crashes count here.
            host.take_misuse();
            Ok(())
        })?;
    }
    Ok(())
}

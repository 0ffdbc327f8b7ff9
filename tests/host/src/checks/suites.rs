//! Suites that the host does not have.

use super::{Check, Report, stage};
use crate::drive::{Loaded, Request};
use crate::host::profile::Profile;
use crate::host::suites::{NEEDED, OPTIONAL};
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "suites",
    about: "without any optional suite the picture is the same; without a needed one loading is refused",
    run,
};

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = stage::usual(subject, report)?;
    let mut cases: Vec<Vec<_>> = OPTIONAL.iter().map(|suite| vec![*suite]).collect();
    cases.push(OPTIONAL.to_vec());
    for absent in cases {
        let title = format!("without {absent:?}");
        let profile = Profile {
            absent,
            ..Profile::complete()
        };
        let done = stage::on(subject, report, profile, |loaded, report| {
            let frame = stage::rendered(loaded, subject, &stage::scene(), &Request::default())?;
            report.none(
                expected.picture.difference(&frame.picture, frame.window),
                &title,
            );
            Ok(())
        });
        if let Err(why) = done {
            report.fault(format!("{title}: {why}"));
        }
    }
    for suite in NEEDED {
        let profile = Profile {
            absent: vec![(suite, 1)],
            ..Profile::complete()
        };
        stage::within(subject, report, profile, |host, library, report| {
            let plugin = library.find(subject.id.as_deref())?;
            let refused = Loaded::new(host, &plugin).is_err();
            report.expect(refused, || {
                format!("loads and describes itself without {suite:?}")
            });
            // Nothing but the life of the process is asked for here.
            host.take_misuse();
            Ok(())
        })?;
    }
    Ok(())
}

//! Numbers of threads.

use openfx::sys::image_effect_v1::multi_thread::kOfxMultiThreadSuite;

use super::{Check, Report, fixture};
use crate::drive::RenderRequest;
use crate::host::profile::Profile;
use crate::subject::Subject;

pub(super) static CHECK: Check = Check {
    name: "thread_counts",
    about: "the picture has the same bits for any number of threads",
    run,
};

/// Behaviour of the multi-thread suite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ThreadSuite {
    Parallel,
    Serial,
    Failing,
    Missing,
}

fn run(subject: &Subject, report: &mut Report) -> Result<(), String> {
    let expected = fixture::reference(subject, report)?;
    for (processors, suite) in [
        (1, ThreadSuite::Parallel),
        (2, ThreadSuite::Parallel),
        (3, ThreadSuite::Parallel),
        (8, ThreadSuite::Parallel),
        (0, ThreadSuite::Parallel),
        (4, ThreadSuite::Failing),
        (4, ThreadSuite::Serial),
        (4, ThreadSuite::Missing),
    ] {
        let missing_suites = if suite == ThreadSuite::Missing {
            vec![(kOfxMultiThreadSuite, 1)]
        } else {
            Vec::new()
        };
        let profile = Profile {
            serial_threads: suite == ThreadSuite::Serial,
            missing_suites,
            ..Profile::complete()
        };
        fixture::with_plugin(subject, report, profile, |loaded, report| {
            loaded.host.set_processors(processors);
            if suite == ThreadSuite::Failing {
                loaded.host.fail_threads();
            }
            let request = RenderRequest::default();
            let frame = fixture::render(loaded, subject, &fixture::scene(), &request)?;
            let case = format!("{processors} processors, thread suite {suite:?}");
            report.expect_same(&expected, &frame, &case);
            Ok(())
        })?;
    }
    Ok(())
}
